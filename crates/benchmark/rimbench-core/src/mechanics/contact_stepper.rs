//! One step of Eqs. 1 to 3 for any mechanical model: Eq. 3 is reduced to Eq. 4, whose contact problem is solved.
//!
//! ```text
//! Eq. 3 → 4         H, a, w, g at (q, v)                b = w + h a in the paper
//! contact problem   w⁺ = w + h a + H [P; h λ_i]         0 ≤ w_n⁺ + t_n ⟂ P_n ≥ 0; t: gap or impact term
//! Eq. 1             v⁺ = v̂ + h α + G Aᵀ [P; h λ_i]      q⁺ = q + h v⁺: N = 1
//! ```
//! `P = h λ_u⁺`, with friction `[P_n; P_t]` under Coulomb's law; v̂, α and G are those of [`Elimination`].

mod closed_contacts;
mod contact_law;
mod energy;
mod implicit_step;
mod midpoint_step;
mod observables;
mod rebounding;
mod step_contacts;

pub use contact_law::ContactLaw;
pub(super) use implicit_step::ImplicitPart;
pub(super) use midpoint_step::{ActiveProblem, MidpointStep};
pub(super) use observables::CONTACT_OBSERVABLES;
pub(super) use step_contacts::friction_observables;
pub use step_contacts::{Friction, is_contact_state};

use self::energy::EnergyBalance;
use self::rebounding::Rebounding;
use self::step_contacts::{ContactTerms, StepContacts};
use super::mechanical_model::{MechanicalModel, ModelSize};
use crate::cosim::SubsystemCounters;
use crate::error::Failure;
use crate::interface_model::{Condensation, Elimination, Linearisation, ReducedInterfaceModel};
use rimbench_contact::complementarity::Checked;
use rimbench_contact::contact_law::Solved;

/// State, Eq. 3 and Eq. 4 of a mechanical system, and its contact problem.
#[derive(Clone)]
pub(super) struct ContactStepper {
    pub(super) law: ContactLaw,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    v_next: Vec<f64>,
    /// Velocity v′ by which positions change: `q⁺ = q + h v′` where a contact rebounds, `q⁺ = q + ½h (v + v′)` where
    /// the force varies within a midpoint step.
    pub(super) v_displacement: Vec<f64>,
    pub(super) eq3: Linearisation,
    elimination: Elimination,
    /// Where steps of the second order take stiff forces implicitly.
    pub(super) implicit: Option<Box<ImplicitPart>>,
    pub(super) eq4: ReducedInterfaceModel,
    /// Step h for which `eq4` is reduced from `eq3` at `(q, v)`; none once the state has changed.
    reduced_for: Option<f64>,
    contacts: StepContacts,
    rebounding: Rebounding,
    /// Whether `eq4.at_bound` has been found from the last step.
    closed_known: bool,
    /// `[P_u; h λ_i]`, `P_u = h λ_u⁺`; with friction `[P_u; P_t; h λ_i]`.
    impulses: Vec<f64>,
    /// `h λ_b⁺`.
    p_b: Vec<f64>,
    /// Length of the last step, s; infinite before the first, so that forces then are zero.
    last_step: f64,
    /// For observables: the closed contacts, and Eq. 4 with these bilateral.
    closed: Vec<usize>,
    normal_rows: Vec<f64>,
    condensation: Condensation,
    pub(super) energy: EnergyBalance,
    counters: SubsystemCounters,
}

impl ContactStepper {
    /// Makes the stepper of a system of this size at its start state `(q, v)`; `eq3` gives the form of Eq. 3, still
    /// empty.
    pub(super) fn new(
        size: ModelSize,
        eq3: Linearisation,
        (q, v): (Vec<f64>, Vec<f64>),
        law: ContactLaw,
        solver: Checked,
    ) -> Self {
        let pattern = Elimination::delassus_pattern(&eq3);
        let (elimination, tolerance) = (Elimination::with_pattern(&eq3, pattern.as_deref()), solver.tolerance());
        let contacts = StepContacts::new(size.unilateral, pattern.as_deref(), solver);
        let mut eq4 = match pattern {
            Some(pattern) => ReducedInterfaceModel::zeros_of(pattern, size.interface),
            None => ReducedInterfaceModel::zeros(size.unilateral, size.interface),
        };
        law.apply_to(&mut eq4);
        let mut stepper = ContactStepper {
            law,
            v_next: v.clone(),
            v_displacement: v.clone(),
            elimination,
            implicit: None,
            normal_rows: Vec::with_capacity(if eq4.has_friction() { eq4.contacts() * eq4.contacts() } else { 0 }),
            condensation: Condensation::of(&eq4),
            eq4,
            reduced_for: None,
            contacts,
            rebounding: Rebounding::default(),
            closed_known: false,
            impulses: vec![0.0; size.unilateral + size.interface],
            p_b: vec![0.0; size.bilateral],
            last_step: f64::INFINITY,
            closed: Vec::with_capacity(size.unilateral),
            energy: EnergyBalance::new(size.velocities),
            counters: SubsystemCounters::default(),
            q,
            v,
            eq3,
        };
        stepper.reserve_rebounds(tolerance);
        stepper
    }

    /// Reserves rebounds for the present rows of the contacts, where they rebound.
    fn reserve_rebounds(&mut self, tolerance: f64) {
        if self.law.rebounds() {
            self.rebounding = Rebounding::new(&self.eq4, tolerance);
        }
    }

    /// Reduces Eq. 3 at the present state to Eq. 4 for a step `h`, unless that is done.
    pub(super) fn reduce(&mut self, h: f64) -> Result<(), Failure> {
        if self.reduced_for == Some(h) {
            return Ok(());
        }
        self.elimination.reduce(&self.eq3, &self.v, h, self.law.stabilisation, &mut self.eq4)?;
        self.counters.eliminations += 1;
        self.reduced_for = Some(h);
        if self.law.rebounds() {
            let started = self.last_step.is_finite();
            if started {
                self.find_closed();
            }
            let gaps_at_start = (!started).then_some(&self.eq3.unilateral.position[..]);
            self.rebounding.record_touched(&self.eq4.at_bound, gaps_at_start);
            self.rebounding.write_approach(&self.eq3, &self.v, h, &mut self.eq4);
        }
        Ok(())
    }

    /// Advances velocities and positions by one step (Eq. 1); Eq. 3 stays that of the state before.
    pub(super) fn advance(&mut self, model: &impl MechanicalModel, lambda: &[f64], h: f64) -> Result<(), Failure> {
        self.reduce(h)?;
        self.solve_contacts(lambda, h)?;
        self.elimination.velocity_after(h, &self.impulses, &mut self.v_next);
        self.elimination.bilateral_impulses(h, &self.impulses, &mut self.p_b);
        self.book_energy(h);
        std::mem::swap(&mut self.v, &mut self.v_next);
        let v_displacement = if self.rebounding.any() { &self.v_displacement } else { &self.v };
        model.advance_positions(&mut self.q, v_displacement, h);
        self.last_step = h;
        self.closed_known = false;
        self.counters.micro_steps += 1;
        if self.law.rebounds() {
            self.rebounding.rotate();
        }
        // A velocity that is not finite has reached the position by now.
        if self.q.iter().fold(0.0, |zero, q| zero + q * 0.0) != 0.0 {
            return Err(Failure::non_finite("mechanical state"));
        }
        Ok(())
    }

    /// Solves the contact problem of one step, and writes `[P_u; h λ_i]` to `impulses`.
    fn solve_contacts(&mut self, lambda: &[f64], h: f64) -> Result<(), Failure> {
        let first = self.eq4.interface_start();
        match (&mut self.impulses[first..], lambda) {
            // Mostly one.
            ([impulse], [force]) => *impulse = h * force,
            (impulses, forces) => impulses.iter_mut().zip(forces).for_each(|(impulse, force)| *impulse = h * force),
        }
        if self.law.rebounds() {
            let ContactStepper { rebounding, law, eq4, impulses, contacts, .. } = self;
            rebounding.find(law, eq4, &impulses[first..], h, contacts)?;
        }
        if self.eq4.stiction.is_some() && self.last_step.is_infinite() {
            // Before the first step contacts without tangential velocity have the coefficient at rest.
            self.find_closed();
        }
        let ContactStepper { rebounding, law, eq4, impulses, contacts, .. } = self;
        let terms = ContactTerms { law, eq4, rebounding, h, solved: Solved::Velocity };
        if rebounding.any() {
            contacts.solve(ContactTerms { solved: Solved::Displacement, ..terms }, impulses)?;
            self.elimination.velocity_after(h, impulses, &mut self.v_displacement);
        }
        contacts.solve(terms, impulses)?;
        self.energy.damper_loss = contacts.damper_loss(terms, impulses, self.energy.damper_loss);
        Ok(())
    }

    /// Adds the work of one step to the energy balance.
    fn book_energy(&mut self, h: f64) {
        let contacts = &self.impulses[..self.eq4.interface_start()];
        let slip = self.contacts.coulomb().map_or(0.0, |coulomb| coulomb.slip(&contacts[self.eq4.contacts()..]));
        self.energy.book(&self.eq3, (&self.v, &self.v_next), (&self.impulses, &self.p_b), slip, h);
    }

    /// Writes the interface model, Eq. 4 at the present state, for a step `h`.
    pub(super) fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<(), Failure> {
        self.reduce_for_model(h)?;
        self.find_closed();
        model.copy_from(&self.eq4);
        if let Some(coulomb) = self.contacts.coulomb() {
            let started = self.last_step.is_finite();
            coulomb.write_modes(model, started);
            for (force, impulse) in model.solved_forces.iter_mut().zip(&self.impulses) {
                *force = if started { impulse / self.last_step } else { 0.0 };
            }
        }
        Ok(())
    }

    /// Returns an interface model of this system's size and contact law, its entries zero.
    pub(super) fn empty_model(&self) -> ReducedInterfaceModel {
        let mut model = match (self.eq4.delassus_pattern(), self.contacts.coulomb()) {
            (Some(pattern), _) => ReducedInterfaceModel::zeros_of(pattern.clone(), self.eq4.interface()),
            (None, Some(coulomb)) => coulomb.empty_model(self.eq4.interface()),
            (None, None) => ReducedInterfaceModel::zeros(self.eq4.contacts(), self.eq4.interface()),
        };
        self.law.apply_to(&mut model);
        model.plastic.clone_from(&self.eq4.plastic);
        model
    }

    /// Marks Eq. 4 as outdated, as Eq. 3 is that of a new state.
    pub(super) fn forget_reduction(&mut self) {
        self.reduced_for = None;
    }

    /// Returns the contact impulses `h λ_u⁺` of the last step, N·s, which are not unique where contacts are redundant.
    pub(super) fn contact_impulses(&self) -> &[f64] {
        &self.impulses[..self.eq3.unilateral.len()]
    }

    /// Returns how many steps, eliminations and contact problems there were.
    pub(super) fn counters(&self) -> SubsystemCounters {
        SubsystemCounters { solver: self.contacts.counters(), ..self.counters }
    }

    /// Writes position and velocity `w_i = A_i v` of the interface rows.
    pub(super) fn interface_motion(&self, y: &mut [f64]) {
        let n_i = self.eq3.interface.len();
        y[..n_i].copy_from_slice(&self.eq3.interface.position);
        for (index, velocity) in y[n_i..].iter_mut().enumerate() {
            *velocity = self.eq3.interface.velocity(index, &self.v);
        }
    }

    /// Returns the solver of `H_uu` with every entry, where only its non-zeros are kept.
    pub(super) fn dense_solver(&self) -> Option<&Checked> {
        self.contacts.dense_solver()
    }
}
