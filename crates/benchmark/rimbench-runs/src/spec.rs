//! What a request resolves to: everything that determines a run.

use super::perturbation::Perturbation;
use rimbench_cases::cases::{Case, CoupledSystem, coordinate_column};
use rimbench_cases::parameter::Parameters;
use rimbench_core::cosim::{
    ActuatorIntegrator, Bounds, CommunicationGrid, Exchange, ForceReturn, MechanicsIntegrator, MechanicsSteps,
    SecondOrder, Setup, Sides, StarPlan, StepRule, division,
};
use rimbench_core::error::Result;
use rimbench_core::schemes::{FrictionRows, ModelMotion, ModelOptions, Requirement, SchemeEntry};
use rimbench_core::solver_entry::SolverEntry;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;
use std::time::Duration;

/// A run: its settings, checked once, on its communication points.
///
/// [`with`](Self::with) makes another of it, which is checked as well.
#[derive(Debug, Clone)]
pub struct RunSpec {
    settings: RunSettings,
    grid: CommunicationGrid,
}

impl Deref for RunSpec {
    type Target = RunSettings;

    fn deref(&self) -> &RunSettings {
        &self.settings
    }
}

impl Deref for RunSettings {
    type Target = Exchange;

    fn deref(&self) -> &Exchange {
        &self.exchange
    }
}

impl DerefMut for RunSettings {
    fn deref_mut(&mut self) -> &mut Exchange {
        &mut self.exchange
    }
}

/// Everything that determines a run.
#[derive(Debug, Clone)]
pub struct RunSettings {
    /// The case.
    pub case: Arc<Case>,
    /// Its parameters, resolved.
    pub parameters: Parameters,
    /// The coupling scheme.
    pub scheme: Arc<SchemeEntry>,
    /// Options of its reduced interface model, if it has one.
    pub model: Option<ModelOptions>,
    /// Its gain, if it has one.
    pub gain: Option<f64>,
    /// Solver of the complementarity problems (of the mechanics; the scheme's own is in `model`).
    pub solver: Arc<SolverEntry>,
    /// How both sides step and exchange.
    pub exchange: Exchange,
    /// How several bonds share the mechanics; none of one bond.
    pub star: Option<StarPlan>,
    /// The scheme of each bond, where they are not all that of the run.
    pub bond_schemes: Vec<Arc<SchemeEntry>>,
    /// How the mechanics steps.
    pub mechanics_integrator: MechanicsIntegrator,
    /// By what the machine or its interface model is off, if it is.
    pub perturbation: Option<Perturbation>,
    /// Macro step H, s.
    pub macro_step: f64,
    /// How the macro step is controlled; H is then the first and the longest.
    pub step_control: Option<StepRule>,
    /// Communication phase φ ∈ (0, 1].
    pub phase: f64,
    /// Simulated time, s.
    pub duration: f64,
    /// Whether there is an account of what its interface model creates (see [`audited`](RunSpec::audited)).
    pub audit: bool,
    /// Whether the growth of its linearised coupling is [predicted](super::predicted_growth). No part of what the run
    /// is.
    pub predict_growth: bool,
    /// Whether its error is divided into that of the coupling and that of the mechanics' own step. No part of what the
    /// run is.
    pub divide_error: bool,
    /// Wall time after which the run ends with outcome `timeout`. No part of what the run is.
    pub wall_limit: Option<Duration>,
}

impl RunSpec {
    /// Checks everything that can be checked without either side.
    pub(super) fn of(settings: RunSettings) -> Result<Self> {
        Ok(RunSpec { grid: settings.checked()?, settings })
    }

    /// Makes the same run with some of its settings changed.
    ///
    /// # Errors
    /// [`Error::InvalidValue`](rimbench_core::error::Error::InvalidValue) or
    /// [`Error::Incompatible`](rimbench_core::error::Error::Incompatible), naming what is wrong and what would be
    /// valid.
    pub fn with(&self, change: impl FnOnce(&mut RunSettings)) -> Result<Self> {
        let mut settings = self.settings.clone();
        change(&mut settings);
        Self::of(settings)
    }

    /// The communication points.
    pub fn communication_points(&self) -> &CommunicationGrid {
        &self.grid
    }

    /// The same run with its mechanics' steps said otherwise.
    pub(super) fn counting(&self, mechanics_steps: MechanicsSteps) -> Self {
        let mut settings = self.settings.clone();
        settings.mechanics_steps = mechanics_steps;
        RunSpec { settings, grid: self.grid }
    }

    /// The same run, which records the coordinates as well that the drawing of its case reads. They have no part in
    /// what it is.
    pub fn with_drawn_coordinates(&self) -> Self {
        let drawing = (self.case.drawing)(&self.parameters);
        let Some(more) = drawing.map(|drawing| drawing.coordinates()).filter(|more| !more.is_empty()) else {
            return self.clone();
        };
        let mut case = (*self.case).clone();
        case.drawing_columns.extend(more.into_iter().map(|index| coordinate_column(index).into()));
        self.of_case(Arc::new(case))
    }

    /// The same run of another case, which says nothing of communication points.
    pub(super) fn of_case(&self, case: Arc<Case>) -> Self {
        RunSpec { settings: RunSettings { case, ..self.settings.clone() }, grid: self.grid }
    }
}

impl RunSettings {
    /// Builds both sides, with parameters that are off where the run asks for that.
    ///
    /// # Errors
    /// Those of building the case.
    pub fn build(&self) -> Result<CoupledSystem> {
        let off = self.perturbation.filter(Perturbation::is_of_machine);
        let off = off.map(|off| off.machine(&self.parameters)).transpose()?;
        (self.case.build)(off.as_ref().unwrap_or(&self.parameters), &self.solver)
    }

    /// The mechanics' steps, a longest step as the count that it is in every macro step, a count that is the actuator's
    /// in every macro step as `all` of them: one run has one id. One step is left as it is, because it is exact at that
    /// macro step only.
    pub(super) fn in_one_form(&self) -> MechanicsSteps {
        let even = || self.step_control.is_none() && self.grid().is_ok_and(|grid| grid.is_even());
        match self.mechanics_steps {
            steps if steps.is_one_in(self.macro_step) => MechanicsSteps::ONE,
            MechanicsSteps::AtMost(step) if step == self.micro_step => MechanicsSteps::AsActuator,
            steps @ (MechanicsSteps::Count(_) | MechanicsSteps::AtMost(_)) if even() => {
                match steps.within(self.macro_step, self.micro_step) {
                    count if count == division(self.macro_step, self.micro_step) => MechanicsSteps::AsActuator,
                    count => u32::try_from(count).ok().and_then(MechanicsSteps::count).unwrap_or(steps),
                }
            }
            steps => steps,
        }
    }

    /// Whether the model is exact: the co-simulation then takes the same steps as the monolithic stepper, for every H,
    /// and its error says nothing about coupling.
    ///
    /// Mass, forces and Jacobians that do not change, all contacts in the frozen model under the mechanics' law, the
    /// actuator first with its profile returned, and as many steps of the mechanics as micro steps: model and mechanics
    /// run the same recursion with the same complementarity data.
    pub fn model_is_exact(&self) -> bool {
        self.case.constant_mechanics
            && self.scheme.has_mechanics_law
            && self.model.as_ref().is_some_and(|model| model.model_motion == ModelMotion::Frozen)
            && !self.has_slip_rows()
            && self.force_return == ForceReturn::Profile
            && self.in_one_form() == MechanicsSteps::AsActuator
    }

    /// The plan of several bonds that is asked for as such.
    pub(super) fn own_plan(&self) -> Option<&StarPlan> {
        self.star.as_ref().filter(|_| self.scheme.bonds.is_none())
    }

    /// What is asked for of several bonds, if it is not the usual.
    pub(super) fn unusual<T: PartialEq + Default>(&self, of: impl Fn(&StarPlan) -> &T) -> Option<&T> {
        self.own_plan().map(of).filter(|value| **value != T::default())
    }

    /// The names of the schemes of bonds, where they are not all that of the run.
    pub(super) fn names_of_bond_schemes(&self) -> Option<String> {
        let names: Vec<&str> = self.bond_schemes.iter().map(|scheme| &*scheme.name).collect();
        (!names.is_empty()).then(|| names.join(","))
    }

    /// Tells whether contacts in space have one tangential row in the model.
    pub(super) fn has_slip_rows(&self) -> bool {
        self.model.as_ref().is_some_and(|model| model.friction_rows == FrictionRows::SlipDirection)
    }

    /// Tells whether it does with the mechanics' interface model what needs every entry of its matrices.
    pub(super) fn needs_every_entry(&self) -> bool {
        if self.model.is_none() {
            return false;
        }
        self.audit
            || self.belief.is_some()
            || self.mass_learning.is_some()
            || self.actuator_integrator == ActuatorIntegrator::Midpoint
    }

    /// Lets both sides step as the run asks, by its integrators; says why they cannot, if they cannot.
    pub(super) fn use_integrators(&self, mut sides: Sides<'_>) -> Option<String> {
        let midpoint = self.actuator_integrator == ActuatorIntegrator::Midpoint;
        if midpoint && self.scheme.needs.contains(&Requirement::TransmissionLines) {
            return Some(format!(
                "actuator_integrator = {}: the lines of scheme {} step as their travel time says",
                self.actuator_integrator, self.scheme.name
            ));
        }
        let refused = use_integrators((self.mechanics_integrator, self.actuator_integrator), sides.lend());
        let follows = self.model.is_some() && midpoint;
        refused.or_else(|| {
            let model = sides.mechanics.capabilities().empty_interface_model().filter(|_| follows)?;
            model.contact_rows().map(|_| {
                let why =
                    "a model with contacts by the dozen, of which few are coupled, has micro steps of the first order only";
                format!("actuator_integrator = {}: {why}", self.actuator_integrator)
            })
        })
    }

    /// Power of H with which the defect of the scheme's model falls in a macro step of a smooth motion.
    ///
    /// A model of order p is off by `O(τ^p)` in its velocity after a time τ, and by `O(H^(p+1))` in its position at the
    /// end, if the mechanics itself is no worse: one step of the first order misses its position by `O(H²)`. As many
    /// steps as the actuator takes are those of the model too, and what they miss is missed by both.
    fn defect_order(&self) -> u32 {
        let coarse =
            self.mechanics_integrator.second_order().is_none() && self.in_one_form() != MechanicsSteps::AsActuator;
        if coarse { 2 } else { self.scheme.order + 1 }
    }
}

impl RunSpec {
    /// Says what the macro loop of the run needs to know; `bounds` say beyond what it counts as diverged.
    pub fn setup(&self, bounds: Bounds) -> Setup {
        Setup {
            grid: self.grid,
            step_rule: self.step_control.map(|rule| StepRule {
                order: if rule.control.by_defect() { self.defect_order() } else { rule.order },
                ..rule
            }),
            exchange: self.exchange.clone(),
            bounds,
        }
    }
}

/// Lets both sides step by these rules; says why they cannot, if they cannot.
pub(super) fn use_integrators(
    (mechanics, actuator): (MechanicsIntegrator, ActuatorIntegrator),
    sides: Sides<'_>,
) -> Option<String> {
    if let Some(rule) = mechanics.second_order()
        && let Err(reason) = sides.mechanics.capabilities().use_second_order(rule)
    {
        return Some(format!("mechanics_integrator = {mechanics}: {reason}"));
    }
    if actuator == ActuatorIntegrator::Midpoint
        && let Err(reason) = sides.actuator.capabilities().use_second_order(SecondOrder::Midpoint)
    {
        return Some(format!("actuator_integrator = {actuator}: {reason}"));
    }
    None
}
