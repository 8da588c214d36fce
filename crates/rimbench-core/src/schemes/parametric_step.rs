//! The micro step as a parametric problem: while the active set of the contacts stays the same, nothing is to be solved.
//!
//! Within a macro step `H` and `a` are frozen. With `A` the contacts that push, `t` the gap terms and `r = w_A + t_A`, the answer of
//! the contacts is affine in the state and in the force λ of the actuator:
//!
//! ```text
//! P_A  = −H_AA⁻¹ [ r + δ (a_A + H_Ai λ) ]                         must be ≥ 0
//! w_x⁺ = w_x + δ (â_x + Ĥ_xi λ) − H_xA H_AA⁻¹ r                   w_x⁺ + t_x must be ≥ 0       x: open contacts, interface
//! w_A⁺ = −t_A
//! â_x  = a_x − H_xA H_AA⁻¹ a_A        Ĥ_xi = H_xi − H_xA H_AA⁻¹ H_Ai
//! ```
//! So `1 + n_i` solves per active set are enough for as many micro steps as it lasts; where a condition fails, the contact problem is
//! solved, and what it finds is the next set. `r` is
//!
//! - zero for a contact that rests;
//! - the old gap's `−g/δ` in the micro step after one that closed, zero from then on;
//! - `−δ (γ/h)² g` for one that is penetrated: from one micro step to the next it shrinks by `ρ = 1 − γδ/h`, for all of them alike.
//!
//! One solve more therefore serves for as long as `r` keeps its direction. `A` are the contacts with `P > 0` of the last problem.
//!
//! With friction it is the states σ of the last problem that stay the same, `E_σ` and `F_σ` in the place of A, see
//! [`StateSystem`](crate::friction::StateSystem), and what is checked besides is what the states say:
//!
//! ```text
//! P    = −F_σ K⁻¹ E_σ [ r + δ (a + H_·i λ) ]          |P_t| ≤ μ P_n (stick)      ±w_t⁺ ≥ 0 (slip)
//! w⁺   = w + δ (a + H_·i λ) + H P                     and P = 0 must not do: who solves would take that
//! ```

mod outlook;

use self::outlook::Outlook;
use super::packed_model::{PackedModel, add_multiple};
use crate::friction::{ContactState, StateSystem};
use crate::interface_model::GapRates;
use crate::linear_algebra::{Factor, SparseFactor, largest_entry};

/// A member whose pivot is below this part of its diagonal depends on the others; as in the active set.
const DEPENDENT: f64 = 1e-11;
/// Below this part of the velocity that acceleration and force give in a micro step, `r` is rounding.
const NEGLIGIBLE: f64 = 1e-12;
/// The same with many contacts: gaps of a heap give a part of 1e-12 of rounding, divided by the micro step, back and forth, and to look at
/// `r` for that takes a solve each time. What stays is a tenth of the residual accepted of a solver, and is looked at once gaps have
/// added it up.
const NEGLIGIBLE_OF_MANY: f64 = 1e-10;
/// Up to this part of it a contact may go too far: as the natural residual that is accepted of a solver. Contacts that depend on
/// those that push go along with them only to rounding, times the condition of the set: in a heap 1e-10 and more.
const ACCEPTED: f64 = 1e-9;
/// And by so many times what the solver itself had to leave: dependent contacts that are penetrated by different amounts cannot all have
/// their way, and to solve again would change nothing.
const AS_LEFT: f64 = 2.0;
/// What is left of less than this part is rounding: a contact that depends on those that push does not move.
const CANCELLED: f64 = 1e-12;
/// A response that misses its equations by more than this part is none; as the answer of a solver.
const INEXACT: f64 = 1e-9;

/// What gaps do in the micro steps of a macro step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct GapMotion {
    /// The gap terms.
    pub(super) rates: GapRates,
    /// By how much a velocity changes a gap, s: δ, or 0 where gaps stand.
    pub(super) advance: f64,
    /// Restitution of contacts that close within `closing_time` (s).
    pub(super) restitution: f64,
    pub(super) closing_time: f64,
}

/// The state that a micro step changes.
pub(super) struct MicroState<'a> {
    /// `[w_u; w_i]` at its start, and room for those at its end.
    pub(super) w: &'a [f64],
    pub(super) next: &'a mut [f64],
    pub(super) gap: &'a mut [f64],
    /// Contact impulses; those of other contacts than the members are zero already.
    pub(super) impulses: &'a mut [f64],
}

/// `H_AA`, factorised.
#[derive(Clone)]
enum SetFactor {
    Dense(Box<Factor>),
    /// Where few of many contacts meet.
    Sparse(Box<ManyContacts>),
    /// With friction: `K`.
    States(Box<StateFactor>),
}

/// The factor of few of many contacts, and what is looked at in every micro step by contacts instead of members: one pass in order is
/// several times as fast.
#[derive(Clone)]
struct ManyContacts {
    factor: SparseFactor,
    column: Vec<f64>,
    /// 1 for members, 0 for others.
    member: Vec<f64>,
    /// The columns of the members' impulses, zero for others.
    impulses: Vec<f64>,
    outlook: Outlook,
}

impl ManyContacts {
    fn new(factor: SparseFactor, contacts: usize, interface: usize) -> Self {
        ManyContacts {
            factor,
            column: vec![0.0; contacts],
            member: vec![0.0; contacts],
            impulses: vec![0.0; contacts * (interface + 2)],
            outlook: Outlook::new(contacts),
        }
    }

    /// Takes the impulses of the members in column `at`.
    fn take(&mut self, at: usize, set: &[usize], impulses: &[f64]) {
        let n = self.member.len();
        let column = &mut self.impulses[at * n..(at + 1) * n];
        column.fill(0.0);
        set.iter().zip(impulses).for_each(|(&contact, impulse)| column[contact] = *impulse);
    }
}

/// The equations of the states of contacts with friction.
#[derive(Clone)]
struct StateFactor {
    system: StateSystem,
    states: Vec<ContactState>,
    friction: Vec<f64>,
}

impl SetFactor {
    /// Replaces `x`, by members, by `H_AA⁻¹ x`.
    fn solve(&mut self, set: &[usize], x: &mut [f64]) {
        match self {
            SetFactor::Dense(factor) => factor.solve(x),
            SetFactor::Sparse(many) => {
                let ManyContacts { factor, column, .. } = &mut **many;
                set.iter().zip(&*x).for_each(|(&contact, x)| column[contact] = *x);
                factor.solve(column);
                set.iter().zip(x).for_each(|(&contact, x)| *x = column[contact]);
            }
            SetFactor::States(factor) => factor.system.solve(x),
        }
    }

    /// Adds to `w` what the impulse of one member gives, with friction that of a contact that slides included.
    fn push(&self, model: &PackedModel, row: usize, impulse: f64, w: &mut [f64]) {
        model.add_impulse(row, impulse, w);
        if let SetFactor::States(factor) = self
            && let Some(state) = factor.states.get(row)
            && state.friction() != 0.0
        {
            let along = state.friction() * factor.friction[row] * impulse;
            model.add_impulse(factor.states.len() + row, along, w);
        }
    }
}

/// The response of the contacts for one active set: what `[1; σ; λ]` is multiplied by.
///
/// One column is that of an `r` that was solved for; `σ r` is the one of the present micro step.
#[derive(Clone)]
pub(super) struct ParametricStep {
    known: bool,
    /// Micro steps taken.
    steps: u64,
    contacts: usize,
    interface: usize,
    /// `A`.
    set: Vec<usize>,
    factor: SetFactor,
    /// Columns `δ â`, `−H_·A H_AA⁻¹ r`, `δ Ĥ_·i`: what velocities change by. At members the second is `−r`, the others are zero.
    velocities: Vec<f64>,
    /// Columns `−δ H_AA⁻¹ a_A`, `−H_AA⁻¹ r`, `−δ H_AA⁻¹ H_Ai`: impulses of the members.
    impulses: Vec<f64>,
    /// Largest `δ |a_u|`, of `r`, and of each column of `δ H_ui`: how large velocities are.
    scales: Vec<f64>,
    /// By how much contacts went too far in the micro step that was solved, m/s.
    left: f64,
    /// σ, and what becomes of it from one micro step to the next, ρ.
    factor_of_r: f64,
    decay: f64,
    /// What is rounding, as a part of the velocities that a micro step gives, and how much more a contact may go too far.
    negligible: f64,
    accepted: f64,
    /// `r` of this micro step by members, with many contacts what of it is to be solved for.
    r: Vec<f64>,
}

impl ParametricStep {
    /// Makes room for `contacts` contacts and `interface` interface rows.
    pub(super) fn new(contacts: usize, interface: usize) -> Self {
        Self::with_factor(contacts, interface, SetFactor::Dense(Box::new(Factor::new(contacts))))
    }

    /// The same with the order and pattern of this factor, where few of many contacts meet.
    pub(super) fn sparse(contacts: usize, interface: usize, factor: &SparseFactor) -> Self {
        Self::with_factor(
            contacts,
            interface,
            SetFactor::Sparse(Box::new(ManyContacts::new(factor.clone(), contacts, interface))),
        )
    }

    /// The same for contacts with friction.
    pub(super) fn with_friction(contacts: usize, interface: usize) -> Self {
        let factor = StateFactor {
            system: StateSystem::new(contacts),
            states: Vec::with_capacity(contacts),
            friction: Vec::with_capacity(contacts),
        };
        Self::with_factor(2 * contacts, interface, SetFactor::States(Box::new(factor)))
    }

    fn with_factor(contacts: usize, interface: usize, factor: SetFactor) -> Self {
        let columns = interface + 2;
        let negligible = if let SetFactor::Sparse(..) = factor { NEGLIGIBLE_OF_MANY } else { NEGLIGIBLE };
        ParametricStep {
            known: false,
            steps: 0,
            contacts: 0,
            interface,
            set: Vec::with_capacity(contacts),
            factor,
            velocities: vec![0.0; (contacts + interface) * columns],
            impulses: vec![0.0; contacts * columns],
            scales: vec![0.0; columns],
            left: 0.0,
            factor_of_r: 0.0,
            decay: 1.0,
            negligible,
            accepted: ACCEPTED / negligible,
            r: vec![0.0; contacts],
        }
    }

    /// Says that model or active set are no longer those of the response.
    #[inline]
    pub(super) fn forget(&mut self) {
        self.known = false;
        if let SetFactor::Sparse(many) = &mut self.factor {
            many.outlook.forget();
        }
    }

    /// Tells whether there is a response.
    #[inline]
    pub(super) fn is_known(&self) -> bool {
        self.known
    }

    /// Micro steps taken so far.
    pub(super) fn steps(&self) -> u64 {
        self.steps
    }

    /// Finds the response for the contacts that carry one of these impulses. There is none if they depend on each other. `left` is by how
    /// much contacts went too far in the micro step that was solved (m/s); `solved` the factor of the set that was found with them, where
    /// few of many contacts meet.
    pub(super) fn find(
        &mut self,
        model: &PackedModel,
        motion: &GapMotion,
        impulses: &[f64],
        left: f64,
        solved: Option<&SparseFactor>,
    ) {
        let n = model.contacts();
        (self.contacts, self.left) = (n, left);
        self.set.clear();
        match (&mut self.factor, solved) {
            (SetFactor::Sparse(many), Some(solved)) => {
                let ManyContacts { factor, column, member, .. } = &mut **many;
                column.fill(0.0);
                member.fill(0.0);
                // Where nothing pushes no set was looked at.
                if impulses.iter().any(|impulse| *impulse > 0.0) {
                    // Members that carry nothing at the moment stay.
                    factor.copy_from(solved);
                    self.set.extend((0..n).filter(|&contact| solved.contains(contact)));
                    self.set.iter().for_each(|&contact| member[contact] = 1.0);
                }
            }
            (SetFactor::Sparse(..), None) | (SetFactor::States(_), _) => return,
            (SetFactor::Dense(factor), _) => {
                factor.clear(n);
                for (contact, &impulse) in impulses.iter().enumerate() {
                    if impulse > 0.0 {
                        let d = factor.border(model.h_uu(), &self.set, contact);
                        if d.is_nan() || d <= DEPENDENT * model.h_uu()[contact * n + contact] {
                            return;
                        }
                        factor.push(d);
                        self.set.push(contact);
                    }
                }
            }
        }
        self.find_response(model, motion);
    }

    /// The same with friction: for contacts in these states.
    pub(super) fn find_of_states(
        &mut self,
        model: &PackedModel,
        motion: &GapMotion,
        states: &[ContactState],
        friction: &[f64],
        left: f64,
    ) {
        let n = model.contacts();
        (self.contacts, self.left) = (n, left);
        let SetFactor::States(factor) = &mut self.factor else { return };
        factor.states.clear();
        factor.states.extend_from_slice(states);
        factor.friction.clear();
        factor.friction.extend_from_slice(friction);
        factor.system.factorise(friction, states, |row| &model.h_uu()[row * n..(row + 1) * n]);
        self.set.clear();
        self.set.extend_from_slice(factor.system.rows());
        self.find_response(model, motion);
    }

    /// Finds the response of the members, which have been factorised.
    fn find_response(&mut self, model: &PackedModel, motion: &GapMotion) {
        let (n, k) = (self.contacts, self.set.len());
        let rows = n + self.interface;
        self.known = true;
        for j in 0..=self.interface {
            // The column of r stands between that of a and those of the forces.
            let (column, at) = if j == 0 { (model.drift(rows), 0) } else { (model.force_column(j - 1, rows), j + 1) };
            let (velocities, impulses) = (&mut self.velocities[at * rows..][..rows], &mut self.impulses[at * n..][..k]);
            self.scales[at] = largest_entry(&column[..n]);
            self.known &= respond(model, &self.set, &mut self.factor, column, velocities, impulses);
            if let SetFactor::Sparse(many) = &mut self.factor {
                many.take(at, &self.set, impulses);
            }
        }
        self.decay = 1.0 - motion.rates.closed * motion.advance;
        self.set_r_aside();
    }

    /// From here on `r = 0`.
    fn set_r_aside(&mut self) {
        let (n, rows) = (self.contacts, self.contacts + self.interface);
        (self.factor_of_r, self.scales[1]) = (0.0, 0.0);
        self.velocities[rows..2 * rows].fill(0.0);
        self.impulses[n..2 * n].fill(0.0);
        if let SetFactor::Sparse(many) = &mut self.factor {
            many.take(1, &[], &[]);
        }
    }

    /// Takes a micro step under the force `lambda` if the active set stays the same: `next`, gaps and impulses are then those at its end.
    /// If not, only `next` and the impulses have lost their meaning.
    ///
    /// With FRICTION impulses are `[P_n; P_t]`. The same text for all sizes; one force and a few contacts are a size that the compiler
    /// knows, for half of the instructions.
    #[inline]
    pub(super) fn step<const FRICTION: bool>(
        &mut self,
        model: &PackedModel,
        motion: &GapMotion,
        lambda: &[f64],
        state: MicroState<'_>,
    ) -> bool {
        let Ok(&force) = <&[f64; 1]>::try_from(lambda) else {
            return self.step_of_size::<FRICTION>(self.contacts, model, motion, lambda, state);
        };
        match self.contacts {
            0 => self.step_of_few::<FRICTION, 0>(model, motion, force, state),
            1 => self.step_of_few::<FRICTION, 1>(model, motion, force, state),
            2 => self.step_of_few::<FRICTION, 2>(model, motion, force, state),
            3 => self.step_of_few::<FRICTION, 3>(model, motion, force, state),
            4 => self.step_of_few::<FRICTION, 4>(model, motion, force, state),
            // Three and four contacts with two rows each.
            6 if FRICTION => self.step_of_few::<FRICTION, 6>(model, motion, force, state),
            8 if FRICTION => self.step_of_few::<FRICTION, 8>(model, motion, force, state),
            n => self.step_of_size::<FRICTION>(n, model, motion, &force, state),
        }
    }

    #[inline(never)]
    fn step_of_few<const FRICTION: bool, const N: usize>(
        &mut self,
        model: &PackedModel,
        motion: &GapMotion,
        force: [f64; 1],
        state: MicroState<'_>,
    ) -> bool {
        self.step_of_size::<FRICTION>(N, model, motion, &force, state)
    }

    #[inline(always)]
    fn step_of_size<const FRICTION: bool>(
        &mut self,
        n: usize,
        model: &PackedModel,
        motion: &GapMotion,
        lambda: &[f64],
        state: MicroState<'_>,
    ) -> bool {
        let rows = n + lambda.len();
        let MicroState { w, next, gap, impulses } = state;
        // Tangential rows have no gaps.
        let gaps = if FRICTION { n / 2 } else { n };
        let (w, next, gap, impulses) = (&w[..rows], &mut next[..rows], &mut gap[..gaps], &mut impulses[..n]);
        self.factor_of_r *= self.decay;
        let mut tolerance = self.tolerance(lambda);
        // A force that is not finite is for the solver to complain about.
        if !tolerance.is_finite() || motion.restitution > 0.0 && closes(motion, w, gap, tolerance) {
            return false;
        }
        if FRICTION && self.is_solved_by_zero(model, motion.rates, w, lambda, gap) {
            return false;
        }
        self.velocities_after(w, lambda, next);
        let few = FRICTION || !matches!(self.factor, SetFactor::Sparse(..));
        let as_foreseen = if few {
            !violates(motion.rates, next, gap, self.accepted(tolerance))
                && self.rests(motion.rates, next, gap, tolerance)
        } else {
            self.goes_as_foreseen(motion.rates, next, gap, tolerance)
        };
        if !as_foreseen {
            // Either r is not as foreseen, or another contact closes.
            if !self.foresee_anew(model, motion, w, gap, tolerance) {
                return false;
            }
            tolerance = self.tolerance(lambda);
            self.velocities_after(w, lambda, next);
            if !few {
                // What was too little to be solved for is taken out all the same.
                self.set.iter().for_each(|&contact| next[contact] = -gap_velocity(motion.rates, gap, contact));
            }
            if violates(motion.rates, next, gap, self.accepted(tolerance)) {
                return false;
            }
        }
        let fits = if FRICTION {
            self.frictional_impulses_after(model, lambda, next, impulses, tolerance)
        } else if !few {
            self.many_impulses_after(lambda, impulses)
        } else {
            self.impulses_after(lambda, impulses)
        };
        if !fits {
            return false;
        }
        for (gap, w) in gap.iter_mut().zip(&*next) {
            *gap += motion.advance * w;
        }
        self.steps += 1;
        true
    }

    /// What is rounding beside the velocities that a micro step gives, m/s.
    #[inline(always)]
    fn tolerance(&self, lambda: &[f64]) -> f64 {
        self.tolerance_with(self.factor_of_r, lambda)
    }

    /// The same with another σ.
    #[inline(always)]
    fn tolerance_with(&self, sigma: f64, lambda: &[f64]) -> f64 {
        let (free, scales) = self.scales[..lambda.len() + 2].split_at(2);
        let mut sum = free[0] + (sigma * free[1]).abs();
        for (force, scale) in lambda.iter().zip(scales) {
            sum += (force * scale).abs();
        }
        self.negligible * sum
    }

    /// By how much a contact may go too far, m/s.
    #[inline(always)]
    fn accepted(&self, tolerance: f64) -> f64 {
        self.accepted * tolerance + AS_LEFT * self.left
    }

    /// Writes `w⁺`.
    #[inline(always)]
    fn velocities_after(&self, w: &[f64], lambda: &[f64], next: &mut [f64]) {
        let rows = w.len();
        let (drift, columns) = self.velocities[..rows * (lambda.len() + 2)].split_at(rows);
        let (of_r, forces) = columns.split_at(rows);
        let sigma = self.factor_of_r;
        for (next, ((w, drift), of_r)) in next.iter_mut().zip(w.iter().zip(drift).zip(of_r)) {
            *next = w + drift + sigma * of_r;
        }
        for (&force, column) in lambda.iter().zip(forces.chunks_exact(rows)) {
            add_multiple(next, force, column);
        }
    }

    /// Writes the members' impulses, as long as none pulls; says whether none does.
    #[inline(always)]
    fn impulses_after(&self, lambda: &[f64], impulses: &mut [f64]) -> bool {
        let n = impulses.len();
        let (drift, columns) = self.impulses[..n * (lambda.len() + 2)].split_at(n);
        let (of_r, forces) = columns.split_at(n);
        for (slot, ((&contact, drift), of_r)) in self.set.iter().zip(drift).zip(of_r).enumerate() {
            let mut impulse = drift + self.factor_of_r * of_r;
            for (force, column) in lambda.iter().zip(forces.chunks_exact(n)) {
                impulse += force * column[slot];
            }
            if impulse < 0.0 {
                return false;
            }
            impulses[contact] = impulse;
        }
        true
    }

    /// Whether contacts that push need not: no impulse at all would do.
    #[inline(always)]
    fn is_solved_by_zero(&self, model: &PackedModel, rates: GapRates, w: &[f64], lambda: &[f64], gap: &[f64]) -> bool {
        let rows = w.len();
        !self.set.is_empty()
            && gap.iter().enumerate().all(|(contact, gap)| {
                let mut free = w[contact] + model.drift(rows)[contact] + rates.velocity(*gap);
                for (j, force) in lambda.iter().enumerate() {
                    free += force * model.force_column(j, rows)[contact];
                }
                free >= 0.0
            })
    }

    /// Writes the impulses, as long as each contact keeps to its state; says whether all do.
    #[inline(always)]
    fn frictional_impulses_after(
        &self,
        model: &PackedModel,
        lambda: &[f64],
        next: &[f64],
        impulses: &mut [f64],
        tolerance: f64,
    ) -> bool {
        let SetFactor::States(factor) = &self.factor else { return false };
        let n = impulses.len();
        let contacts = n / 2;
        let (drift, columns) = self.impulses[..n * (lambda.len() + 2)].split_at(n);
        let (of_r, forces) = columns.split_at(n);
        for (slot, ((&row, drift), of_r)) in self.set.iter().zip(drift).zip(of_r).enumerate() {
            let mut impulse = drift + self.factor_of_r * of_r;
            for (force, column) in lambda.iter().zip(forces.chunks_exact(n)) {
                impulse += force * column[slot];
            }
            if row >= contacts {
                // Its normal impulse is the one before.
                let beyond = impulse.abs() - factor.friction[row - contacts] * impulses[row - contacts];
                if beyond > 0.0 && beyond * model.h_uu()[row * n + row] > tolerance {
                    return false;
                }
            } else {
                let (direction, mu) = (factor.states[row].friction(), factor.friction[row]);
                // Its friction points against its velocity.
                let slides = mu == 0.0 || direction * next[contacts + row] <= tolerance;
                if impulse < 0.0 || !slides {
                    return false;
                }
                impulses[contacts + row] = direction * mu * impulse;
            }
            impulses[row] = impulse;
        }
        true
    }

    /// Whether `w_A⁺ = −t_A`, that is, `r` is what the present multiple of its column says.
    #[inline(always)]
    fn rests(&self, rates: GapRates, next: &[f64], gap: &[f64], tolerance: f64) -> bool {
        self.set.iter().all(|&row| (next[row] + gap_velocity(rates, gap, row)).abs() <= tolerance)
    }

    /// Both with many contacts: counts what is not so, without leaving the pass.
    fn goes_as_foreseen(&self, rates: GapRates, next: &[f64], gap: &[f64], tolerance: f64) -> bool {
        let SetFactor::Sparse(many) = &self.factor else { return false };
        let accepted = -self.accepted(tolerance);
        let mut wrong = 0;
        for ((w, gap), member) in next.iter().zip(gap).zip(&many.member) {
            let slack = w + rates.velocity(*gap);
            wrong += u64::from(slack < accepted) + u64::from((member * slack).abs() > tolerance);
        }
        wrong == 0
    }

    /// Writes the impulses of many contacts; says whether none pulls.
    fn many_impulses_after(&self, lambda: &[f64], impulses: &mut [f64]) -> bool {
        let SetFactor::Sparse(many) = &self.factor else { return false };
        let n = impulses.len();
        let (drift, columns) = many.impulses[..n * (lambda.len() + 2)].split_at(n);
        let (of_r, forces) = columns.split_at(n);
        for (impulse, (drift, of_r)) in impulses.iter_mut().zip(drift.iter().zip(of_r)) {
            *impulse = drift + self.factor_of_r * of_r;
        }
        for (&force, column) in lambda.iter().zip(forces.chunks_exact(n)) {
            add_multiple(impulses, force, column);
        }
        impulses.iter().map(|impulse| u64::from(*impulse < 0.0)).sum::<u64>() == 0
    }

    /// Looks at `r` as it is, and solves for it unless it is zero; false if it was as foreseen.
    #[cold]
    fn foresee_anew(
        &mut self,
        model: &PackedModel,
        motion: &GapMotion,
        w: &[f64],
        gap: &[f64],
        tolerance: f64,
    ) -> bool {
        let (n, rows, k) = (self.contacts, w.len(), self.set.len());
        let (of_r, impulses) = (&mut self.velocities[rows..2 * rows], &mut self.impulses[n..n + k]);
        let mut as_foreseen = true;
        for (r, &contact) in self.r[..k].iter_mut().zip(&self.set) {
            *r = w[contact] + gap_velocity(motion.rates, gap, contact);
            as_foreseen &= (*r + self.factor_of_r * of_r[contact]).abs() <= tolerance;
        }
        if as_foreseen {
            return false;
        }
        if let SetFactor::Sparse(..) = self.factor {
            // What would not go on is rounding, as long as it is small: as a part of the column of r it would come back with the opposite
            // sign a few micro steps later, and again, each time with a solve.
            for (r, &contact) in self.r[..k].iter_mut().zip(&self.set) {
                let lasting = lasting_part(motion, self.decay, gap[contact]);
                if (*r - lasting).abs() <= tolerance {
                    *r = lasting;
                }
            }
        }
        let r = &self.r[..k];
        let scale = largest_entry(r);
        if scale <= tolerance {
            self.set_r_aside();
            return true;
        }
        impulses.copy_from_slice(r);
        self.factor.solve(&self.set, impulses);
        of_r.fill(0.0);
        for (&contact, impulse) in self.set.iter().zip(impulses) {
            *impulse = -*impulse;
            self.factor.push(model, contact, *impulse, of_r);
        }
        if let SetFactor::Sparse(many) = &mut self.factor {
            many.take(1, &self.set, &self.impulses[n..n + k]);
        }
        // To the digit, so that no rounding is left for the next micro step.
        for (&contact, r) in self.set.iter().zip(r) {
            of_r[contact] = -r;
        }
        (self.factor_of_r, self.scales[1]) = (1.0, scale);
        true
    }
}

/// Writes `−H_AA⁻¹ c_A` and what is left of the column c, `c_x − H_xA H_AA⁻¹ c_A`; says whether it is as exact as a solved problem must
/// be. At members nothing is left.
fn respond(
    model: &PackedModel,
    set: &[usize],
    factor: &mut SetFactor,
    column: &[f64],
    left: &mut [f64],
    answer: &mut [f64],
) -> bool {
    for (answer, &contact) in answer.iter_mut().zip(set) {
        *answer = column[contact];
    }
    factor.solve(set, answer);
    left.copy_from_slice(column);
    for (answer, &contact) in answer.iter_mut().zip(set) {
        *answer = -*answer;
        factor.push(model, contact, *answer, left);
    }
    let error = set.iter().fold(0.0, |worst: f64, &contact| worst.max(left[contact].abs()));
    let exact = error <= INEXACT * set.iter().fold(0.0, |most: f64, &contact| most.max(column[contact].abs()));
    for &contact in set {
        left[contact] = 0.0;
    }
    for (left, column) in left.iter_mut().zip(column) {
        if left.abs() <= CANCELLED * column.abs() {
            *left = 0.0;
        }
    }
    exact
}

/// What `r` of a contact must be to go on as it is foreseen, `−δ (γ/h)² g / ρ` of one that is penetrated.
fn lasting_part(motion: &GapMotion, decay: f64, gap: f64) -> f64 {
    let lasts = gap < 0.0 && decay > 0.0;
    if lasts { -motion.advance * motion.rates.closed.powi(2) * gap / decay } else { 0.0 }
}

/// The gap term of a row, m/s: tangential rows, which come after those with gaps, have none.
#[inline(always)]
fn gap_velocity(rates: GapRates, gap: &[f64], row: usize) -> f64 {
    gap.get(row).map_or(0.0, |gap| rates.velocity(*gap))
}

/// Whether a contact goes further than its gap term allows.
#[inline]
fn violates(rates: GapRates, w: &[f64], gap: &[f64], tolerance: f64) -> bool {
    let mut violated = false;
    for (w, gap) in w.iter().zip(gap) {
        violated |= w + rates.velocity(*gap) < -tolerance;
    }
    violated
}

/// Whether a contact that bounces closes within the micro step.
fn closes(motion: &GapMotion, w: &[f64], gap: &[f64], rounding: f64) -> bool {
    w.iter().zip(gap).any(|(&w, &gap)| w < -rounding && gap + motion.closing_time * w <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complementarity::SparseActiveSet;
    use crate::interface_model::ReducedInterfaceModel;
    use crate::linear_algebra::SymmetricPattern;
    use rand::{RngExt, SeedableRng};
    use std::sync::Arc;

    const CONTACTS: usize = 60;
    const DELTA: f64 = 5e-5;
    const PULL: f64 = 10.0;

    /// Contacts side by side, each with its two neighbours: pressed and at rest up to `members`, and open from there on. Model, its motion,
    /// and the response of those at rest.
    fn row_of(members: usize) -> (PackedModel, GapMotion, ParametricStep) {
        let neighbours: Vec<Vec<usize>> =
            (0..CONTACTS).map(|i| vec![i.saturating_sub(1), (i + 1).min(CONTACTS - 1)]).collect();
        let mut model = ReducedInterfaceModel::zeros_of(Arc::new(SymmetricPattern::new(&neighbours)), 1);
        let pattern = model.meeting().unwrap().clone();
        let mut at = 0;
        for i in 0..CONTACTS {
            for &j in pattern.columns(i) {
                model.h[at] = if i == j as usize { 2.0 } else { 0.5 };
                at += 1;
            }
        }
        // The interface pushes the first contact, and pulls the last two.
        model.h[at] = -0.5;
        model.h[at + CONTACTS - 2] = 0.3;
        model.h[at + CONTACTS - 1] = -0.4;
        model.h[at + CONTACTS] = 1.0;
        for (i, a) in model.a[..CONTACTS].iter_mut().enumerate() {
            // Of those that are open every second one falls.
            *a = if i < members { -PULL } else { [0.4 * PULL, -0.4 * PULL][i % 2] };
        }
        let mut packed = PackedModel::of_all(&model);
        packed.pack(&model, &(0..CONTACTS).collect::<Vec<_>>(), DELTA);
        let motion =
            GapMotion { rates: GapRates { open: 1.0 / DELTA, closed: 40.0 }, advance: DELTA, ..GapMotion::default() };
        let mut solver = SparseActiveSet::new(&pattern, 1e-9);
        let mut impulses = vec![0.0; CONTACTS];
        let mut q = packed.drift(CONTACTS).to_vec();
        q[members..].fill(1.0);
        solver.solve(packed.contact_rows().unwrap(), &q, &mut impulses).unwrap();
        let mut step = ParametricStep::sparse(CONTACTS, 1, solver.factor());
        step.find(&packed, &motion, &impulses, 0.0, Some(solver.factor()));
        assert!(step.is_known());
        assert_eq!(impulses.iter().filter(|impulse| **impulse > 0.0).count(), members);
        (packed, motion, step)
    }

    /// A micro step as a scheme takes it, with an outlook over `ahead` more; says whether it was one without a look at the contacts.
    fn go(
        step: &mut ParametricStep,
        (packed, motion): (&PackedModel, &GapMotion),
        force: f64,
        ahead: usize,
        [w, next, gap, impulses]: [&mut Vec<f64>; 4],
    ) -> Option<bool> {
        if step.looks_ahead() {
            if step.go_on(motion, force, w, next) {
                std::mem::swap(w, next);
                return Some(true);
            }
            step.catch_up(motion, w, gap);
        }
        let went = step.step::<false>(packed, motion, &[force], MicroState { w, next, gap, impulses });
        if went {
            step.look_ahead(motion, &[force], ahead, next, gap);
            std::mem::swap(w, next);
        }
        went.then_some(false)
    }

    /// What a micro step takes for rounding adds up in the gap, and the gap is what the next one looks at.
    #[test]
    fn a_drift_that_each_micro_step_takes_for_rounding_is_seen_once_gaps_have_added_it_up() {
        let (packed, motion, step) = row_of(CONTACTS);
        let rounding = NEGLIGIBLE_OF_MANY * DELTA * PULL;
        for (drift, ahead) in
            [0.4, 0.01, -0.4].into_iter().flat_map(|part| [(part * rounding, 0), (part * rounding, 98)])
        {
            let mut step = step.clone();
            let (mut w, mut next) = (vec![0.0; CONTACTS + 1], vec![0.0; CONTACTS + 1]);
            let (mut gap, mut impulses) = (vec![0.0; CONTACTS], vec![0.0; CONTACTS]);
            w[7] = drift;
            let mut farthest = 0.0_f64;
            for k in 0..20_000 {
                let state = [&mut w, &mut next, &mut gap, &mut impulses];
                go(&mut step, (&packed, &motion), 0.0, ahead, state).expect("contacts stay");
                if k % 100 == 99 {
                    step.catch_up(&motion, &mut w, &mut gap);
                    farthest = farthest.max(gap[7].abs());
                    assert!(w[7].abs() <= 2.0 * rounding, "{drift:e}: {:e} m/s", w[7]);
                }
            }
            // Where the gap term of a penetration is rounding, which is the smaller one.
            let seen = rounding / motion.rates.closed;
            assert!(farthest <= 1.01 * seen, "{drift:e}: {farthest:e} m of {seen:e}");
            let unseen = 20_000.0 * DELTA * drift.abs();
            assert!(drift.abs() < 0.1 * rounding || unseen > 10.0 * seen, "{drift:e}: it would be seen anyway");
        }
    }

    /// A contact that opens by a little more than what is rounding, among others whose penetrations go on as foreseen.
    #[test]
    fn rounding_of_one_contact_is_not_corrected_back_and_forth() {
        let (packed, motion, step) = row_of(CONTACTS);
        let rounding = NEGLIGIBLE_OF_MANY * DELTA * PULL;
        let decay = 1.0 - DELTA * motion.rates.closed;
        // The interface at the end, without the one contact first.
        let mut interface = None;
        for part in [0.0, 0.3, 0.55, 0.8, 0.95, 1.2, 3.0] {
            let mut step = step.clone();
            let mut gap: Vec<f64> = (0..CONTACTS).map(|i| -1e-6 * (1.0 + libm::sin(i as f64))).collect();
            let mut w: Vec<f64> = gap.iter().map(|gap| -motion.rates.velocity(*gap)).chain([0.0]).collect();
            (w[7], gap[7]) = (part * rounding, part * rounding * DELTA);
            let (mut next, mut impulses) = (w.clone(), vec![0.0; CONTACTS]);
            for _ in 0..50 {
                let state = [&mut w, &mut next, &mut gap, &mut impulses];
                go(&mut step, (&packed, &motion), 0.0, 0, state).expect("contacts stay");
            }
            let off = (w[CONTACTS] - *interface.get_or_insert(w[CONTACTS])).abs();
            assert!(off <= 10.0 * rounding, "{part}: the interface is off by {off:e} m/s");
            assert!(w[7].abs() <= 2.0 * rounding && gap[7].abs() <= 1e3 * rounding * DELTA, "{part}: {:e} m/s", w[7]);
            // σ starts at one each time that r is solved for.
            let since = libm::log(step.factor_of_r) / libm::log(decay);
            assert!(since > 44.0, "{part}: solved for {since} micro steps ago");
        }
    }

    /// The same micro steps with and without an outlook, under forces that end the set sooner or later.
    #[test]
    fn micro_steps_without_a_look_at_the_contacts_go_as_far_as_those_with_one_and_end_as_they_do() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(8);
        let members = CONTACTS - 12;
        let (packed, motion, start) = row_of(members);
        let (mut ahead_of_all, mut ended) = (0, 0);
        for turn in 0..400 {
            let (pitch, size) = (rng.random_range(0.0..0.2), rng.random_range(0.0..25.0));
            let phase = rng.random_range(0.0..6.0);
            let force = |k: usize| size * libm::sin(phase + pitch * k as f64);
            let [mut of_all, mut of_few] = [(); 2].map(|()| {
                (
                    start.clone(),
                    [vec![0.0; CONTACTS + 1], vec![0.0; CONTACTS + 1], vec![0.0; CONTACTS], vec![0.0; CONTACTS]],
                )
            });
            for [w, _, gap, _] in [&mut of_all.1, &mut of_few.1] {
                let mut rng = rand_pcg::Pcg64::seed_from_u64(turn);
                // Penetrations that are pushed out, and open contacts of which some are on their way in.
                for (i, (w, gap)) in w.iter_mut().zip(gap).enumerate() {
                    if i < members {
                        *gap = if turn % 3 == 0 { 0.0 } else { -rng.random_range(0.0..1e-4) };
                        *w = -motion.rates.velocity(*gap);
                    } else {
                        *gap = rng.random_range(0.0..1e-3);
                        *w = rng.random_range(-0.02..0.3);
                    }
                }
            }
            for k in 0..100 {
                let [all, few] =
                    [(&mut of_all, 0), (&mut of_few, 98_usize.saturating_sub(k))].map(|((step, state), ahead)| {
                        let [w, next, gap, impulses] = state;
                        go(step, (&packed, &motion), force(k), ahead, [w, next, gap, impulses])
                    });
                assert_eq!(all.is_some(), few.is_some(), "{turn}: micro step {k}");
                ahead_of_all += usize::from(few == Some(true));
                assert_eq!(of_all.1[0][CONTACTS].to_bits(), of_few.1[0][CONTACTS].to_bits(), "the interface");
                if all.is_none() {
                    ended += 1;
                    break;
                }
            }
            let (step, [w, _, gap, _]) = &mut of_few;
            step.catch_up(&motion, w, gap);
            for i in 0..CONTACTS {
                let [all, few] = [&of_all.1, &of_few.1].map(|state| (state[0][i], state[2][i]));
                let off = (all.0 - few.0).abs().max((all.1 - few.1).abs() / DELTA);
                assert!(off < 1e-12, "{turn}: contact {i}: {few:?} instead of {all:?}");
            }
        }
        println!("{ahead_of_all} of 40000 micro steps without a look, {ended} sets ended");
        assert!(ahead_of_all > 10_000 && ended > 100 && ended < 350, "{ahead_of_all} {ended}");
    }
}
