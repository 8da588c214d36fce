//! What is checked of a run before it begins: which options go together, and which steps there can be.

use super::spec::RunSettings;
use rimbench_cases::cases::{CaseDefaults, CoupledSystem, MOST_MULTIPLES, MOST_SMALL_STEPS, MOST_STEPS};
use rimbench_core::cosim::{
    ActuatorIntegrator, CommunicationGrid, Delivery, ForceBridge, ForceReturn, LateRule, MassLearning,
    MechanicsIntegrator, MechanicsSteps, Sequence, Share, Side, StarPlan, StepRule, cannot_divide, division,
};
use rimbench_core::error::{Error, Result};
use rimbench_core::schemes::{ContactsAct, ModelMotion, ModelOptions, Requirement};
use std::fmt;

/// Relative slack within which a duration is a multiple of a step.
const COMMENSURATE: f64 = 1e-9;

impl RunSettings {
    /// Checks that the mechanics can take the longest step that is asked of it.
    ///
    /// # Errors
    /// [`Error::InvalidValue`], with what would be valid.
    pub(super) fn check_mechanics_step(&self) -> Result<()> {
        let (MechanicsSteps::AtMost(longest), possible) = (self.mechanics_steps, self.case.steps.mechanics) else {
            return Ok(());
        };
        let own = |longest: f64| self.macro_step / division(self.macro_step, longest) as f64;
        let Some(unit) = possible.multiple_of.filter(|_| !possible.allows(own(longest))) else { return Ok(()) };
        let valid = (1..=MOST_MULTIPLES).map(|count| f64::from(count) * unit);
        let valid = valid.take_while(|step| *step <= self.macro_step).filter(|step| possible.allows(own(*step)));
        let nearest = valid.min_by(|a, b| (a - longest).abs().total_cmp(&(b - longest).abs()));
        let expected = match nearest {
            Some(step) => format!(
                "{step} s: the mechanics takes multiples of {unit:e} s only, and the macro step is {} s",
                self.macro_step
            ),
            None => format!("a macro step that is a multiple of {unit:e} s: the mechanics takes no others"),
        };
        Err(Error::invalid("mechanics_step_s", longest, expected))
    }

    /// Checks what can be checked without running. Both sides are built only for options that not all mechanics allow.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] or [`Error::Incompatible`], naming what is wrong and what would be valid.
    pub(super) fn check_model(&self) -> Result<()> {
        let depends = self.star.is_some()
            || self.belief.is_some()
            || self.model.as_ref().is_some_and(ModelOptions::depends_on_mechanics);
        // A machine that cannot be built says so when it is built.
        let built = depends.then(|| self.build()).and_then(Result::ok);
        built.map_or(Ok(()), |system| self.check_sides(system))
    }

    /// Builds both sides, unless they are from outside, and checks all that depends on them.
    ///
    /// # Errors
    /// Those of building the case, and those of options that it does not allow. What it does not offer is no error:
    /// such a run is skipped with the reason.
    pub fn check_built(&self) -> Result<()> {
        if self.case.from_outside { Ok(()) } else { self.check_sides(self.build()?) }
    }

    fn check_sides(&self, mut system: CoupledSystem) -> Result<()> {
        if self.scheme.incompatibility(system.sides.lend()).is_some() {
            return Ok(());
        }
        if let Some(plan) = self.star.as_ref().filter(|plan| cannot_divide(plan, system.sides.lend()).is_none()) {
            let rows = system.sides.actuator.ports().outputs.len();
            plan.check(rows, (self.force_return, self.phase))?;
            if !self.bond_schemes.is_empty() && self.bond_schemes.len() != plan.bonds(rows)? {
                let expected = format!("one name for each of the {} bonds", plan.bonds(rows)?);
                return Err(Error::invalid("bond_schemes", self.names_of_bond_schemes().unwrap_or_default(), expected));
            }
        }
        if let (Some(belief), Some(model)) =
            (&self.belief, system.sides.mechanics.capabilities().empty_interface_model())
            && let Err(wrong @ Error::InvalidValue { .. }) = belief.check_model(&model)
        {
            return Err(wrong);
        }
        self.scheme.couple(system.sides.lend(), self.model.as_ref(), self.gain).map(drop)
    }

    /// Checks everything that can be checked without either side, and returns the communication points.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] or [`Error::Incompatible`], naming what is wrong and what would be valid.
    pub(super) fn checked(&self) -> Result<CommunicationGrid> {
        self.parameters.check_used()?;
        let grid = self.grid()?;
        let macro_steps = grid.macro_steps();
        if macro_steps < self.scheme.samples {
            return Err(Error::invalid(
                "macro_step_s",
                self.macro_step,
                format!(
                    "at most {} s, so that scheme {} gets the {} samples it goes through within {} s",
                    self.duration / self.scheme.samples as f64,
                    self.scheme.name,
                    self.scheme.samples,
                    self.duration
                ),
            ));
        }
        self.scheme.gain_value(self.gain)?;
        if let Some(rule) = &self.step_control {
            rule.check(self.macro_step)?;
            if self.duration / rule.shortest > MOST_STEPS {
                let expected = format!("at least {:e} s for this duration", self.duration / MOST_STEPS);
                return Err(Error::invalid("min_macro_step_s", rule.shortest, expected));
            }
        }
        if let Some(rule) = self.step_control.filter(|rule| rule.control.by_defect() && !self.scheme.has_model()) {
            return Err(Error::Incompatible(format!(
                "step_control = {}: scheme `{}` has no reduced interface model",
                rule.control, self.scheme.name
            )));
        }
        if let Some(delivery) = &self.delivery {
            self.check_delivery(delivery, macro_steps)?;
        }
        self.scheme.check_sequence(self.sequence)?;
        self.scheme.check_force_return(self.force_return)?;
        self.force_return.check(self.sequence)?;
        if self.force_return == ForceReturn::Pieces && self.mechanics_integrator != MechanicsIntegrator::EventSplit {
            return Err(Error::Incompatible(format!(
                "force return `pieces` gives every piece of a split step its own force, and mechanics_integrator = {} splits none: use \
                 `event-split`, or force return `mean` or `profile`",
                self.mechanics_integrator
            )));
        }
        if let Some(plan) = &self.star {
            self.check_star(plan)?;
        }
        if let Some(model) = &self.model {
            self.scheme.check_options(model)?;
            self.scheme.detection(model.detection)?;
            self.check_own_step(model)?;
            if let Some(learning) = &self.mass_learning {
                self.check_learning(learning, model)?;
            }
        }
        Ok(grid)
    }

    /// Checks that several bonds go together with the rest of the run.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] or [`Error::Incompatible`], naming what is wrong and what would be valid.
    fn check_star(&self, plan: &StarPlan) -> Result<()> {
        let schemes = || self.bond_schemes.iter().chain([&self.scheme]);
        let lacks = |needs: Requirement| schemes().find(|scheme| scheme.needs.contains(&needs));
        let why = if let Some(StepRule { control, .. }) = self.step_control {
            format!("step_control = {control}: the steps of bonds are counted in macro steps of one length: use `none`")
        } else if let Some(learning) = &self.mass_learning {
            format!("mass_learning = {learning}: a jump tells of the forces of all bonds, and each knows its own")
        } else if self.force_return == ForceReturn::Pieces {
            "force return `pieces` is that of one bond: use `mean` or `profile`".to_owned()
        } else if self.actuator_integrator != ActuatorIntegrator::Euler {
            format!(
                "actuator_integrator = {}: what is known of other bonds is known at the start of a micro step: use `euler`",
                self.actuator_integrator
            )
        } else if matches!(self.sequence, Sequence::GaussSeidel { first: Side::Mechanics }) {
            format!("sequence = {}: say so with order, as `hub;1,2`", self.sequence)
        } else if let Some(scheme) = schemes().find(|scheme| !scheme.real_time()) {
            format!("scheme `{}` takes steps again with two sides, or has no bonds at all: use another", scheme.name)
        } else if let Some(scheme) = lacks(Requirement::Trials) {
            format!("scheme `{}` tries steps of the mechanics with the forces of one bond: use another", scheme.name)
        } else if let Some(scheme) = lacks(Requirement::TransmissionLines) {
            format!("scheme `{}` exchanges waves with a whole actuator side: use another", scheme.name)
        } else if let Some(scheme) = lacks(Requirement::HeldReturn).filter(|_| self.force_return != ForceReturn::Held) {
            format!("scheme `{}` needs force return `held`", scheme.name)
        } else if let Some(scheme) = lacks(Requirement::NotMechanicsFirst).filter(|_| plan.follows_hub()) {
            format!(
                "order = {}: scheme `{}` lets a bond move with a model of the hub, so it goes first",
                plan.order, scheme.name
            )
        } else if plan.share != Share::Whole && schemes().any(|scheme| !scheme.moves_model) {
            format!(
                "share = {}: a scheme without a model that moves has no share of the mechanics: use `whole`",
                plan.share
            )
        } else if self.delivery.is_some() && plan.share != Share::Whole {
            "late samples: what a model of a share takes for its own force is a mean of the present: use share `whole`"
                .to_owned()
        } else if let Some([shortest, longest]) = plan.micro_steps.range()
            && (longest > self.macro_step || self.duration / shortest > MOST_SMALL_STEPS)
        {
            let [least, most] = [self.duration / MOST_SMALL_STEPS, self.macro_step];
            return Err(Error::invalid(
                "bond_micro_steps",
                &plan.micro_steps,
                format!("times from {least:e} s to {most} s"),
            ));
        } else {
            return Ok(());
        };
        Err(Error::Incompatible(format!("several bonds: {why}")))
    }

    /// Checks that a jump at a sample says by how much the mass is wrong.
    ///
    /// # Errors
    /// [`Error::Incompatible`], naming what is wrong and what would be valid.
    fn check_learning(&self, learning: &MassLearning, model: &ModelOptions) -> Result<()> {
        let (averaged, late) = (matches!(self.force_return, ForceReturn::Mean | ForceReturn::Profile), &self.delivery);
        let why = if !self.scheme.moves_model {
            format!(
                "scheme `{}` moves no model of the whole mechanics by itself: use another rim-* scheme",
                self.scheme.name
            )
        } else if model.model_motion != ModelMotion::Frozen {
            format!(
                "model_motion = {}: what a frozen model forecasts is learned from: use `frozen`",
                model.model_motion
            )
        } else if !averaged {
            format!(
                "force return `{}` is not the impulse that the model received: use `mean` or `profile`",
                self.force_return
            )
        } else if late.as_ref().is_some_and(|delivery| !delivery.down.is_in_time()) {
            "forces are late, and what the mechanics received is not known: use delivery_up only".to_owned()
        } else if late.as_ref().is_some_and(|delivery| delivery.late == LateRule::Raw) {
            "late_samples = raw: an old sample is taken for the present, and its age for a wrong mass: use `catch-up`"
                .to_owned()
        } else {
            return Ok(());
        };
        Err(Error::Incompatible(format!("mass_learning = {learning}: {why}")))
    }

    /// Checks that both sides step as contacts that act over the mechanics' own step assume.
    ///
    /// # Errors
    /// [`Error::Incompatible`], naming what is wrong and what would be valid.
    fn check_own_step(&self, model: &ModelOptions) -> Result<()> {
        let refused = |option: &dyn fmt::Display, reason: &str| {
            Err(Error::Incompatible(format!("contacts_act = {}: {option}: {reason}", model.contacts_act)))
        };
        if model.contacts_act == ContactsAct::MicroStep {
            return Ok(());
        }
        if self.mechanics_integrator != MechanicsIntegrator::SemiImplicit {
            let option = format!("mechanics_integrator = {}", self.mechanics_integrator);
            let reason = "its contacts act within its own step, as those of micro steps do: use `semi-implicit`, or contacts_act `micro-step`";
            return refused(&option, reason);
        }
        if self.actuator_integrator != ActuatorIntegrator::Euler {
            let option = format!("actuator_integrator = {}", self.actuator_integrator);
            let reason = "micro steps of the second order solve for force and contacts at once: use `euler`, or contacts_act `micro-step`";
            return refused(&option, reason);
        }
        Ok(())
    }

    /// Checks that late samples go together with the rest of the run.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] or [`Error::Incompatible`], naming what is wrong and what would be valid.
    fn check_delivery(&self, delivery: &Delivery, macro_steps: usize) -> Result<()> {
        delivery.up.check("delivery_up", macro_steps)?;
        delivery.down.check("delivery_down", macro_steps)?;
        let (scheme, model) = (&self.scheme, self.model.as_ref());
        let catches_up = model.filter(|_| delivery.late.catches_up() && !delivery.up.is_in_time());
        let averaged = matches!(self.force_return, ForceReturn::Mean | ForceReturn::Profile);
        let late_forces = !delivery.down.is_in_time();
        let why = if !scheme.real_time() {
            format!(
                "scheme `{}` takes steps again, which has no late samples: use one that does not iterate",
                scheme.name
            )
        } else if scheme.needs.contains(&Requirement::Trials) {
            format!(
                "scheme `{}` asks the mechanics as it stands, which late samples are not: use another scheme",
                scheme.name
            )
        } else if scheme.needs.contains(&Requirement::TransmissionLines) {
            format!("scheme `{}` exchanges waves, whose delay is that of its lines: use another scheme", scheme.name)
        } else if let Some(StepRule { control, .. }) = self.step_control {
            format!("step_control = {control}: samples are late by macro steps of one length: use `none`")
        } else if scheme.has_model() && !averaged {
            format!("force return `{}`: a late model needs `mean` or `profile`", self.force_return)
        } else if late_forces && self.force_return == ForceReturn::Pieces {
            "force return `pieces` is of the present: use `mean` or `profile`".to_owned()
        } else if self.force_return == ForceReturn::Held && delivery.bridge != ForceBridge::Hold {
            format!(
                "late_forces = {}: with force return `held` the scheme goes on from late forces itself",
                delivery.bridge
            )
        } else if self.audit && late_forces {
            "the audit accounts for late samples of the mechanics only: use delivery_up".to_owned()
        } else if catches_up.is_some() && self.actuator_integrator != ActuatorIntegrator::Euler {
            format!(
                "late_samples = {}: a model is run forward in micro steps of the first order: use actuator_integrator `euler`, or \
                 late_samples `raw`",
                delivery.late
            )
        } else {
            return Ok(());
        };
        Err(Error::Incompatible(format!("delivery: {why}")))
    }

    /// Checks the steps of the reference: one that would never end is found before it is begun.
    ///
    /// # Errors
    /// Those of [`CaseDefaults::check_reference`].
    pub fn check_reference(&self) -> Result<()> {
        self.times().check_reference()?;
        let (end, least) = (self.reference_end(), self.case.defaults.reference_sampling_s);
        if self.macro_step > end * (1.0 + COMMENSURATE) {
            let expected =
                format!("at least {least} s, the distance of the points of the reference, and one macro step of those");
            return Err(Error::invalid("duration_s", self.duration, expected));
        }
        Ok(())
    }

    /// The time at which the reference ends, s: the duration, but of sides that take multiples of a step the last
    /// stored point of it, if the duration is no whole number of steps that they take.
    pub(super) fn reference_end(&self) -> f64 {
        let sampling = self.case.defaults.reference_sampling_s;
        let points = (self.duration / sampling).ceil().max(1.0);
        match self.case.allows_step(self.duration / points / (4 * self.steps_between_points()) as f64) {
            true => self.duration,
            false => (self.duration / sampling * (1.0 + COMMENSURATE)).floor() * sampling,
        }
    }

    /// Steps of the coarsest of the three solutions of the reference between two stored points.
    pub(super) fn steps_between_points(&self) -> usize {
        let asked = self.case.defaults.reference_sampling_s / self.case.defaults.reference_step_s;
        // Slack for a quotient that is whole up to round-off.
        (asked * (1.0 - COMMENSURATE)).ceil().max(1.0) as usize
    }

    /// The time at which a run ends that completes, s: the duration, but of sides that take steps of one length the end
    /// of the last whole macro step that the reference covers.
    pub fn end(&self) -> f64 {
        if !self.case.has_fixed_steps() || self.step_control.is_some() || self.phase != 1.0 {
            return self.duration;
        }
        let end = self.reference_end();
        let count = end / self.macro_step;
        match (count - count.round()).abs() < COMMENSURATE * count {
            true => end,
            false => count.floor().max(1.0) * self.macro_step,
        }
    }

    /// The times of the case with those of the run.
    fn times(&self) -> CaseDefaults {
        let (duration_s, macro_step_s, micro_step_s) = (self.duration, self.macro_step, self.micro_step);
        CaseDefaults { duration_s, macro_step_s, micro_step_s, ..self.case.defaults }
    }

    /// Returns the communication points.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for steps that are not positive, a micro step above the macro step, and steps of either
    /// side that are too many.
    pub(super) fn grid(&self) -> Result<CommunicationGrid> {
        self.times().grid(self.phase)?;
        let grid = CaseDefaults { duration_s: self.end(), ..self.times() }.grid(self.phase)?;
        if self.micro_step > self.macro_step {
            let expected = format!("at most the macro step, {} s", self.macro_step);
            return Err(Error::invalid("micro_step_s", self.micro_step, expected));
        }
        self.mechanics_steps.check(self.macro_step)?;
        let of_macro_step = self.mechanics_steps.within(self.macro_step, self.micro_step) as f64;
        if self.duration / self.macro_step * of_macro_step > MOST_SMALL_STEPS {
            let expected = format!("at most {MOST_SMALL_STEPS:e} steps of the mechanics within {} s", self.duration);
            let key = if self.mechanics_steps.longest().is_some() { "mechanics_step_s" } else { "mechanics_steps" };
            let found =
                self.mechanics_steps.longest().map_or(self.mechanics_steps.to_string(), |step| step.to_string());
            return Err(Error::invalid(key, found, expected));
        }
        Ok(grid)
    }
}
