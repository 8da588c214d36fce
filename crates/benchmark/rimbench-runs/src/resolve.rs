//! From a request to a run: names become things, what is left out becomes what is usual, and all is checked.

use super::options::{Parts, RunRequest};
use super::spec::{RunSettings, RunSpec};
use crate::catalogue::Catalogue;
use rimbench_cases::cases::{Case, MOST_MULTIPLES};
use rimbench_cases::parameter::Parameters;
use rimbench_core::cosim::{Channel, Delivery, Exchange, ForceReturn, LateRule, MechanicsSteps, StepRule, division};
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::Belief;
use rimbench_core::schemes::{ModelOptions, SchemeEntry};
use std::sync::Arc;
use std::time::Duration;

/// The solver of a run that does not ask for one.
const USUAL_SOLVER: &str = "active-set";

impl RunRequest {
    /// Finds everything by name, fills in what is usual, and checks all that can be checked without running.
    ///
    /// # Errors
    /// [`Error::UnknownName`], [`Error::InvalidValue`] or [`Error::Incompatible`], naming what is wrong and what would
    /// be valid.
    pub fn resolve(&self, catalogue: &Catalogue) -> Result<RunSpec> {
        let case = catalogue.case(named("case", &self.case)?)?;
        let mut parameters = case.default_parameters();
        for (key, value) in &self.set {
            parameters.set(key, value)?;
        }
        self.resolve_for(catalogue, case, &parameters)
    }

    /// Does the same for a case and parameters that are at hand, whatever the request says of them.
    ///
    /// # Errors
    /// As [`resolve`](Self::resolve).
    pub fn resolve_for(&self, catalogue: &Catalogue, case: &Arc<Case>, parameters: &Parameters) -> Result<RunSpec> {
        let scheme = catalogue.scheme(named("scheme", &self.scheme)?)?;
        let solver = catalogue.solver(self.solver.as_deref().unwrap_or(USUAL_SOLVER))?;
        self.refuse_in_vain(scheme)?;
        let (sequence, force_return) = scheme.sequence_and_return(self.sequence, self.force_return)?;
        let macro_step = self.macro_step_s.unwrap_or(case.defaults.macro_step_s);
        let mechanics_steps = match (self.mechanics_steps, self.mechanics_step_s) {
            (Some(steps), Some(step)) => {
                return Err(Error::Incompatible(format!(
                    "mechanics_steps = {steps} and mechanics_step_s = {step}: give one of the two"
                )));
            }
            // A macro step that is the case's own may be shorter: then it is one step.
            (None, Some(step)) if self.macro_step_s.is_none() && step.is_finite() && step > macro_step => {
                MechanicsSteps::AtMost(macro_step)
            }
            (None, Some(step)) => MechanicsSteps::AtMost(step),
            (steps, None) => steps.unwrap_or(case.usual_mechanics_steps()),
        };
        // The profile of one step is its mean.
        let force_return = match force_return {
            ForceReturn::Profile if mechanics_steps.is_one_in(macro_step) => ForceReturn::Mean,
            other => other,
        };
        if let (None, Some(value)) = (&scheme.gain, self.gain) {
            return Err(Error::Incompatible(format!(
                "gain = {value}: scheme `{}` has no gain; schemes that have one: {}",
                scheme.name,
                catalogue.tunable_schemes().join(", ")
            )));
        }
        // A macro step below the usual micro step is its own micro step, unless one is asked for.
        let micro_step = self.micro_step_s.unwrap_or_else(|| usual_micro_step(case, macro_step));
        let off = self.perturbation.and_then(|off| off.belief(parameters));
        if let (Some(off), Some(_)) = (self.perturbation, &off) {
            let why = match &self.belief {
                Some(belief) => format!("it is a belief, and so is {belief}: give one of the two"),
                None if !scheme.has_model() => format!("scheme `{}` has no reduced interface model", scheme.name),
                None => String::new(),
            };
            if !why.is_empty() {
                return Err(Error::Incompatible(format!("perturbation = {off}: {why}")));
            }
        }
        let mut parts = Parts {
            exchange: Exchange {
                mechanics_steps,
                delivery: self.delivery(scheme)?,
                mass_learning: self.mass_learning,
                belief: self.belief.clone().or(off).filter(|belief| *belief != Belief::default()),
                ..Exchange::new(micro_step, sequence, force_return)
            },
            model: ModelOptions {
                detection: scheme.detection(self.contact_detection)?,
                solver: solver.clone(),
                ..ModelOptions::default()
            },
        };
        self.fill(&mut parts);
        let star = self.star(scheme, case)?;
        let bond_schemes = self.bond_schemes.as_deref().map_or_else(
            || Ok(Vec::new()),
            |names| names.split(',').map(|name| catalogue.scheme(name.trim()).cloned()).collect::<Result<_>>(),
        )?;
        let control = self.step_control.unwrap_or_default();
        let duration = self.duration_s.unwrap_or(case.defaults.duration_s);
        let mut settings = RunSettings {
            case: case.clone(),
            parameters: parameters.clone().lasting(duration),
            model: scheme.has_model().then_some(parts.model),
            gain: scheme.gain_value(self.gain)?,
            scheme: scheme.clone(),
            solver: solver.clone(),
            exchange: parts.exchange,
            star,
            bond_schemes,
            mechanics_integrator: self.mechanics_integrator.unwrap_or_default(),
            perturbation: self.perturbation,
            macro_step,
            step_control: StepRule::new(control, self.step_tolerance, self.min_macro_step_s, macro_step)?,
            phase: self.phase.unwrap_or(1.0),
            duration,
            audit: false,
            predict_growth: false,
            divide_error: false,
            wall_limit: self.wall_limit_s.map(wall_limit).transpose()?,
        };
        if self.mechanics_step_s.is_none() {
            settings.mechanics_steps = settings.in_one_form();
        }
        let spec = RunSpec::of(settings)?;
        spec.check_mechanics_step()?;
        spec.check_model()?;
        spec.check_reference()?;
        Ok(spec)
    }

    /// Resolves how samples arrive; none where all are in time.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for a treatment of late samples where none is late, or that the scheme does not have.
    fn delivery(&self, scheme: &SchemeEntry) -> Result<Option<Delivery>> {
        let late_one = |channel: Option<&Channel>| channel.filter(|channel| !channel.is_in_time()).cloned();
        let (late, bridge) = (self.late_samples, self.late_forces);
        let (up, down) = (late_one(self.delivery_up.as_ref()), late_one(self.delivery_down.as_ref()));
        for (asked, given, needs) in [
            (late.map(|late| format!("late_samples = {late}")), up.is_some() || down.is_some(), "delivery_up"),
            (bridge.map(|bridge| format!("late_forces = {bridge}")), down.is_some(), "delivery_down"),
        ] {
            if let Some(asked) = asked.filter(|_| !given) {
                return Err(Error::Incompatible(format!(
                    "{asked}: no sample is late: give {needs}, such as `delay:1`"
                )));
            }
        }
        if up.is_none() && down.is_none() {
            return Ok(None);
        }
        let possible = !scheme.has_model() || scheme.moves_model;
        if let Some(late) = late.filter(|late| !possible && late.catches_up()) {
            return Err(Error::Incompatible(format!(
                "late_samples = {late}: scheme `{}` does not move its model by itself: use `raw`",
                scheme.name
            )));
        }
        let usual = if possible { LateRule::CatchUp } else { LateRule::Raw };
        Ok(Some(Delivery {
            up: up.unwrap_or_default(),
            down: down.unwrap_or_default(),
            late: late.unwrap_or(usual),
            bridge: bridge.unwrap_or_default(),
        }))
    }
}

/// The micro step (s) of a run that asks for none: the case's, or the longest below it that divides the macro step into
/// steps that the actuator takes, if it takes multiples only.
fn usual_micro_step(case: &Case, macro_step: f64) -> f64 {
    let (usual, possible) = (case.defaults.micro_step_s.min(macro_step), case.steps.actuator);
    let Some(unit) = possible.multiple_of.filter(|_| possible.allows(macro_step)) else { return usual };
    let least = division(macro_step, usual);
    let most = (macro_step / unit).round().min(least as f64 + f64::from(MOST_MULTIPLES)) as usize;
    let fits = (least..=most).find(|&count| possible.allows(macro_step / count as f64));
    fits.filter(|count| *count > least).map_or(usual, |count| macro_step / count as f64)
}

/// A name that must be given.
fn named<'a>(kind: &'static str, name: &'a Option<String>) -> Result<&'a str> {
    name.as_deref().ok_or_else(|| Error::invalid(kind, "nothing", format!("the name of a {kind}")))
}

/// A wall-time limit from seconds.
fn wall_limit(seconds: f64) -> Result<Duration> {
    let limit = Duration::try_from_secs_f64(seconds).ok().filter(|limit| !limit.is_zero());
    limit.ok_or_else(|| Error::invalid("wall_limit_s", seconds, "a time from 1e-9 s to 1e18 s"))
}
