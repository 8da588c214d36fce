//! One step with friction at the contacts.

use super::ContactStepper;
use crate::complementarity::SolverCounters;
use crate::error::{Error, Failure, Result};
use crate::friction::{ContactState, FrictionProblem, FrictionSolver, Stiction};
use crate::interface_model::{Condensation, Elimination, ReducedInterfaceModel, Rows, Solved, TOUCHING};
use crate::linear_algebra::body_dot;
use crate::mechanics::energy_ledger::EnergyLedger;
use crate::name::Name;

/// Friction of the contacts: Coulomb's law in the plane.
///
/// ```text
/// |P_t| ≤ μ P_n,  w_t P_t = −μ P_n |w_t|
/// ```
/// # Source
/// Moreau's law of impact for contacts that rebound: one restitution along the normal and along the surface. A normal restitution alone can
/// create energy together with friction, in a few of a hundred random impacts, and is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// Coefficient μ ≥ 0 of all contacts.
    pub coefficient: f64,
    /// Coefficient of a contact that stuck in the last step, at least that of the others; see [`Stiction`].
    pub at_rest: f64,
    /// Restitution along the surface of contacts that rebound: that along the normal.
    pub restitution: f64,
}

impl Friction {
    /// Coefficients at rest and in motion, where they differ.
    fn stiction(self) -> Option<Stiction> {
        let Friction { coefficient, at_rest, .. } = self;
        (at_rest > coefficient).then_some(Stiction { at_rest, in_motion: coefficient })
    }
}

/// Contacts with friction, in the place of those without.
#[derive(Debug, Clone)]
pub(super) struct FrictionalContacts {
    law: Friction,
    coefficients: Vec<f64>,
    pub(super) solver: FrictionSolver,
    /// `[H_nn H_nt; H_tn H_tt]` and `[b_n; b_t]` of the last step, and `H P + b`.
    pub(super) h: Vec<f64>,
    b: Vec<f64>,
    w: Vec<f64>,
}

impl FrictionalContacts {
    /// An interface model of these contacts, with nothing in it yet.
    pub(super) fn empty_model(&self, interface: usize) -> ReducedInterfaceModel {
        let mut empty = ReducedInterfaceModel::zeros_with_friction(&self.coefficients, interface);
        empty.tangential_restitution = self.law.restitution;
        empty.stiction = self.law.stiction();
        empty
    }

    pub(super) fn counters(&self) -> SolverCounters {
        self.solver.counters()
    }

    /// Velocity up to which the solution of the last step stands still, m/s: the solver's tolerance.
    fn standstill(&self) -> f64 {
        self.solver.tolerance() * self.b.iter().fold(0.0, |max: f64, b| max.max(b.abs()))
    }

    /// What the last step adds to the ledger besides: `work` of the tangential impulses with the mean velocity, and with that of the law.
    pub(super) fn book(&self, work: f64, impulses: &[f64]) -> EnergyLedger {
        let slip = self.w[self.coefficients.len()..].iter().zip(impulses).map(|(w, p)| w * p).sum();
        EnergyLedger { friction: work, slip, ..EnergyLedger::default() }
    }
}

/// With this the names of observables begin that are the state of a contact with friction: 0 open, 1 stick, 2 slip forwards, 3 slip backwards.
pub const CONTACT_STATE: &str = "contact_state_";

/// Names what is observed of contacts with friction besides: from `contact_force_left_n` the friction force `friction_force_left_n` and the state
/// `contact_state_left`, and how many contacts stick.
///
/// The state is 0 for open, 1 for stick, 2 for slip forwards, 3 for slip backwards, as the solver of the last step has it; of a contact that is
/// closed and carries nothing, or that is redundant, as it moves, to the tolerance of the solver.
pub(in crate::mechanics) fn friction_observables(force_names: &[Name]) -> Vec<Name> {
    let contact = |name: &Name| {
        let name = name.strip_prefix("contact_").unwrap_or(name);
        let name = name.strip_prefix("force_").unwrap_or(name);
        name.strip_suffix("_n").unwrap_or(name).to_owned()
    };
    let forces = force_names.iter().map(|name| format!("friction_force_{}_n", contact(name)));
    let states = force_names.iter().map(|name| format!("{CONTACT_STATE}{}", contact(name)));
    forces.chain(states).chain(["sticking_contacts".to_owned()]).map(Name::from).collect()
}

impl ContactStepper {
    /// Gives the contacts friction.
    ///
    /// # Errors
    /// [`Error::Incompatible`] or [`Error::InvalidValue`] for a law that cannot be, or a system that has no friction to offer.
    pub(in crate::mechanics) fn add_friction(&mut self, friction: Friction, tangential_rows: usize) -> Result<()> {
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
        if restitution != self.law.restitution {
            return refused(format!(
                "a restitution of {} along the normal and of {restitution} along the surface can create energy; use one for both (Moreau's law)",
                self.law.restitution
            ));
        }
        if self.is_compliant() {
            return refused("contacts that give way have none".to_owned());
        }
        if self.is_sparse() {
            return refused("contacts by the dozen, of which few meet, have none".to_owned());
        }
        if !self.solver.goes_by_active_sets() {
            return refused("contacts with friction are solved over their states; use solver `active-set`".to_owned());
        }
        let contacts = FrictionalContacts {
            law: friction,
            coefficients: vec![coefficient; n],
            solver: FrictionSolver::new(n, self.solver.tolerance()).witnessed_by(self.solver.witness()),
            h: vec![0.0; 4 * n * n],
            b: vec![0.0; 2 * n],
            w: vec![0.0; 2 * n],
        };
        self.eq3.tangential = Rows::zeros(n, self.v.len());
        self.friction = Some(Box::new(contacts));
        self.eq4 = self.empty_model();
        self.condensation = Condensation::of(&self.eq4);
        self.make_room_for_rebounds();
        self.forget_reduction();
        self.elimination = Elimination::new(&self.eq3);
        self.impulses = vec![0.0; self.eq4.a.len()];
        Ok(())
    }

    /// Whether contacts have friction.
    pub(in crate::mechanics) fn has_friction(&self) -> bool {
        self.friction.is_some()
    }

    /// Friction impulses of the last step, N·s.
    pub(in crate::mechanics) fn friction_impulses(&self) -> &[f64] {
        &self.impulses[self.eq4.contacts()..self.eq4.interface_start()]
    }

    /// Solves the contacts of one step; `impulses` holds `h λ_i` already.
    ///
    /// ```text
    /// b_n = w_n + h a_n + H_ni h λ_i + gap term        b_t = w_t + h a_t + H_ti h λ_i, + e w_t of a contact that rebounds
    /// ```
    pub(super) fn solve_frictional(&mut self, h: f64) -> Result<(), Failure> {
        let (n, rows, first) = (self.eq4.contacts(), self.impulses.len(), self.eq4.interface_start());
        if self.eq4.stiction.is_some() && self.last_step.is_infinite() {
            // What stands still before the first step is held.
            self.find_closed();
        }
        let Some(mut contacts) = self.friction.take() else { return Ok(()) };
        for row in 0..first {
            let (h_cc, h_ci) = self.eq4.h[row * rows..(row + 1) * rows].split_at(first);
            let free = self.eq4.w[row] + h * self.eq4.a[row] + body_dot(h_ci, &self.impulses[first..]);
            let term = if row < n { self.contact_term(row, h) } else { self.rebound_along(row, h) };
            contacts.b[row] = free + term;
            contacts.h[row * first..(row + 1) * first].copy_from_slice(h_cc);
        }
        let problem = FrictionProblem { h: &contacts.h, b: &contacts.b, friction: &self.eq4.friction };
        let impulses = &mut self.impulses[..first];
        let solved = contacts.solver.solve(problem, impulses);
        problem.velocities(impulses, &mut contacts.w);
        if let (Some(stiction), Solved::Velocity) = (self.eq4.stiction, self.solved) {
            let (states, standstill) = (contacts.solver.states(), contacts.standstill());
            for ((coefficient, state), w_t) in self.eq4.friction.iter_mut().zip(states).zip(&contacts.w[first / 2..]) {
                *coefficient = stiction.after(state.moving(*w_t, standstill));
            }
        }
        self.friction = Some(contacts);
        solved?;
        Ok(())
    }

    /// What stands in the tangential row (stacked) of a contact that rebounds.
    fn rebound_along(&self, row: usize, h: f64) -> f64 {
        if !self.rebounds.any() {
            return 0.0;
        }
        self.rebounds.term_along(&self.impact_step(h), row - self.eq4.contacts(), self.eq4.w[row])
    }

    /// Finds the contacts whose row was at its bound in the last step, and what they did along the surface.
    ///
    /// Loaded ones are in the state that the solver found; those at their bound without load as they move, to the solver's tolerance.
    pub(super) fn find_states(&mut self) {
        let (n, started) = (self.eq4.contacts(), self.last_step.is_finite());
        let Some(contacts) = &self.friction else { return };
        let bound = contacts.standstill();
        if started {
            self.eq4.solved_states.copy_from_slice(contacts.solver.states());
        }
        for contact in 0..n {
            let (closed, w_t, found) = if started {
                let bounces = self.rebounds.rebounds(contact);
                let state = contacts.solver.states()[contact];
                (contacts.w[contact] <= bound && !bounces, contacts.w[n + contact], state)
            } else {
                (self.eq3.unilateral.position[contact] <= TOUCHING, self.eq4.w[n + contact], ContactState::Open)
            };
            self.eq4.at_bound[contact] = closed;
            self.eq4.states[contact] = match (closed, found) {
                (false, _) => ContactState::Open,
                (true, ContactState::Open) => ContactState::of_closed(w_t, if started { bound } else { 0.0 }),
                (true, loaded) => loaded,
            };
            if let (Some(stiction), false) = (self.eq4.stiction, started) {
                self.eq4.friction[contact] = stiction.after(self.eq4.states[contact]);
            }
        }
    }

    /// Writes what is observed of contacts with friction besides: friction forces, then states, then how many stick. Closed contacts must be
    /// known.
    pub(in crate::mechanics) fn observe_friction(&self, row: &mut [f64]) {
        let (forces, rest) = row.split_at_mut(row.len() / 2);
        let (states, sticking) = rest.split_at_mut(forces.len());
        for (force, impulse) in forces.iter_mut().zip(self.friction_impulses()) {
            *force = impulse / self.last_step;
        }
        sticking[0] = 0.0;
        let Some(contacts) = &self.friction else { return };
        let standstill = contacts.standstill();
        let moved = &contacts.w[self.eq4.contacts()..];
        for ((shown, state), w_t) in states.iter_mut().zip(&self.eq4.states).zip(moved) {
            let state = if self.last_step.is_finite() { state.moving(*w_t, standstill) } else { *state };
            *shown = f64::from(state as u8);
            sticking[0] += f64::from(u8::from(state == ContactState::Stick));
        }
    }
}
