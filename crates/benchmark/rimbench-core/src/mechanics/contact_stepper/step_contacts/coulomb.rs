//! Contacts with friction in a step of the mechanics.

use super::super::ContactStepper;
use super::{ContactTerms, DenseProblem, StepContacts};
use crate::error::{Error, Failure, Result};
use crate::interface_model::{
    Condensation, ContactModes, Elimination, ReducedInterfaceModel, Rows, TOUCHING, closed_in_space,
    rank_of_normal_rows,
};
use crate::name::Name;
use rimbench_contact::complementarity::{SolverCounters, Unsolved};
use rimbench_contact::contact_law::Solved;
use rimbench_contact::friction::space::{SpaceProblem, SpaceSolver};
use rimbench_contact::friction::{ContactState, FrictionProblem, FrictionSolver, Stiction};
use rimbench_contact::linear_algebra::largest_entry;
use rimbench_contact::solver_entry::SolverEntry;

/// Friction of the contacts: Coulomb's law, in the plane or in space.
///
/// ```text
/// |P_t| ≤ μ P_n,  w_t · P_t = −μ P_n |w_t|
/// ```
/// # Source
/// Moreau's law of impact with one restitution along the normal and along the surface takes energy in every impact.
/// With a smaller one along the surface, such as Newton's law along the normal alone, a few of a hundred random impacts
/// create some: the energy account shows it.
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

/// The solver of a step's contacts with friction.
#[derive(Clone)]
#[expect(clippy::large_enum_variant, reason = "it stands in a box with the rest of the step")]
enum ConeSolver {
    Plane(FrictionSolver),
    Space(SpaceSolver),
}

/// The contact problem of a step with friction and its solver, and the state and coefficient of each contact after it.
#[derive(Clone)]
pub(in crate::mechanics) struct CoulombStep {
    law: Friction,
    solver: ConeSolver,
    /// `[H_nn H_nt; H_tn H_tt]`, `[b_n; b_t]` and `H P + b` of the last step.
    pub(super) problem: DenseProblem,
    /// Coefficient of each contact in the next step, and its state (open, stick or slip) in the last one.
    friction: Vec<f64>,
    states: Vec<ContactState>,
    /// Direction in which each slid, in space; empty in the plane.
    directions: Vec<[f64; 2]>,
    /// Length of the last step in space, s.
    last_step: f64,
}

impl CoulombStep {
    /// Returns the states that the solver found in the plane; in space there are none but by the motion.
    fn solved_states(&self) -> &[ContactState] {
        match &self.solver {
            ConeSolver::Plane(solver) => solver.solver.states(),
            ConeSolver::Space(_) => &[],
        }
    }

    fn is_in_space(&self) -> bool {
        matches!(self.solver, ConeSolver::Space(_))
    }

    fn tolerance(&self) -> f64 {
        match &self.solver {
            ConeSolver::Plane(solver) => solver.tolerance(),
            ConeSolver::Space(solver) => solver.tolerance(),
        }
    }

    /// Returns an interface model of these contacts, zero.
    pub(in super::super) fn empty_model(&self, interface: usize) -> ReducedInterfaceModel {
        if self.is_in_space() {
            return ReducedInterfaceModel::zeros_in_space(&self.friction, interface);
        }
        let mut empty = ReducedInterfaceModel::zeros_with_friction(&self.friction, interface);
        empty.tangential_restitution = self.law.restitution;
        empty.stiction = self.law.stiction();
        empty
    }

    /// Returns the states of the contacts in the last step, with their coefficients.
    pub(in super::super) fn modes(&self) -> ContactModes<'_> {
        ContactModes { states: &self.states, friction: &self.friction, directions: &self.directions }
    }

    /// Writes coefficients and modes to the model that is sent.
    pub(in super::super) fn write_modes(&self, model: &mut ReducedInterfaceModel, started: bool) {
        model.friction.copy_from_slice(&self.friction);
        model.states.copy_from_slice(&self.states);
        model.directions.copy_from_slice(&self.directions);
        if started {
            model.solved_states.copy_from_slice(self.solved_states());
        }
    }

    pub(in super::super) fn counters(&self) -> SolverCounters {
        match &self.solver {
            ConeSolver::Plane(solver) => solver.counters(),
            ConeSolver::Space(solver) => solver.counters(),
        }
    }

    /// Returns the velocity up to which a contact sticks in the solution of the last step, `τ ‖b‖_∞` with the solver's
    /// tolerance τ, m/s; in space over the contacts that could close.
    pub(in super::super) fn rounding_velocity(&self) -> f64 {
        let DenseProblem { h, b, .. } = &self.problem;
        let scale = match &self.solver {
            ConeSolver::Plane(_) => largest_entry(b),
            ConeSolver::Space(_) => SpaceProblem::with_friction(h, b, &self.friction).scale(),
        };
        self.tolerance() * scale
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
        self.problem.add_compliance(terms);
        let DenseProblem { h, b, w } = &mut self.problem;
        let solver = match &mut self.solver {
            ConeSolver::Plane(solver) => solver,
            ConeSolver::Space(solver) => {
                if self.last_step > 0.0 && self.last_step != terms.h {
                    solver.solver.scale_start(terms.h / self.last_step);
                }
                self.last_step = terms.h;
                let problem = SpaceProblem::with_friction(h, b, &self.friction);
                let solved = solver.solve(problem, impulses);
                problem.velocities_by_dot(impulses, w);
                solved?;
                return Ok(());
            }
        };
        let problem = FrictionProblem::with_friction(h, b, &self.friction);
        let solved = solver.solve(problem, impulses);
        problem.velocities(impulses, w);
        if let (Some(stiction), Solved::Velocity) = (self.law.stiction(), terms.solved) {
            let rounding = self.rounding_velocity();
            let ConeSolver::Plane(solver) = &self.solver else { return Ok(()) };
            let w_t = self.problem.w[self.friction.len()..].iter().copied();
            stiction.update(&mut self.friction, solver.solver.states(), w_t, rounding);
        }
        solved?;
        Ok(())
    }

    /// Solves a trial with the right-hand side `b`, which leaves coefficients as they are; writes its velocities as
    /// well.
    pub(in super::super) fn try_solve(
        &mut self,
        b: &[f64],
        impulses: &mut [f64],
        velocities: &mut [f64],
    ) -> Result<(), Unsolved> {
        let ConeSolver::Plane(solver) = &mut self.solver else { unreachable!("in space nothing rebounds") };
        let problem = FrictionProblem::with_friction(&self.problem.h, b, &self.friction);
        solver.solve(problem, impulses)?;
        problem.velocities(impulses, velocities);
        Ok(())
    }

    /// Finds whether the contacts closed in the last step stick or slip; before the first step, from their velocities.
    ///
    /// Loaded ones have the state that the solver found; closed ones without load that of their velocity, to the
    /// solver's tolerance.
    pub(in super::super) fn find_modes(&mut self, eq4: &ReducedInterfaceModel, started: bool) {
        let (n, rounding) = (self.friction.len(), self.rounding_velocity());
        if self.is_in_space() {
            let (w, rounding) = if started { (&self.problem.w, rounding) } else { (&eq4.w, 0.0) };
            for contact in 0..n {
                let (state, direction) = closed_in_space([w[n + contact], w[2 * n + contact]], rounding);
                self.states[contact] = if eq4.at_bound[contact] { state } else { ContactState::Open };
                self.directions[contact] = direction;
            }
            return;
        }
        for contact in 0..n {
            let (w_t, found) = if started {
                (self.problem.w[n + contact], self.solved_states()[contact])
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
const CONTACT_STATE: &str = "contact_state_";

/// Tells whether an observable of this name is the state of a contact with friction.
pub fn is_contact_state(name: &str) -> bool {
    name.starts_with(CONTACT_STATE)
}

/// Names the additional observables of contacts with friction: of `left` the friction force `friction_force_left_n` and
/// the state `contact_state_left`, and how many contacts stick.
///
/// The state is that of the solver in the last step; of a contact that is closed without an impulse, or redundant, that
/// of its velocity, to the tolerance of the solver.
///
/// In space the force is its magnitude, the state 0, 1 or 2 (open, stick, slip), and after all these comes the angle of
/// the slip about the normal, `slip_angle_left_rad`, from the first tangent to the second one, 0 where the contact does
/// not slide.
pub(in crate::mechanics) fn friction_observables(contacts: &[Name], in_space: bool) -> Vec<Name> {
    let forces = contacts.iter().map(|contact| format!("friction_force_{contact}_n"));
    let states = contacts.iter().map(|contact| format!("{CONTACT_STATE}{contact}"));
    let angles = contacts.iter().filter(|_| in_space).map(|contact| format!("slip_angle_{contact}_rad"));
    forces.chain(states).chain(["sticking_contacts".to_owned()]).chain(angles).map(Name::from).collect()
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
        let in_space = tangential_rows == 2 * n;
        if !(tangential_rows == n || in_space) || n == 0 {
            return refused(format!("the mechanics has {tangential_rows} tangential rows for {n} contacts"));
        }
        if !(0.0..=self.law.restitution).contains(&restitution) {
            let found = format!("a restitution of {restitution} along the surface");
            return refused(format!("{found} is none; valid: 0 to that along the normal, {}", self.law.restitution));
        }
        if self.dense_solver().is_some() {
            return refused("contacts by the dozen, of which few are coupled, have none".to_owned());
        }
        if in_space {
            self.check_space(friction)?;
        }
        let Some(plane) = solver.checked_with_friction(n) else {
            let reason = "contacts with friction are solved over their states; use solver `active-set`";
            return refused(reason.to_owned());
        };
        let tolerance = plane.tolerance();
        let contacts = CoulombStep {
            law: friction,
            solver: if in_space { ConeSolver::Space(SpaceSolver::new(n, tolerance)) } else { ConeSolver::Plane(plane) },
            problem: DenseProblem::new(n + tangential_rows),
            friction: vec![coefficient; n],
            states: vec![ContactState::Open; n],
            directions: vec![[1.0, 0.0]; if in_space { n } else { 0 }],
            last_step: 0.0,
        };
        self.eq3.tangential = Rows::zeros(tangential_rows, self.v.len());
        self.contacts = StepContacts::Coulomb(Box::new(contacts));
        self.eq4 = self.empty_model();
        self.condensation = Condensation::of(&self.eq4);
        self.reserve_rebounds(tolerance);
        self.forget_reduction();
        self.elimination = Elimination::new(&self.eq3);
        self.impulses = vec![0.0; self.eq4.a.len()];
        Ok(())
    }

    /// Refuses what contacts with friction in space do not have.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for a restitution, a coefficient at rest of its own, and rigid contacts that touch at
    /// the start and whose normal rows depend on each other: they are redundant, and their velocities not unique where
    /// they slide with spin.
    fn check_space(&mut self, Friction { coefficient, at_rest, .. }: Friction) -> Result<()> {
        let refused = |what: String, why: &str| {
            Err(Error::Incompatible(format!("{what} does not go with friction in space: {why}")))
        };
        if self.law.restitution > 0.0 {
            let why = "impacts with two tangential rows are not implemented; set it to 0";
            return refused(format!("restitution = {}", self.law.restitution), why);
        }
        if at_rest > coefficient {
            let why = "which coefficient holds is not remembered there; set it to 0, for that in motion";
            return refused(format!("static_friction = {at_rest}"), why);
        }
        if self.law.spring.is_some() {
            return Ok(());
        }
        let gaps = &self.eq3.unilateral.position;
        let all: Vec<usize> = (0..gaps.len()).filter(|&contact| gaps[contact] <= TOUCHING).collect();
        // Any step will do: the rank is that of the rows.
        self.reduce(1.0).map_err(|failure| Error::Incompatible(failure.to_string()))?;
        let (n, rank) = (all.len(), rank_of_normal_rows(&self.eq4, &all, &mut self.normal_rows));
        if rank < n {
            return Err(Error::Incompatible(format!(
                "the {n} contacts that touch at the start are redundant: their normal rows have rank {rank}. Where rigid contacts slide with \
                 spin in space, the motion then depends on how they share the load and is not unique; give each a spring and a damper \
                 (contact_compliance_m_n, contact_damping_n_s_m), use as many contacts as their rank, or move them apart"
            )));
        }
        Ok(())
    }

    /// Tells whether contacts with friction have two tangential rows.
    pub(in crate::mechanics) fn is_in_space(&self) -> bool {
        self.contacts.coulomb().is_some_and(CoulombStep::is_in_space)
    }

    /// Tells whether contacts have friction.
    pub(in crate::mechanics) fn has_friction(&self) -> bool {
        self.contacts.coulomb().is_some()
    }

    /// Returns the friction impulses of the last step, N·s.
    pub(in crate::mechanics) fn friction_impulses(&self) -> &[f64] {
        &self.impulses[self.eq4.contacts()..self.eq4.interface_start()]
    }

    /// Writes the additional observables of contacts with friction: friction forces, states, and how many stick. Closed
    /// contacts must be found before.
    pub(in crate::mechanics) fn observe_friction(&self, row: &mut [f64]) {
        let n = self.eq4.contacts();
        if self.is_in_space() {
            return self.observe_friction_in_space(row);
        }
        let (forces, rest) = row.split_at_mut(row.len() / 2);
        let (states, sticking) = rest.split_at_mut(forces.len());
        for (force, impulse) in forces.iter_mut().zip(self.friction_impulses()) {
            *force = impulse / self.last_step;
        }
        sticking[0] = 0.0;
        let Some(contacts) = self.contacts.coulomb() else { return };
        let rounding = contacts.rounding_velocity();
        let moved = &contacts.problem.w[n..];
        for ((shown, state), w_t) in states.iter_mut().zip(&contacts.states).zip(moved) {
            let state = if self.last_step.is_finite() { state.moving(*w_t, rounding) } else { *state };
            *shown = state.as_number();
            sticking[0] += f64::from(u8::from(state == ContactState::Stick));
        }
    }
    /// Writes magnitudes of friction forces, states, how many stick, and angles of slip.
    fn observe_friction_in_space(&self, row: &mut [f64]) {
        let (n, shown) = (self.eq4.contacts(), row.len() / 3);
        let Some(contacts) = self.contacts.coulomb() else { return };
        let (forces, rest) = row.split_at_mut(shown);
        let (states, rest) = rest.split_at_mut(shown);
        let (sticking, angles) = rest.split_at_mut(1);
        sticking[0] = 0.0;
        for contact in 0..shown {
            let friction = [self.impulses[n + contact], self.impulses[2 * n + contact]];
            forces[contact] = (friction[0] * friction[0] + friction[1] * friction[1]).sqrt() / self.last_step;
            let (state, [x, y]) = (contacts.states[contact], contacts.directions[contact]);
            states[contact] = state.as_number();
            sticking[0] += f64::from(u8::from(state == ContactState::Stick));
            angles[contact] = if state == ContactState::SlipPositive { libm::atan2(y, x) } else { 0.0 };
        }
    }
}
