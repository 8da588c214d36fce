//! The contacts of a reduced interface model within its micro steps: the complementarity condition of Eq. 4, with a gap
//! term t.
//!
//! ```text
//! w⁺ = w + δ a + δ H_·i λ + H_·u P_u        0 ≤ w_u⁺ + t(g) ⟂ P_u ≥ 0
//! ```
//! [`ModelContacts`] has one variant for each way to solve it. Closed contacts of the smooth model are condensed away
//! beforehand. All others pose a complementarity problem in each micro step ([`Complementarity`]), and differ in the
//! cone of `P_u` and in the form of the Delassus matrix `H_uu` ([`ContactSolver`]). The match is made once per micro
//! step; below it everything is static.

mod solvers;

pub(super) use solvers::{ContactSolver, Posed, Signorini};

use super::coulomb_contacts::{CoulombContacts, SpaceContacts};
use super::recorded_modes::RecordedModes;
use crate::cosim::MicroStep;
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;
use rimbench_contact::affine_step::DiscretisedModel;
pub(super) use rimbench_contact::affine_step::ModelState;
use rimbench_contact::affine_step::{AffineStep, ForceRegion, StepContactLaw};
use rimbench_contact::complementarity::{SolverCounters, SparseSolver, Unsolved};
use rimbench_contact::contact_law::{ImpactRows, ImpactStep, Rebounds, Solved, rounding_velocity};

/// Eq. 4 and the contact law, which are constant over micro steps.
#[derive(Clone, Copy)]
pub(super) struct FrozenModel<'a> {
    pub(super) discretised: &'a DiscretisedModel,
    pub(super) law: &'a StepContactLaw,
    pub(super) set: &'a [usize],
    /// The model as it was received.
    pub(super) received: &'a ReducedInterfaceModel,
}

/// Contacts that open and close within the macro step.
#[derive(Clone)]
pub(super) struct Complementarity<S: ContactSolver> {
    pub(super) solver: S,
    /// The micro step on a critical region; none where the solution is not affine.
    affine: Option<AffineStep<S::Factor>>,
    /// True until the solver has seen the matrix.
    matrix_changed: bool,
    /// Constraint violation left in the micro step last solved, m/s.
    violation_left: f64,
    b: Vec<f64>,
    /// Whether a contact was hit in the step last solved.
    hit: bool,
    rebounds: Rebounds,
    /// The velocities by which positions change in a micro step in which a contact rebounds.
    w_displacement: Vec<f64>,
    /// Velocities and impulses without friction.
    bare: [Vec<f64>; 2],
}

impl<S: ContactSolver> Complementarity<S> {
    /// Wraps a solver for models like `empty`; without an affine step, every micro step is solved.
    pub(super) fn new(solver: S, affine: Option<AffineStep<S::Factor>>, empty: &ReducedInterfaceModel) -> Self {
        let (contacts, rows) = (empty.contacts(), empty.interface_start());
        let rebounds = empty.restitution > 0.0;
        Complementarity {
            solver,
            affine,
            matrix_changed: true,
            violation_left: 0.0,
            b: vec![0.0; rows],
            hit: false,
            rebounds: if rebounds { Rebounds::new(contacts, rows) } else { Rebounds::default() },
            w_displacement: vec![0.0; if rebounds { rows + empty.interface() } else { 0 }],
            bare: [(); 2].map(|()| vec![0.0; if S::ROWS > 1 { rows + empty.interface() } else { 0 }]),
        }
    }

    /// Leaves the critical region, as `H` or `a` may change after micro steps under `law`; velocities and gaps are then
    /// those of all contacts.
    fn leave_region(&mut self, law: &StepContactLaw, state: &mut ModelState) {
        self.matrix_changed = true;
        if let Some(affine) = &mut self.affine {
            affine.leave_region(law, &mut state.w_plus, &mut state.gap);
        }
    }

    /// Takes a micro step inside the critical region; false outside, where the contact problem is to be solved.
    #[inline(always)]
    fn step_in_region(
        &mut self,
        discretised: &DiscretisedModel,
        law: &StepContactLaw,
        state: &mut ModelState,
        lambda: &[f64],
        at: MicroStep,
    ) -> bool {
        let Some(affine) = &mut self.affine else { return false };
        if affine.skip(law, lambda, state) {
            return true;
        }
        if !affine.is_known() && !self.linearise(discretised, law, state) {
            return false;
        }
        let Some(affine) = &mut self.affine else { return false };
        let remaining = at.count.saturating_sub(at.index + 1);
        if affine.is_known() && affine.step(discretised, law, lambda, remaining, state) {
            return true;
        }
        affine.leave_region(law, &mut state.w, &mut state.gap);
        false
    }

    /// Looks for the critical region of the problem that was solved last; false where there was none of this model.
    #[cold]
    fn linearise(&mut self, discretised: &DiscretisedModel, law: &StepContactLaw, state: &ModelState) -> bool {
        let Some(affine) = self.affine.as_mut().filter(|_| !self.matrix_changed) else { return false };
        let active = self.solver.active(&state.impulses[..discretised.contacts()]);
        affine.linearise(discretised, law, active, self.violation_left);
        true
    }

    /// Finds the forces around those of the last step that keep its active set, see [`AffineStep::find_force_region`].
    fn find_force_region(&self, model: FrozenModel<'_>, state: &ModelState, lambda: &[f64], region: &mut ForceRegion) {
        if let Some(affine) = self.affine.as_ref().filter(|affine| affine.is_known()) {
            affine.find_force_region(model.discretised, model.law, (&state.w, &state.gap), lambda, region);
        }
    }

    /// Writes the velocities after a step under `lambda` (N) by the last tangents.
    fn velocities_with_set(&self, state: &mut ModelState, lambda: &[f64]) {
        if let Some(affine) = &self.affine {
            affine.velocities_with_set(&state.w, lambda, &mut state.w_plus);
        }
    }

    /// Poses the contact problem of a step, solves it, and applies its impulses. A trial leaves coefficients of
    /// friction as they are.
    fn solve(
        &mut self,
        model: FrozenModel<'_>,
        state: &mut ModelState,
        lambda: &[f64],
        trial: bool,
    ) -> Result<(), Failure> {
        let FrozenModel { discretised, law, .. } = model;
        let (n, m) = (discretised.contacts(), discretised.contacts() / S::ROWS);
        let rows = n + lambda.len();
        discretised.free_velocity(&state.w[..rows], lambda, &mut state.w_plus[..rows]);
        self.hit = law.restitution > 0.0 && self.find_rebounds(model, state, rows)?;
        self.pose(model, state, Solved::Velocity);
        let changed = std::mem::replace(&mut self.matrix_changed, false);
        let posed = Posed { model: discretised, changed, b: &self.b[..n] };
        let impulses = &mut state.impulses[..n];
        if trial { self.solver.try_solve(posed, impulses) } else { self.solver.solve(posed, impulses) }?;
        let w = &mut state.w_plus[..rows];
        discretised.add_impulses(&state.impulses[..n], w);
        self.violation_left = 0.0;
        // A contact that rebounds does not follow its gap term.
        if self.affine.is_some() && law.restitution == 0.0 {
            let slack = |(w, gap): (&f64, &f64)| w + law.rates.velocity(*gap);
            self.violation_left = -w[..m].iter().zip(&state.gap).map(slack).fold(0.0, f64::min);
        }
        let mut w_displacement = &*w;
        if self.rebounds.any() {
            // The interface moves on by its velocity after the step.
            for (position, (moved, w)) in state.position.iter_mut().zip(self.w_displacement[n..].iter().zip(&w[n..])) {
                *position += discretised.length() * (moved - w);
            }
            w_displacement = &self.w_displacement;
        }
        for (gap, w) in state.gap.iter_mut().zip(&w_displacement[..m]) {
            *gap += law.gap_step * w;
        }
        Ok(())
    }

    /// Solves the step that was solved or taken last once more without friction; false where that has no solution.
    #[cold]
    fn solve_without_friction(&mut self, model: FrozenModel<'_>, state: &ModelState, lambda: &[f64]) -> bool {
        let FrozenModel { discretised, law, .. } = model;
        let (n, m) = (discretised.contacts(), discretised.contacts() / S::ROWS);
        let [bare, impulses] = &mut self.bare;
        let rows = n + lambda.len();
        let (bare, b) = (&mut bare[..rows], &mut self.b[..n]);
        discretised.free_velocity(&state.w[..rows], lambda, bare);
        // With rebounds `b` keeps the impact terms of the step.
        if !self.rebounds.any() {
            b.copy_from_slice(&bare[..n]);
            b[..m].iter_mut().zip(&state.gap).for_each(|(b, gap)| *b += law.rates.velocity(*gap));
        }
        // The next problem has friction again: the active set found here is not one to start from.
        self.matrix_changed = true;
        let solved = self.solver.solve_without_friction(Posed { model: discretised, changed: true, b }, impulses);
        if solved.is_ok() {
            discretised.add_impulses(&impulses[..n], bare);
        }
        solved.is_ok()
    }

    /// Writes `b`, free velocity and contact law, of all contact rows; the free velocities are in `state.w_plus`.
    #[inline]
    fn pose(&mut self, model: FrozenModel<'_>, state: &ModelState, solved: Solved) {
        let (law, n) = (model.law, model.discretised.contacts());
        let m = n / S::ROWS;
        let b = &mut self.b[..n];
        b.copy_from_slice(&state.w_plus[..n]);
        for (b, gap) in b[..m].iter_mut().zip(&state.gap) {
            *b += law.rates.velocity(*gap);
        }
        if self.rebounds.any() {
            let step = impact_step(model, self.solver.tolerance());
            for (row, b) in b.iter_mut().enumerate() {
                let term = match row.checked_sub(m) {
                    Some(contact) => self.rebounds.term_along(&step, contact, state.w[row]),
                    None => self.rebounds.term(&step, row, law.rates.velocity(state.gap[row]), state.w[row], solved),
                };
                *b = state.w_plus[row] + term;
            }
        }
    }

    /// Finds the contacts that rebound in a micro step whose free velocities are in `state.w_plus`; says whether any is
    /// hit.
    ///
    /// The rows of a frozen model do not turn, so that contacts at rest approach by what the mechanics' step made and
    /// no more.
    fn find_rebounds(&mut self, model: FrozenModel<'_>, state: &mut ModelState, rows: usize) -> Result<bool, Failure> {
        let n = model.discretised.contacts();
        let step = impact_step(model, self.solver.tolerance());
        let own = |slot: usize| model.received.discretisation_approach_of(model.set[slot]);
        let impact = ImpactRows { gap: &state.gap[..n / S::ROWS], w: &state.w[..n], free: &state.w_plus[..n] };
        let hit = self.rebounds.record_hits(&step, impact, own);
        if hit {
            self.look_ahead(model, &step, state, rows)?;
        }
        Ok(hit)
    }

    /// Finds out which contacts that are hit rebound, and the velocities by which positions then change.
    #[cold]
    fn look_ahead(
        &mut self,
        model: FrozenModel<'_>,
        step: &ImpactStep,
        state: &mut ModelState,
        rows: usize,
    ) -> Result<(), Failure> {
        let (discretised, n) = (model.discretised, model.discretised.contacts());
        let impact = ImpactRows { gap: &state.gap[..n / S::ROWS], w: &state.w[..n], free: &state.w_plus[..n] };
        let Complementarity { rebounds, solver, matrix_changed, w_displacement, .. } = self;
        let lasts = rebounds.look_ahead(step, impact, |b, impulses, velocities| {
            let changed = std::mem::replace(matrix_changed, false);
            solver.try_solve(Posed { model: discretised, changed, b }, impulses)?;
            w_displacement[..n].copy_from_slice(b);
            discretised.add_impulses(impulses, &mut w_displacement[..rows]);
            velocities.copy_from_slice(&w_displacement[..n]);
            Ok::<(), Unsolved>(())
        })?;
        if lasts {
            self.pose(model, state, Solved::Displacement);
            let posed = Posed { model: discretised, changed: false, b: &self.b[..n] };
            self.solver.try_solve(posed, &mut state.impulses[..n])?;
            self.w_displacement[..rows].copy_from_slice(&state.w_plus[..rows]);
            discretised.add_impulses(&state.impulses[..n], &mut self.w_displacement[..rows]);
        }
        Ok(())
    }

    fn record_modes(&self, discretised: &DiscretisedModel, set: &[usize], w_plus: &[f64], modes: &mut RecordedModes) {
        let n = discretised.contacts();
        if S::ROWS > 1 {
            let rows = w_plus[..n].iter().zip(discretised.free_increment(n)).map(|(w, change)| (*w, *change));
            let rounding = rounding_velocity(self.solver.tolerance(), rows);
            self.solver.record_modes(set, &w_plus[..n], rounding, modes);
        }
    }

    fn counters(&self) -> SolverCounters {
        let mut counters = self.solver.counters();
        counters.parametric += self.affine.as_ref().map_or(0, AffineStep::steps);
        counters
    }
}

/// Returns the impact law of a micro step.
fn impact_step(FrozenModel { law, received, .. }: FrozenModel<'_>, tolerance: f64) -> ImpactStep {
    let StepContactLaw { rates, gap_step, restitution, closing_time } = *law;
    ImpactStep {
        restitution,
        along: received.tangential_restitution,
        rates,
        advance: gap_step,
        closing_time,
        tolerance,
    }
}

/// The contact problem of the model, one variant for each cone and form of `H_uu`.
#[derive(Clone)]
pub(super) enum ModelContacts {
    /// Bilateral contacts are eliminated beforehand, the others left out.
    Bilateral,
    /// Without friction, every entry of `H_uu` kept.
    Signorini(Box<Complementarity<Signorini>>),
    /// Without friction, `H_uu` by its pattern.
    Sparse(Box<Complementarity<SparseSolver>>),
    /// With friction.
    Coulomb(Box<Complementarity<CoulombContacts>>),
    /// With friction, in space.
    Space(Box<Complementarity<SpaceContacts>>),
}

macro_rules! each {
    ($self:expr, $contacts:ident => $call:expr, $bilateral:expr) => {
        match $self {
            ModelContacts::Bilateral => $bilateral,
            ModelContacts::Signorini($contacts) => $call,
            ModelContacts::Sparse($contacts) => $call,
            ModelContacts::Coulomb($contacts) => $call,
            ModelContacts::Space($contacts) => $call,
        }
    };
}

impl ModelContacts {
    /// Sets the contacts of a model that has arrived.
    pub(super) fn set_contacts(&mut self, set: &[usize], model: &ReducedInterfaceModel) {
        each!(self, contacts => contacts.solver.set_contacts(set, model), ());
    }

    /// Returns the rows of the model that pose the problem.
    pub(super) fn rows<'a>(&'a self, set: &'a [usize]) -> &'a [usize] {
        each!(self, contacts => contacts.solver.rows(set), &[])
    }

    /// Leaves the critical region, as `H` or `a` may change after micro steps under `law`; velocities and gaps are then
    /// those of all contacts.
    pub(super) fn leave_region(&mut self, law: &StepContactLaw, state: &mut ModelState) {
        each!(self, contacts => contacts.leave_region(law, state), ());
    }

    /// Takes a micro step under the force `lambda` (N) without a contact problem: there is none, or its active set
    /// stays. Velocities at its end are then in `state.w_plus`. Returns false if the problem is to be solved.
    #[inline(always)]
    pub(super) fn step_in_region(
        &mut self,
        discretised: &DiscretisedModel,
        law: &StepContactLaw,
        state: &mut ModelState,
        lambda: &[f64],
        at: MicroStep,
    ) -> bool {
        each!(
            self,
            contacts => contacts.step_in_region(discretised, law, state, lambda, at),
            discretised.step_without_contacts(&state.w, lambda, &mut state.w_plus)
        )
    }

    /// Takes the micro step by solving its contact problem.
    ///
    /// # Errors
    /// As the contact solver reports.
    #[inline(never)]
    pub(super) fn solve(
        &mut self,
        model: FrozenModel<'_>,
        state: &mut ModelState,
        lambda: &[f64],
    ) -> Result<(), Failure> {
        each!(self, contacts => contacts.solve(model, state, lambda, false), Ok(()))
    }

    /// Does the same as a trial, which leaves coefficients of friction as they are; says whether a contact is hit.
    ///
    /// # Errors
    /// As the contact solver reports.
    #[inline(never)]
    pub(super) fn try_solve(
        &mut self,
        model: FrozenModel<'_>,
        state: &mut ModelState,
        lambda: &[f64],
    ) -> Result<bool, Failure> {
        each!(self, contacts => contacts.solve(model, state, lambda, true).map(|()| contacts.hit), Ok(false))
    }

    /// Finds the velocities of contacts that the step under `lambda` (N) which was taken last has without friction; false
    /// where it has none.
    pub(super) fn solve_without_friction(
        &mut self,
        model: FrozenModel<'_>,
        state: &ModelState,
        lambda: &[f64],
    ) -> bool {
        each!(self, contacts => contacts.solve_without_friction(model, state, lambda), true)
    }

    /// Returns what [`solve_without_friction`](Self::solve_without_friction) found, m/s.
    pub(super) fn velocities_without_friction(&self) -> &[f64] {
        each!(self, contacts => &contacts.bare[0], &[])
    }

    /// Finds the forces around those of the last step, `lambda` (N), for which a step from the same state keeps its
    /// active set; none where it had no tangents.
    pub(super) fn find_force_region(
        &self,
        model: FrozenModel<'_>,
        state: &ModelState,
        lambda: &[f64],
        region: &mut ForceRegion,
    ) {
        each!(self, contacts => contacts.find_force_region(model, state, lambda, region), ());
    }

    /// Writes the velocities after a step under `lambda` (N) by the last tangents.
    pub(super) fn velocities_with_set(&self, state: &mut ModelState, lambda: &[f64]) {
        each!(self, contacts => contacts.velocities_with_set(state, lambda), ());
    }

    /// Returns the rows of each contact.
    pub(super) fn rows_of_contact(&self) -> usize {
        fn rows<S: ContactSolver>(_: &Complementarity<S>) -> usize {
            S::ROWS
        }
        each!(self, contacts => rows(contacts), 1)
    }

    /// Records what contacts with friction did in the micro step that ends with velocities `w_plus`.
    pub(super) fn record_modes(
        &self,
        discretised: &DiscretisedModel,
        set: &[usize],
        w_plus: &[f64],
        modes: &mut RecordedModes,
    ) {
        each!(self, contacts => contacts.record_modes(discretised, set, w_plus, modes), ());
    }

    /// Returns what solvers and affine steps have done.
    pub(super) fn counters(&self) -> SolverCounters {
        each!(self, contacts => contacts.counters(), SolverCounters::default())
    }
}
