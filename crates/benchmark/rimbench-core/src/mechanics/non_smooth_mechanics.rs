//! A mechanical model with contacts, offered as a subsystem.

mod second_order;

use super::contact_stepper::{
    CONTACT_OBSERVABLES, ContactLaw, ContactStepper, Friction, ImplicitPart, friction_observables,
};
use super::energy_ledger::EnergyLedger;
use super::mechanical_model::{MechanicalModel, ModelNames};
use super::memory::{bytes_needed, empty_equations};
use super::stiff_forces::StiffForces;
use crate::cosim::{
    Capabilities, ContactMechanics, EnergyAccount, ForceProfile, JointActuator, Ports, SecondOrder, Sent, Subsystem,
    SubsystemCounters, subsystem_methods,
};
use crate::error::{Error, Failure, Result};
use crate::interface_model::{Linearisation, MEMORY_LIMIT, ReducedInterfaceModel};
use crate::name::Name;
use rimbench_contact::complementarity::Checked;
use rimbench_contact::solver_entry::SolverEntry;
use second_order::{Excitation, SecondOrderSteps};

/// Steps a mechanical model with contacts.
///
/// ```text
/// b_u = w_u + h a_u + H_ui h λ_i + gap term        0 ≤ H_uu P_u + b_u ⟂ P_u ≥ 0
/// v⁺  = v̂ + h α + G A_uᵀ P_u + G A_iᵀ h λ_i        q⁺ = q + h v⁺
/// ```
/// The reduction at `t_k` is made once and serves both the interface model and the step that follows.
/// # Source
/// Raoofian, Kövecses, Teichmann, Eqs. 1–4, with `M̂ = M`, `ĉ = c` (semi-implicit); gap law ours.
#[derive(Clone)]
pub struct NonSmoothMechanics<M> {
    pub(super) model: M,
    pub(super) stepper: ContactStepper,
    /// Where steps are of the second order.
    second_order: Option<Box<SecondOrderSteps>>,
    ports: Ports,
    observables: Vec<Name>,
    /// How many of them are the model's own; gaps and forces of the contacts follow.
    own_observables: usize,
    contacts: Vec<Name>,
    /// `T`, `V` and that of contact springs at the start, J.
    start_energy: [f64; 3],
}

impl<M: MechanicalModel> NonSmoothMechanics<M> {
    /// Places `model` at its start state. `ports` must name `n_i` forces in, `n_i` positions and `n_i` velocities out.
    pub fn new(mut model: M, law: ContactLaw, ports: Ports, solver: Checked) -> Self {
        let size = model.size();
        debug_assert_eq!(ports.inputs.len(), size.interface);
        debug_assert_eq!(ports.outputs.len(), 2 * size.interface);
        let start = model.initial_state();
        model.prepare(&start.0, &start.1);
        let ModelNames { mut observables, contacts } = model.names();
        let own_observables = observables.len();
        observables.extend(contacts.iter().map(|contact| format!("gap_{contact}_m").into()));
        observables.extend(contacts.iter().map(|contact| format!("contact_force_{contact}_n").into()));
        observables.extend(CONTACT_OBSERVABLES.map(Name::from));
        let eq3 = empty_equations(&model, &start.0, law, solver.solver.goes_by_active_sets());
        let mut mechanics = NonSmoothMechanics {
            stepper: ContactStepper::new(size, eq3, start, law, solver),
            second_order: None,
            ports,
            observables,
            own_observables,
            contacts,
            start_energy: [0.0; 3],
            model,
        };
        mechanics.start();
        let potential = mechanics.model.potential_energy(mechanics.position());
        let springs = mechanics.stepper.spring_energy();
        mechanics.start_energy = [mechanics.stepper.kinetic_energy(), potential, springs];
        mechanics
    }

    /// Makes Eq. 3 that of the start state.
    fn start(&mut self) {
        let size = self.model.size();
        if !size.plastic.is_empty() {
            self.stepper.eq4.plastic = (0..size.unilateral).map(|contact| size.plastic.contains(&contact)).collect();
        }
        self.linearise();
    }

    /// Gives the contacts friction, solved by `solver`; the model must have tangential rows.
    ///
    /// # Errors
    /// [`Error::InvalidValue`](crate::error::Error::InvalidValue) for a coefficient that is none;
    /// [`Error::Incompatible`](crate::error::Error::Incompatible) for a model without tangential rows, contacts kept by
    /// the dozen, a restitution along the surface alone, a solver that has none for friction, or a
    /// mechanics that steps at the second order.
    pub fn with_friction(mut self, friction: Friction, solver: &SolverEntry) -> Result<Self> {
        if self.second_order.is_some() {
            return Err(Error::Incompatible(
                "friction does not go with a rule of the second order, which was asked for before".into(),
            ));
        }
        self.keep_every_entry();
        self.stepper.add_friction(friction, self.model.size().tangential, solver)?;
        self.observables.extend(friction_observables(&self.contacts, self.stepper.is_in_space()));
        self.linearise();
        Ok(self)
    }

    /// Returns the friction impulses of the last step, along the surface, N·s; none without friction. Not unique where
    /// contacts are redundant.
    pub fn friction_impulses(&self) -> &[f64] {
        self.stepper.friction_impulses()
    }

    /// Returns q, in the units of the model.
    pub fn position(&self) -> &[f64] {
        &self.stepper.q
    }

    /// Returns v, in the units of the model.
    pub fn velocity(&self) -> &[f64] {
        &self.stepper.v
    }

    /// Returns Eq. 3 at the present state.
    pub fn linearisation(&self) -> &Linearisation {
        &self.stepper.eq3
    }

    /// Returns the energy account.
    pub fn ledger(&self) -> &EnergyLedger {
        &self.stepper.energy.ledger
    }

    /// Returns kinetic plus potential energy, J.
    pub fn energy(&self) -> f64 {
        self.stepper.kinetic_energy() + self.model.potential_energy(self.position())
    }

    /// Returns the contact impulses of the last step, N·s. Not unique where contacts are redundant.
    pub fn contact_impulses(&self) -> &[f64] {
        self.stepper.contact_impulses()
    }

    /// Does something with what steps of the second order remember; nothing where they are of the first.
    fn with_second_order<T>(&mut self, act: impl FnOnce(&mut Self, &mut SecondOrderSteps) -> T) -> Option<T> {
        let mut steps = self.second_order.take()?;
        let result = act(self, &mut steps);
        self.second_order = Some(steps);
        Some(result)
    }

    /// Makes Eq. 3 that of the present state.
    pub(super) fn linearise(&mut self) {
        let ContactStepper { q, v, eq3, .. } = &mut self.stepper;
        fill(&mut self.model, q, v, eq3);
        self.stepper.forget_reduction();
    }

    /// Makes Eq. 3 that of another state.
    pub(super) fn linearise_at(&mut self, q: &[f64], v: &[f64]) {
        fill(&mut self.model, q, v, &mut self.stepper.eq3);
        self.stepper.forget_reduction();
    }
}

impl<M: MechanicalModel> NonSmoothMechanics<M> {
    /// Finds what is stiff at a state, where steps take that implicitly.
    pub(super) fn find_stiff_forces(&mut self, q: &[f64], v: &[f64]) {
        if let Some(part) = &mut self.stepper.implicit {
            self.model.stiff_forces(q, v, &mut part.forces);
        }
    }

    /// Finds out whether a step of `h` (s) is to take it implicitly.
    pub(super) fn choose_implicit(&mut self, h: f64) {
        self.find_stiff_forces_here();
        self.stepper.choose_implicit(h);
    }

    /// Finds the stiff forces at the present state.
    fn find_stiff_forces_here(&mut self) {
        let ContactStepper { q, v, implicit, .. } = &mut self.stepper;
        if let Some(part) = implicit {
            self.model.stiff_forces(q, v, &mut part.forces);
        }
    }
}

/// Fills Eq. 3 at one state.
fn fill<M: MechanicalModel>(model: &mut M, q: &[f64], v: &[f64], eq3: &mut Linearisation) {
    model.prepare(q, v);
    if !model.size().constant_mass {
        model.mass_matrix(q, eq3.mass.entries_mut());
    }
    model.forces(q, v, &mut eq3.force);
    model.bilateral(q, v, &mut eq3.bilateral);
    model.unilateral(q, v, &mut eq3.unilateral);
    if !eq3.tangential.is_empty() {
        model.tangential(q, v, &mut eq3.tangential);
    }
    model.interface(q, v, &mut eq3.interface);
}

impl<M: MechanicalModel + Clone + 'static> Subsystem for NonSmoothMechanics<M> {
    subsystem_methods!(ports capabilities clone);

    fn outputs(&mut self, _u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.stepper.interface_motion(y);
        Ok(())
    }

    fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        if let Some(stepped) =
            self.with_second_order(|mechanics, steps| mechanics.step_second_order(steps, Excitation::Force(u), h))
        {
            return stepped;
        }
        self.stepper.advance(&self.model, u, h)?;
        let kinetic = (!self.model.size().constant_mass).then(|| self.stepper.kinetic_energy());
        self.model.check_contact_list(&self.stepper.q)?;
        self.linearise();
        if let Some(kinetic) = kinetic {
            self.stepper.energy.ledger.inertia += self.stepper.kinetic_energy() - kinetic;
        }
        Ok(())
    }

    fn counters(&self) -> SubsystemCounters {
        self.stepper.counters()
    }
}

impl<M: MechanicalModel> Capabilities for NonSmoothMechanics<M> {
    fn empty_interface_model(&mut self) -> Option<ReducedInterfaceModel> {
        Some(self.stepper.empty_model())
    }

    fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        self.find_stiff_forces_here();
        self.stepper.interface_model(h, model)?;
        Ok(true)
    }

    fn use_second_order(&mut self, rule: SecondOrder) -> Result<(), &'static str> {
        if self.stepper.law.spring.is_some() {
            return Err("contacts that give way are stepped by the semi-implicit rule");
        }
        if rule == SecondOrder::Midpoint && self.stepper.law.rebounds() {
            return Err(
                "contacts with restitution rebound at events, which the midpoint rule does not locate: use `event-split` or `semi-implicit`, \
                 or set restitution to 0",
            );
        }
        if self.stepper.has_friction() {
            return Err(
                "contacts with friction are stepped by the semi-implicit rule: where they start to slide is not located",
            );
        }
        if self.stepper.q.len() != self.stepper.v.len() {
            return Err("bodies in space, whose orientations are quaternions, are stepped by the semi-implicit rule");
        }
        self.keep_every_entry();
        if self.stepper.dense_solver().is_some() {
            return Err("contacts by the dozen, of which few are coupled, are stepped by the semi-implicit rule");
        }
        let size = self.model.size();
        let stiff = size.stiff_forces.map(|form| StiffForces::zeros(size.velocities, form));
        self.stepper.implicit = stiff.map(|forces| Box::new(ImplicitPart::new(&self.stepper.eq3, forces)));
        self.second_order = Some(Box::new(SecondOrderSteps::new(rule, &self.model)));
        Ok(())
    }

    fn contact_mechanics(&mut self) -> Option<&mut dyn ContactMechanics> {
        Some(self)
    }

    fn observables(&mut self) -> &[Name] {
        &self.observables
    }

    fn observe(&mut self, h: f64, row: &mut [f64]) {
        let (own, row) = row.split_at_mut(self.own_observables);
        let (gaps, row) = row.split_at_mut(self.contacts.len());
        let (forces, contact) = row.split_at_mut(self.contacts.len());
        let (contact, friction) = contact.split_at_mut(CONTACT_OBSERVABLES.len());
        self.model.observe(&self.stepper.q, &self.stepper.v, own);
        self.find_stiff_forces_here();
        self.stepper.observe(h, gaps, forces, contact);
        if !friction.is_empty() {
            self.stepper.observe_friction(friction);
        }
    }

    fn interface_work(&mut self) -> Option<f64> {
        Some(self.stepper.energy.ledger.interface)
    }

    fn energy_identity_residual(&mut self) -> Option<f64> {
        Some(self.stepper.energy.ledger.identity_residual)
    }

    fn energy_account(&mut self) -> Option<EnergyAccount> {
        let [kinetic, potential, springs] = self.start_energy;
        let potential_change = self.model.potential_energy(&self.stepper.q) - potential;
        let spring_change = self.stepper.spring_energy() - springs;
        Some(self.stepper.energy_account(self.stepper.kinetic_energy() - kinetic, potential_change, spring_change))
    }
}

impl<M: MechanicalModel> ContactMechanics for NonSmoothMechanics<M> {
    fn contact_names(&self) -> &[Name] {
        &self.contacts
    }

    fn coordinates(&self) -> &[f64] {
        self.position()
    }

    fn contact_impulses(&self) -> Option<&[f64]> {
        self.second_order.is_none().then(|| self.stepper.all_contact_impulses())
    }

    fn keep_every_entry(&mut self) {
        let law = self.stepper.law;
        let Some(solver) = self.stepper.dense_solver().cloned() else { return };
        if bytes_needed(&self.model, law, false) > MEMORY_LIMIT {
            return;
        }
        let eq3 = empty_equations(&self.model, &self.stepper.q, law, false);
        let start = (self.stepper.q.clone(), self.stepper.v.clone());
        self.stepper = ContactStepper::new(self.model.size(), eq3, start, law, solver);
        self.start();
    }

    fn is_of_second_order(&self) -> bool {
        self.second_order.is_some()
    }

    fn step_together_to_event(
        &mut self,
        actuator: &mut dyn JointActuator,
        time: f64,
        h: f64,
        sent: &mut Sent<'_>,
    ) -> Result<Option<f64>, Failure> {
        self.with_second_order(|mechanics, steps| mechanics.step_to_event(steps, actuator, (time, h), sent))
            .unwrap_or(Ok(None))
    }

    fn step_under(&mut self, profile: ForceProfile<'_>, h: f64) -> Result<(), Failure> {
        let pieces = Excitation::Prescribed { profile, done: 0.0 };
        self.with_second_order(|mechanics, steps| mechanics.step_second_order(steps, pieces, h)).unwrap_or(Ok(()))
    }
}
