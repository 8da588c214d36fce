//! The micro step on a critical region: while the active set of the contacts stays, the solution of Eq. 4 is affine and
//! nothing is solved.
//!
//! Within a macro step `H` and `a` are frozen. With the active set `A`, gap terms `t` and `r = w_A + t_A`, the solution
//! of the contact problem is affine in the state and in the interface force λ:
//!
//! ```text
//! P_A  = −H_AA⁻¹ [ r + δ (a_A + H_Ai λ) ]                         region: P_A ≥ 0
//! w_x⁺ = w_x + δ (â_x + Ĥ_xi λ) − H_xA H_AA⁻¹ r                   region: w_x⁺ + t_x ≥ 0       x: inactive contacts, interface
//! w_A⁺ = −t_A
//! â_x  = a_x − H_xA H_AA⁻¹ a_A        Ĥ_xi = H_xi − H_xA H_AA⁻¹ H_Ai
//! ```
//! `1 + n_i` solves per active set are enough for as many micro steps as it lasts. Outside the region the contact
//! problem is solved, and its active set gives the next region. `r` is
//!
//! - zero for a contact that rests;
//! - the old gap's `−g/δ` in the micro step after one that closed, zero from then on;
//! - `−δ (γ/h)² g` for one that is penetrated: it shrinks by `ρ = 1 − γδ/h` from one micro step to the next, alike for
//!   all contacts.
//!
//! One more solve therefore serves for as long as `r` keeps its direction.
//!
//! [`ActiveSetFactor`] holds what differs between dense, sparse and frictional contact problems. Under Coulomb's law
//! the modes (open, stick, slip) take the place of A, and `F_σ K⁻¹ E_σ` that of `H_AA⁻¹`, see
//! [`StateSystem`](crate::friction::StateSystem).
//! # Source
//! Critical regions of a parametric complementarity problem: Bemporad, Morari, Dua, Pistikopoulos, *The explicit linear
//! quadratic regulator for constrained systems* (2002). The decay of `r` is ours.

mod by_contact;
mod coulomb;
mod dense;
mod discretised_model;
mod factor;
mod force_region;
mod law;
mod sparse;
#[cfg(test)]
mod tests;
mod two_rows;

pub use coulomb::ModeFactor;
pub use dense::DenseFactor;
pub use discretised_model::{DiscretisedColumns, DiscretisedModel, LinearModel};
pub use factor::ActiveSetFactor;
pub use force_region::ForceRegion;
pub use law::StepContactLaw;
pub use sparse::SparseSetFactor;

use crate::known_size;
use crate::linear_algebra::largest_entry;
use two_rows::{by_two, put_two, two, with_two};
use wide::f64x2;

/// A row whose pivot is below this part of its diagonal depends on the other active ones; as in the active-set solver.
const DEPENDENT: f64 = 1e-11;
/// Below this part of the velocity that acceleration and force give in a micro step, `r` is rounding.
const NEGLIGIBLE: f64 = 1e-12;
/// Up to this part of it a contact may violate its bound: the natural residual that is accepted of a solver. Contacts
/// that depend on the active ones follow them only to rounding, times the condition of the set: in a heap 1e-10 and
/// more.
const ACCEPTED: f64 = 1e-9;
/// Up to this multiple of the violation that the solver left, a contact may violate its bound as well: dependent
/// contacts with different penetrations cannot all be satisfied, and solving again would change nothing.
const AS_LEFT: f64 = 2.0;
/// Less than this part left of a column is rounding: a contact that depends on the active ones does not move.
const CANCELLED: f64 = 1e-12;
/// A tangent that misses its equations by more than this part is rejected, like the answer of a solver.
const INEXACT: f64 = 1e-9;

/// The state that a micro step changes, contacts in the order of the set, with friction their tangential rows after
/// them.
#[derive(Clone)]
pub struct ModelState {
    /// `w = [w_u; w_i]` at its start, m/s.
    pub w: Box<[f64]>,
    /// `w⁺` at its end, m/s.
    pub w_plus: Box<[f64]>,
    /// Gaps, m.
    pub gap: Box<[f64]>,
    /// Contact impulses `P_u`, N s; those of inactive contacts are zero already.
    pub impulses: Box<[f64]>,
    /// Positions of the interface, m, which follow from its velocities.
    pub position: Box<[f64]>,
}

impl ModelState {
    /// Reserves `contacts` contacts with `rows` rows, and `interface` interface rows.
    pub fn new(contacts: usize, rows: usize, interface: usize) -> Self {
        let [w, gap, impulses, position] =
            [rows + interface, contacts, rows, interface].map(|length| vec![0.0; length].into_boxed_slice());
        ModelState { w_plus: w.clone(), w, gap, impulses, position }
    }
}

/// The affine solution on one critical region: tangents of velocities and impulses with respect to `[1; σ; λ]`.
///
/// The tangent of σ is that of an `r` that was solved for; `σ r` is the one of the present micro step.
#[derive(Clone)]
pub struct AffineStep<F> {
    known: bool,
    /// Micro steps taken.
    steps: u64,
    rows: usize,
    interface: usize,
    /// `A`.
    active: Vec<usize>,
    factor: F,
    /// Columns `δ â`, `−H_·A H_AA⁻¹ r`, `δ Ĥ_·i`: changes of velocities. At active rows the second is `−r`, the others
    /// are zero.
    velocities: Vec<f64>,
    /// Columns `−δ H_AA⁻¹ a_A`, `−H_AA⁻¹ r`, `−δ H_AA⁻¹ H_Ai`: impulses of the active rows.
    impulses: Vec<f64>,
    /// Largest entries of `δ a_u`, of `r`, and of each column of `δ H_ui`: the size of velocities.
    scales: Vec<f64>,
    /// Constraint violation that the solver left, m/s.
    violation_left: f64,
    /// σ, and its factor ρ from one micro step to the next.
    sigma: f64,
    decay: f64,
    /// `r` of this micro step by active rows.
    r: Vec<f64>,
}

impl<F: ActiveSetFactor> AffineStep<F> {
    /// Reserves `rows` contact rows and `interface` interface rows.
    pub fn new(rows: usize, interface: usize, factor: F) -> Self {
        let columns = interface + 2;
        AffineStep {
            known: false,
            steps: 0,
            rows: 0,
            interface,
            active: Vec::with_capacity(rows),
            factor,
            velocities: vec![0.0; (rows + interface) * columns],
            impulses: vec![0.0; rows * columns],
            scales: vec![0.0; columns],
            violation_left: 0.0,
            sigma: 0.0,
            decay: 1.0,
            r: vec![0.0; rows],
        }
    }

    /// Leaves the region, as model or active set are no longer those of the tangents; velocities and gaps are then
    /// those of all contacts.
    #[inline]
    pub fn leave_region(&mut self, law: &StepContactLaw, w: &mut [f64], gap: &mut [f64]) {
        F::end_skips(self, law, w, gap);
        self.known = false;
    }

    /// Tells whether there are tangents.
    #[inline]
    pub fn is_known(&self) -> bool {
        self.known
    }

    /// Returns the number of micro steps taken so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Finds the tangents for an active set; there are none if its rows depend on each other. `violation_left` (m/s) is
    /// what the solver left in the micro step that it solved.
    pub fn linearise(
        &mut self,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        active: F::Active<'_>,
        violation_left: f64,
    ) {
        (self.rows, self.violation_left) = (model.contacts(), violation_left);
        self.active.clear();
        if self.factor.factorise(model, active, &mut self.active) {
            self.find_tangents(model, law);
        }
    }

    fn find_tangents(&mut self, model: &DiscretisedModel, law: &StepContactLaw) {
        let (n, k) = (self.rows, self.active.len());
        let rows = n + self.interface;
        self.known = true;
        for j in 0..=self.interface {
            // The column of r stands between that of a and those of the forces.
            let (column, at) =
                if j == 0 { (model.free_increment(rows), 0) } else { (model.force_column(j - 1, rows), j + 1) };
            let (velocities, impulses) = (&mut self.velocities[at * rows..][..rows], &mut self.impulses[at * n..][..k]);
            self.scales[at] = largest_entry(&column[..n]);
            self.known &= find_tangent(model, &self.active, &mut self.factor, column, velocities, impulses);
            self.factor.record_tangent(at, &self.active, impulses);
        }
        self.decay = 1.0 - law.rates.closed * law.gap_step;
        self.reset_r();
    }

    /// Sets `r = 0`.
    fn reset_r(&mut self) {
        let (n, rows) = (self.rows, self.rows + self.interface);
        (self.sigma, self.scales[1]) = (0.0, 0.0);
        self.velocities[rows..2 * rows].fill(0.0);
        self.impulses[n..2 * n].fill(0.0);
        self.factor.record_tangent(1, &[], &[]);
    }

    /// Takes a micro step without a look at the contacts, if that is known to stay in the region; of `w_plus` then only
    /// interface rows are those at its end.
    #[inline(always)]
    pub fn skip(&mut self, law: &StepContactLaw, lambda: &[f64], state: &mut ModelState) -> bool {
        F::skip(self, law, lambda, state)
    }

    /// Takes a micro step under the force `lambda` (N) inside the region, with `remaining` more to come; `w_plus`, gaps
    /// and impulses are then those at its end. Returns false outside of the region, where only `w_plus` and the
    /// impulses have lost their meaning.
    #[inline]
    pub fn step(
        &mut self,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        lambda: &[f64],
        remaining: usize,
        state: &mut ModelState,
    ) -> bool {
        let stays = self.step_in_region(model, law, lambda, state);
        if stays {
            F::bound_skips(self, law, lambda, remaining, state);
        }
        stays
    }

    /// One text for all sizes. With one force and a few contacts the compiler knows the size, which takes a third of
    /// the instructions.
    #[inline]
    fn step_in_region(
        &mut self,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        lambda: &[f64],
        state: &mut ModelState,
    ) -> bool {
        let Ok(&force) = <&[f64; 1]>::try_from(lambda) else {
            return self.step_of_any(model, law, lambda, state);
        };
        if F::MANY {
            return self.step_of_more(model, law, force, state);
        }
        known_size!(
            self.rows,
            N if N <= 4 || (F::ROWS == 2 && N <= 8) => self.step_of_few::<N>(model, law, force, state),
            0 => self.step_of_few::<0>(model, law, force, state),
            _ => self.step_of_more(model, law, force, state),
        )
    }

    #[inline(never)]
    fn step_of_more(
        &mut self,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        force: [f64; 1],
        state: &mut ModelState,
    ) -> bool {
        self.step_of_size(self.rows, model, law, &force, state)
    }

    #[inline(never)]
    fn step_of_any(
        &mut self,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        lambda: &[f64],
        state: &mut ModelState,
    ) -> bool {
        self.step_of_size(self.rows, model, law, lambda, state)
    }

    #[inline(never)]
    fn step_of_few<const N: usize>(
        &mut self,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        force: [f64; 1],
        state: &mut ModelState,
    ) -> bool {
        self.step_of_size(N, model, law, &force, state)
    }

    #[inline(always)]
    fn step_of_size(
        &mut self,
        n: usize,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        lambda: &[f64],
        state: &mut ModelState,
    ) -> bool {
        let rows = n + lambda.len();
        let ModelState { w, w_plus, gap, impulses, .. } = state;
        // Tangential rows have no gaps.
        let (w, w_plus, gap, impulses) = (&w[..rows], &mut w_plus[..rows], &mut gap[..n / F::ROWS], &mut impulses[..n]);
        self.sigma *= self.decay;
        let mut tolerance = self.tolerance(self.sigma, lambda);
        // A force that is not finite is left to the solver, which reports it.
        let is_finite = tolerance < f64::INFINITY;
        if !is_finite || law.restitution > 0.0 && law.closes(w, gap, tolerance) {
            return false;
        }
        if F::ROWS == 2 && self.admits_zero(model, law, w, lambda, gap) {
            return false;
        }
        self.velocities_after(w, lambda, w_plus);
        if !F::is_in_region(self, law, w_plus, gap, tolerance) {
            let Some(updated) = self.step_with_other_r(model, law, lambda, [w, gap], w_plus, tolerance) else {
                return false;
            };
            tolerance = updated;
        }
        if !F::write_impulses(self, model, lambda, w_plus, impulses, tolerance) {
            return false;
        }
        by_two!(gap.len(), of => {
            let next = two(gap, of) + f64x2::splat(law.gap_step) * two(w_plus, of);
            put_two(gap, of, next);
        });
        self.steps += 1;
        true
    }

    /// Takes the micro step where either r has another direction, or another contact closes; none then. Returns the
    /// tolerance.
    #[cold]
    fn step_with_other_r(
        &mut self,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        lambda: &[f64],
        [w, gap]: [&[f64]; 2],
        w_plus: &mut [f64],
        tolerance: f64,
    ) -> Option<f64> {
        if !self.update_r(model, law, w, gap, tolerance) {
            return None;
        }
        let tolerance = self.tolerance(self.sigma, lambda);
        self.velocities_after(w, lambda, w_plus);
        if F::MANY {
            // Where `r` was too small to be solved for.
            self.active.iter().for_each(|&contact| w_plus[contact] = -law.gap_term(gap, contact));
        }
        (!law.is_violated(w_plus, gap, self.accepted(tolerance))).then_some(tolerance)
    }

    /// Tells whether zero impulses solve a problem with friction as well; a solver would prefer them.
    #[inline(always)]
    fn admits_zero(
        &self,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        w: &[f64],
        lambda: &[f64],
        gap: &[f64],
    ) -> bool {
        let rows = w.len();
        !self.active.is_empty()
            && gap.iter().enumerate().all(|(contact, gap)| {
                let mut free = w[contact] + model.free_increment(rows)[contact] + law.rates.velocity(*gap);
                for (j, force) in lambda.iter().enumerate() {
                    free += force * model.force_column(j, rows)[contact];
                }
                free >= 0.0
            })
    }

    /// Returns the rounding of the velocities that a micro step with this σ gives, m/s.
    #[inline(always)]
    fn tolerance(&self, sigma: f64, lambda: &[f64]) -> f64 {
        let (free, scales) = self.scales[..lambda.len() + 2].split_at(2);
        let mut sum = free[0] + (sigma * free[1]).abs();
        for (force, scale) in lambda.iter().zip(scales) {
            sum += (force * scale).abs();
        }
        F::NEGLIGIBLE * sum
    }

    /// Returns the violation that is accepted of a contact, m/s.
    #[inline(always)]
    fn accepted(&self, tolerance: f64) -> f64 {
        (ACCEPTED / F::NEGLIGIBLE) * tolerance + AS_LEFT * self.violation_left
    }

    /// Writes `w⁺`.
    #[inline(always)]
    fn velocities_after(&self, w: &[f64], lambda: &[f64], w_plus: &mut [f64]) {
        let rows = w.len();
        let (free, columns) = self.velocities[..rows * (lambda.len() + 2)].split_at(rows);
        let (of_r, forces) = columns.split_at(rows);
        let sigma = f64x2::splat(self.sigma);
        by_two!(rows, of => {
            let start = two(w, of) + two(free, of) + sigma * two(of_r, of);
            put_two(w_plus, of, with_two(start, lambda, forces, rows, of));
        });
    }

    /// Returns the active rows with their impulses.
    #[inline(always)]
    fn active_impulses(&self, lambda: &[f64], n: usize) -> impl Iterator<Item = (usize, f64)> {
        let (free, columns) = self.impulses[..n * (lambda.len() + 2)].split_at(n);
        let (of_r, forces) = columns.split_at(n);
        let sigma = self.sigma;
        self.active.iter().zip(free).zip(of_r).enumerate().map(move |(slot, ((&row, free), of_r))| {
            let mut impulse = free + sigma * of_r;
            for (force, column) in lambda.iter().zip(forces.chunks_exact(n)) {
                impulse += force * column[slot];
            }
            (row, impulse)
        })
    }

    /// Finds a new direction of `r` from the state, and its tangent unless it is zero; false if σ times the old one was
    /// right.
    fn update_r(
        &mut self,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        w: &[f64],
        gap: &[f64],
        tolerance: f64,
    ) -> bool {
        let (n, rows, k) = (self.rows, w.len(), self.active.len());
        let (of_r, impulses) = (&mut self.velocities[rows..2 * rows], &mut self.impulses[n..n + k]);
        let mut as_foreseen = true;
        for (r, &row) in self.r[..k].iter_mut().zip(&self.active) {
            *r = w[row] + law.gap_term(gap, row);
            as_foreseen &= (*r + self.sigma * of_r[row]).abs() <= tolerance;
        }
        if as_foreseen {
            return false;
        }
        if F::MANY {
            // As part of the direction of `r`, rounding would return with the opposite sign a few micro steps later,
            // and again, each time with a solve.
            for (r, &contact) in self.r[..k].iter_mut().zip(&self.active) {
                let decaying = law.decaying_part(self.decay, gap[contact]);
                if (*r - decaying).abs() <= tolerance {
                    *r = decaying;
                }
            }
        }
        let r = &self.r[..k];
        let scale = largest_entry(r);
        if scale <= tolerance {
            self.reset_r();
            return true;
        }
        impulses.copy_from_slice(r);
        self.factor.solve(&self.active, impulses);
        of_r.fill(0.0);
        for (&row, impulse) in self.active.iter().zip(&mut *impulses) {
            *impulse = -*impulse;
            self.factor.add_impulse(model, row, *impulse, of_r);
        }
        self.factor.record_tangent(1, &self.active, impulses);
        // To the digit, so that no rounding is left for the next micro step.
        for (&row, r) in self.active.iter().zip(r) {
            of_r[row] = -r;
        }
        (self.sigma, self.scales[1]) = (1.0, scale);
        true
    }
}

/// Writes the impulses `−H_AA⁻¹ c_A` and the velocities `c_x − H_xA H_AA⁻¹ c_A` that follow a column c; returns whether
/// they are as exact as a solved problem must be. At active rows no velocity is left.
fn find_tangent<F: ActiveSetFactor>(
    model: &DiscretisedModel,
    active: &[usize],
    factor: &mut F,
    column: &[f64],
    velocities: &mut [f64],
    impulses: &mut [f64],
) -> bool {
    for (impulse, &row) in impulses.iter_mut().zip(active) {
        *impulse = column[row];
    }
    factor.solve(active, impulses);
    velocities.copy_from_slice(column);
    for (impulse, &row) in impulses.iter_mut().zip(active) {
        *impulse = -*impulse;
        factor.add_impulse(model, row, *impulse, velocities);
    }
    let error = active.iter().fold(0.0, |worst: f64, &row| worst.max(velocities[row].abs()));
    let exact = error <= INEXACT * active.iter().fold(0.0, |most: f64, &row| most.max(column[row].abs()));
    for &row in active {
        velocities[row] = 0.0;
    }
    for (velocity, column) in velocities.iter_mut().zip(column) {
        if velocity.abs() <= CANCELLED * column.abs() {
            *velocity = 0.0;
        }
    }
    exact
}
