//! Contacts with friction in a step of the mechanics.

use super::super::ContactStepper;
use super::{ContactTerms, DenseProblem, StepContacts};
use crate::error::{Error, Failure, Result};
use crate::interface_model::{Condensation, ContactModes, Elimination, ReducedInterfaceModel, Rows};
use crate::name::Name;
use rimbench_contact::complementarity::SolverCounters;
use rimbench_contact::contact_law::Solved;
use rimbench_contact::friction::{ContactState, FrictionProblem, FrictionSolver, Stiction};
use rimbench_contact::solver_entry::SolverEntry;

/// Friction of the contacts: Coulomb's law in the plane.
///
/// ```text
/// |P_t| ≤ μ P_n,  w_t P_t = −μ P_n |w_t|
/// ```
/// # Source
/// Moreau's law of impact with one restitution along the normal and along the surface takes energy in every impact. With a smaller one along
/// the surface, such as Newton's law along the normal alone, a few of a hundred random impacts create some: the energy account shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// Coefficient μ ≥ 0 of all contacts.
    pub coefficient: f64,
    /// Coefficient of a contact that stuck in the last step, at least that of the others; see [`Stiction`].
    pub at_rest: f64,
    /// Restitution along the surface of contacts that rebound along the normal.
    pub restitution: f64,
}

impl Friction {
    /// Coefficients at rest and in motion, where they differ.
    fn stiction(self) -> Option<Stiction> {
        let Friction { coefficient, at_rest, .. } = self;
        (at_rest > coefficient).then_some(Stiction { at_rest, in_motion: coefficient })
    }
}

/// The contact problem of a step with friction and its solver, and the state and coefficient of each contact after it.
#[derive(Clone)]
pub(in crate::mechanics) struct CoulombStep {
    law: Friction,
    solver: FrictionSolver,
    /// `[H_nn H_nt; H_tn H_tt]`, `[b_n; b_t]` and `H P + b` of the last step.
    pub(super) problem: DenseProblem,
    /// Coefficient of each contact in the next step, and its state (open, stick or slip) in the last one.
    friction: Vec<f64>,
    states: Vec<ContactState>,
}

impl CoulombStep {
    /// Returns an interface model of these contacts, zero.
    pub(in super::super) fn empty_model(&self, interface: usize) -> ReducedInterfaceModel {
        let mut empty = ReducedInterfaceModel::zeros_with_friction(&self.friction, interface);
        empty.tangential_restitution = self.law.restitution;
        empty.stiction = self.law.stiction();
        empty
    }

    /// Returns the states of the contacts in the last step, with their coefficients.
    pub(in super::super) fn modes(&self) -> ContactModes<'_> {
        ContactModes { states: &self.states, friction: &self.friction }
    }

    /// Writes coefficients and modes to the model that is sent.
    pub(in super::super) fn write_modes(&self, model: &mut ReducedInterfaceModel, started: bool) {
        model.friction.copy_from_slice(&self.friction);
        model.states.copy_from_slice(&self.states);
        if started {
            model.solved_states.copy_from_slice(self.solver.solver.states());
        }
    }

    pub(in super::super) fn counters(&self) -> SolverCounters {
        self.solver.counters()
    }

    /// Returns the velocity up to which a contact sticks in the solution of the last step, `τ ‖b‖_∞` with the solver's tolerance τ, m/s.
    pub(in super::super) fn rounding_velocity(&self) -> f64 {
        self.solver.tolerance() * self.problem.b.iter().fold(0.0, |max: f64, b| max.max(b.abs()))
    }

    /// Returns `Σ w_t⁺ P_t` of the last step with its friction impulses, J.
    pub(in super::super) fn slip(&self, impulses: &[f64]) -> f64 {
        self.problem.w[self.friction.len()..].iter().zip(impulses).map(|(w, p)| w * p).sum()
    }

    /// Solves the contacts of one step.
    ///
    /// ```text
    /// b_n = w_n + h a_n + H_ni h λ_i + t_n        b_t = w_t + h a_t + H_ti h λ_i, + e w_t of a contact that rebounds
    /// ```
    pub(in super::super) fn solve(
        &mut self,
        terms: ContactTerms<'_>,
        impulses: &mut [f64],
        p_i: &[f64],
    ) -> Result<(), Failure> {
        self.problem.pose(terms, p_i);
        let DenseProblem { h, b, w } = &mut self.problem;
        let problem = FrictionProblem::with_friction(h, b, &self.friction);
        let solved = self.solver.solve(problem, impulses);
        problem.velocities(impulses, w);
        if let (Some(stiction), Solved::Velocity) = (self.law.stiction(), terms.solved) {
            let rounding = self.rounding_velocity();
            let (n, states) = (self.friction.len(), self.solver.solver.states());
            for ((coefficient, state), w_t) in self.friction.iter_mut().zip(states).zip(&self.problem.w[n..]) {
                *coefficient = stiction.after(state.moving(*w_t, rounding));
            }
        }
        solved?;
        Ok(())
    }

    /// Solves a trial with the right-hand side `b`, which leaves coefficients as they are; writes its velocities as well.
    pub(in super::super) fn try_solve(
        &mut self,
        b: &[f64],
        impulses: &mut [f64],
        velocities: &mut [f64],
    ) -> Result<(), Failure> {
        let problem = FrictionProblem::with_friction(&self.problem.h, b, &self.friction);
        self.solver.solve(problem, impulses)?;
        problem.velocities(impulses, velocities);
        Ok(())
    }

    /// Finds whether the contacts closed in the last step stick or slip; before the first step, from their velocities.
    ///
    /// Loaded ones have the state that the solver found; closed ones without load that of their velocity, to the solver's tolerance.
    pub(in super::super) fn find_modes(&mut self, eq4: &ReducedInterfaceModel, started: bool) {
        let (n, rounding) = (self.friction.len(), self.rounding_velocity());
        for contact in 0..n {
            let (w_t, found) = if started {
                (self.problem.w[n + contact], self.solver.solver.states()[contact])
            } else {
                (eq4.w[n + contact], ContactState::Open)
            };
            self.states[contact] = match (eq4.at_bound[contact], found) {
                (false, _) => ContactState::Open,
                (true, ContactState::Open) => ContactState::of_closed(w_t, if started { rounding } else { 0.0 }),
                (true, loaded) => loaded,
            };
            if let (Some(stiction), false) = (self.law.stiction(), started) {
                self.friction[contact] = stiction.after(self.states[contact]);
            }
        }
    }
}

/// Begins the names of observables that are the state of a contact with friction, by [`ContactState::as_number`].
pub const CONTACT_STATE: &str = "contact_state_";

/// Names the additional observables of contacts with friction: of `left` the friction force `friction_force_left_n` and the state
/// `contact_state_left`, and how many contacts stick.
///
/// The state is that of the solver in the last step; of a contact that is closed without an impulse, or redundant, that of its velocity, to
/// the tolerance of the solver.
pub(in crate::mechanics) fn friction_observables(contacts: &[Name]) -> Vec<Name> {
    let forces = contacts.iter().map(|contact| format!("friction_force_{contact}_n"));
    let states = contacts.iter().map(|contact| format!("{CONTACT_STATE}{contact}"));
    forces.chain(states).chain(["sticking_contacts".to_owned()]).map(Name::from).collect()
}

impl ContactStepper {
    /// Gives the contacts friction.
    ///
    /// # Errors
    /// [`Error::Incompatible`] or [`Error::InvalidValue`] for an impossible law, or a system that cannot have friction.
    pub(in crate::mechanics) fn add_friction(
        &mut self,
        friction: Friction,
        tangential_rows: usize,
        solver: &SolverEntry,
    ) -> Result<()> {
        let Friction { coefficient, at_rest, restitution } = friction;
        if !(coefficient.is_finite() && coefficient >= 0.0) {
            return Err(Error::invalid("friction", coefficient, "a finite number, 0 or above"));
        }
        if !(at_rest.is_finite() && at_rest >= coefficient) {
            let expected = format!("a finite number, at least that in motion, {coefficient}");
            return Err(Error::invalid("friction at rest", at_rest, expected));
        }
        let n = self.eq4.contacts();
        let refused = |reason: String| Err(Error::Incompatible(format!("friction = {coefficient}: {reason}")));
        if tangential_rows != n || n == 0 {
            return refused(format!("the mechanics has {tangential_rows} tangential rows for {n} contacts"));
        }
        if !(0.0..=self.law.restitution).contains(&restitution) {
            let found = format!("a restitution of {restitution} along the surface");
            return refused(format!("{found} is none; valid: 0 to that along the normal, {}", self.law.restitution));
        }
        if self.is_compliant() {
            return refused("contacts that give way have none".to_owned());
        }
        if self.contacts.is_sparse() {
            return refused("contacts by the dozen, of which few are coupled, have none".to_owned());
        }
        let Some(solver) = solver.checked_with_friction(n) else {
            let reason = "contacts with friction are solved over their states; use solver `active-set`";
            return refused(reason.to_owned());
        };
        let tolerance = solver.tolerance();
        let contacts = CoulombStep {
            law: friction,
            solver,
            problem: DenseProblem::new(2 * n),
            friction: vec![coefficient; n],
            states: vec![ContactState::Open; n],
        };
        self.eq3.tangential = Rows::zeros(n, self.v.len());
        self.contacts = StepContacts::Coulomb(Box::new(contacts));
        self.eq4 = self.empty_model();
        self.condensation = Condensation::of(&self.eq4);
        self.reserve_rebounds(tolerance);
        self.forget_reduction();
        self.elimination = Elimination::new(&self.eq3);
        self.impulses = vec![0.0; self.eq4.a.len()];
        Ok(())
    }

    /// Tells whether contacts have friction.
    pub(in crate::mechanics) fn has_friction(&self) -> bool {
        self.contacts.coulomb().is_some()
    }

    /// Returns the friction impulses of the last step, N·s.
    pub(in crate::mechanics) fn friction_impulses(&self) -> &[f64] {
        &self.impulses[self.eq4.contacts()..self.eq4.interface_start()]
    }

    /// Writes the additional observables of contacts with friction: friction forces, states, and how many stick. Closed contacts must be
    /// found before.
    pub(in crate::mechanics) fn observe_friction(&self, row: &mut [f64]) {
        let (forces, rest) = row.split_at_mut(row.len() / 2);
        let (states, sticking) = rest.split_at_mut(forces.len());
        for (force, impulse) in forces.iter_mut().zip(self.friction_impulses()) {
            *force = impulse / self.last_step;
        }
        sticking[0] = 0.0;
        let Some(contacts) = self.contacts.coulomb() else { return };
        let rounding = contacts.rounding_velocity();
        let moved = &contacts.problem.w[self.eq4.contacts()..];
        for ((shown, state), w_t) in states.iter_mut().zip(&contacts.states).zip(moved) {
            let state = if self.last_step.is_finite() { state.moving(*w_t, rounding) } else { *state };
            *shown = state.as_number();
            sticking[0] += f64::from(u8::from(state == ContactState::Stick));
        }
    }
}
