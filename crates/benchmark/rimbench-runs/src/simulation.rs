//! One run, from everything that determines it to what comes of it.

use super::evaluation::{BLOCK, EvaluatedRun, Judge};
use super::reference::Reference;
use super::run_result::RunResult;
use super::spec::RunSpec;
use rimbench_cases::cases::{AUDIT_COLUMNS, CoupledSystem, LAMBDA_COLUMN, Recorder};
use rimbench_core::cosim::{
    Bounds, CommunicationPoint, ForceBridge, ForceReturn, Known, Outcome, Report, RunControl, Setup, Sides, Star,
    StarPlan, StepControl, StepRule, StopFlag, Timer, Trajectory, cannot_divide, check_coupling, counts_interface_work,
    division,
};
use rimbench_core::error::{Error, Result};
use rimbench_core::schemes::{Coupling, Requirement};
use std::fmt;
use std::time::Duration;

/// Time since some instant; never goes back. Whoever runs something brings their own, because a clock is nothing that
/// every machine has.
pub type Clock = fn() -> Duration;

/// A run with both sides built.
pub struct PreparedRun<'a> {
    spec: &'a RunSpec,
    system: CoupledSystem,
    /// Forces of the centre by which its error is divided, or why there are none; none where that is not known yet.
    centre: Option<Result<Vec<Vec<f64>>, String>>,
}

impl RunSpec {
    /// Builds both sides: what cannot run is found before anything is computed.
    ///
    /// # Errors
    /// Those of building the case.
    pub fn prepare(&self) -> Result<PreparedRun<'_>> {
        let system = self.build()?;
        Ok(PreparedRun { spec: self, system, centre: None })
    }

    /// Asks for an account of the energy that the scheme's interface model creates: metrics, and two more columns of
    /// the trajectory.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for a scheme or a force return of which there is no such account.
    pub fn audited(self) -> Result<Self> {
        match self.not_auditable() {
            None => self.with(|own| own.audit = true),
            Some(why) => Err(Error::Incompatible(format!("audit: {why}"))),
        }
    }

    /// Says why there can be no account of what the interface model creates, if there can be none.
    pub fn not_auditable(&self) -> Option<String> {
        let (scheme, force_return) = (&self.scheme, self.force_return);
        let late_forces = self.delivery.as_ref().is_some_and(|delivery| !delivery.down.is_in_time());
        match force_return {
            _ if !scheme.has_model() => Some(format!("scheme `{}` has no reduced interface model", scheme.name)),
            _ if self.star.is_some() => Some("each of several bonds has a model of its own".to_owned()),
            _ if self.mass_learning.is_some() => Some("the model changes as the actuator learns its mass".to_owned()),
            _ if late_forces => {
                Some("forces are late, and it accounts for late samples of the mechanics only".to_owned())
            }
            ForceReturn::Mean | ForceReturn::Profile => None,
            _ => Some(format!(
                "force return `{force_return}` is not the impulse that the model received; use `mean` or `profile`"
            )),
        }
    }
}

impl PreparedRun<'_> {
    /// Returns both sides.
    pub(super) fn system(&self) -> &CoupledSystem {
        &self.system
    }

    /// Names the contacts of the interface model, as in "right wedge"; none where they have no names.
    pub fn contact_names(&mut self) -> Vec<String> {
        let contacts = self.system.sides.mechanics.capabilities().contact_mechanics();
        let names = contacts.map_or(&[][..], |mechanics| mechanics.contact_names());
        names.iter().map(|name| name.replace('_', " ")).collect()
    }

    /// Runs what the error of this run is divided by, if that is asked for; [`evaluate`](Self::evaluate) does it first
    /// where it is not done.
    pub fn divide(&mut self, reference: &Reference, clock: Option<Clock>, stop: StopFlag<'_>) {
        if self.spec.divide_error && self.centre.is_none() {
            self.centre = Some(self.spec.forces_of_centre(reference, clock, stop));
        }
    }

    /// Runs and [evaluates](super::evaluate) block by block, so that memory does not grow with the number of rows; all
    /// rows are kept if a trace `is_wanted`, else the last ones.
    ///
    /// # Errors
    /// As for [`simulate`], and those of evaluating.
    pub fn evaluate(
        mut self,
        reference: &Reference,
        inside: bool,
        is_wanted: bool,
        clock: Option<Clock>,
        stop: StopFlag<'_>,
    ) -> Result<EvaluatedRun> {
        let (spec, bounds) = (self.spec, reference.bounds_of(&self.spec.case, &self.system));
        let mut judge = Judge::new(spec, reference, &recorded_columns(spec))?;
        self.divide(reference, clock, stop);
        let undivided = self.centre.take().and_then(|centre| centre.map(|centre| judge.divide_by(centre)).err());
        let control = RunControl { stop, inside: inside.then_some(2 * BLOCK), ..RunControl::default() };
        let result = run(self, bounds, clock, control, Some((&mut judge, is_wanted)))?;
        match result.report.outcome {
            // A stopped run is no result: evaluating it would take time for nothing.
            Outcome::Stopped { .. } => Ok(EvaluatedRun::not_evaluated(result.report.outcome)),
            _ => Ok(EvaluatedRun { undivided, ..judge.finish(result)? }),
        }
    }
}

/// Why a side cannot take the steps of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RefusedSteps {
    /// The same for all steps that it cannot take.
    pub reason: String,
    /// What the run asks of it.
    asked: String,
}

impl fmt::Display for RefusedSteps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.reason, self.asked)
    }
}

impl RunSpec {
    /// Says why a side cannot take the steps of the run, if it cannot: it may take those of another macro step or phase.
    pub fn refused_steps(&self) -> Option<RefusedSteps> {
        let (full, even) = (self.macro_step, self.step_control.is_none() && self.phase == 1.0);
        let sides = [
            ("mechanics", self.case.steps.mechanics, self.mechanics_steps.within(full, self.micro_step)),
            ("actuator", self.case.steps.actuator, division(full, self.micro_step)),
        ];
        sides.into_iter().find_map(|(name, possible, count)| {
            let step = full / count as f64;
            if possible.are_fixed() && !even {
                let what = if self.phase == 1.0 { "step control asks" } else { "a phase below 1 asks" };
                let reason =
                    format!("the {name} takes steps of one length only, and {what} for others: use phase 1 and none");
                return Some(RefusedSteps { reason, asked: String::new() });
            }
            let unit = possible.multiple_of.filter(|_| !possible.allows(step))?;
            let reason = format!("the {name} takes multiples of {unit:e} s only");
            let asked = format!(", and is asked for steps of {step:e} s: use a macro step of {count} such");
            Some(RefusedSteps { reason, asked })
        })
    }
}

/// Runs one simulation. `bounds` say beyond what it counts as diverged; with a `clock` its macro steps are timed.
///
/// # Errors
/// Bad input only, such as a wall limit without a clock. A run that fails is a result, with its reason in
/// [`Report::outcome`].
pub fn simulate(spec: &RunSpec, bounds: Bounds, clock: Option<Clock>, stop: StopFlag<'_>) -> Result<RunResult> {
    run(spec.prepare()?, bounds, clock, RunControl { stop, ..RunControl::default() }, None)
}

/// Runs one simulation, and notes what the actuator did in each micro step.
///
/// # Errors
/// As for [`simulate`].
pub fn simulate_inside(spec: &RunSpec, bounds: Bounds, clock: Option<Clock>, stop: StopFlag<'_>) -> Result<RunResult> {
    run(spec.prepare()?, bounds, clock, RunControl { stop, inside: Some(usize::MAX), ..RunControl::default() }, None)
}

/// The columns that a run records.
fn recorded_columns(spec: &RunSpec) -> Vec<String> {
    let mut columns = spec.case.recorded_columns();
    if spec.audit {
        columns.extend(AUDIT_COLUMNS.map(str::to_owned));
    }
    // Several bonds are not audited, and one is a pair.
    if spec.star.as_ref().is_some_and(StarPlan::divides)
        && spec.bond_schemes.iter().chain([&spec.scheme]).any(|scheme| scheme.has_model())
    {
        columns.push(LAMBDA_COLUMN.to_owned());
    }
    columns
}

/// Runs; a judge is shown all rows as they are complete, and those that it has seen are forgotten unless they are
/// wanted.
pub(super) fn run(
    prepared: PreparedRun<'_>,
    bounds: Bounds,
    clock: Option<Clock>,
    control: RunControl<'_>,
    mut judge: Option<(&mut Judge<'_>, bool)>,
) -> Result<RunResult> {
    let PreparedRun { spec, mut system, .. } = prepared;
    let setup = spec.setup(bounds);
    let control = RunControl { audit: spec.audit, ..control };
    if spec.wall_limit.is_some() && clock.is_none() {
        return Err(Error::Incompatible("wall_limit_s needs a clock, and there is none here".to_owned()));
    }
    check_coupling(system.sides.as_ref().map(|side| side.ports()))?;
    let mut recorder = Recorder::new(&spec.case, &mut system)?;
    let mut sides = system.sides.lend();
    if spec.needs_every_entry()
        && let Some(mechanics) = sides.mechanics.capabilities().contact_mechanics()
    {
        mechanics.keep_every_entry();
    }
    let forgets = matches!(judge, Some((_, false)));
    let rows = (setup.expected_macro_steps() + 1).min(if forgets { 2 * BLOCK } else { usize::MAX });
    let mut trajectory = Trajectory::with_capacity(recorded_columns(spec), rows);
    let mut interface_residual = Vec::with_capacity(rows);
    let mut judged = 0;
    let skip = spec
        .scheme
        .incompatibility(sides.lend())
        .or_else(|| spec.refused_steps().map(|refused| refused.to_string()))
        .or_else(|| without_bonds(spec, sides.lend()))
        .or_else(|| uncontrollable(spec.step_control, sides.lend()))
        .or_else(|| unusable_options(spec, sides.lend()))
        .or_else(|| without_bridge(spec, sides.lend()))
        .or_else(|| unusable_belief(spec, sides.lend()))
        .or_else(|| spec.use_integrators(sides.lend()));
    let coupled = match skip {
        Some(reason) => Err(reason),
        None => match &spec.star {
            Some(plan) => Ok(Coupled::Star(Box::new(spec.star(&setup, plan, sides.lend())?))),
            None => {
                let coupling = spec.scheme.couple(sides.lend(), spec.model.as_ref(), spec.gain)?;
                without_forecast(spec, &coupling).map_or_else(|| Ok(Coupled::Pair(Box::new(coupling))), Err)
            }
        },
    };
    let (report, wall) = match coupled {
        Err(reason) => (Report::not_run(Outcome::Skipped { reason }), Duration::ZERO),
        Ok(coupling) => {
            let deadline = Some(Duration::try_from_secs_f64(spec.macro_step).unwrap_or(Duration::MAX));
            let timer = clock.map(|now| Timer { now, deadline, wall_limit: spec.wall_limit });
            let started = clock.map(|now| now());
            let control = RunControl { timer, ..control };
            let mut observe = |mut point: CommunicationPoint<'_>| {
                interface_residual.extend(point.interface_residual);
                let log = point.inside.take();
                recorder.record(point, &mut trajectory);
                let Some((judge, keep)) = &mut judge else { return };
                if let Some(log) = log.filter(|log| log.len() >= BLOCK) {
                    judge.add_inside(log);
                    log.forget(log.len());
                }
                // The last row is complete only with the next.
                let complete = trajectory.len() - 1;
                if complete - judged >= BLOCK {
                    judge.add(&trajectory, judged..complete, interface_residual.get(judged..).unwrap_or_default());
                    judged = complete;
                    if !*keep {
                        trajectory.forget(judged);
                        interface_residual.drain(..judged.min(interface_residual.len()));
                        judged = 0;
                    }
                }
            };
            let report = match coupling {
                Coupled::Pair(pair) => pair.run(&setup, sides, control, &mut observe),
                Coupled::Star(star) => star.run(&setup, sides, control, &mut observe),
            };
            (report, clock.zip(started).map_or(Duration::ZERO, |(now, started)| now() - started))
        }
    };
    recorder.finish(&report, &mut trajectory);
    if let Some((judge, _)) = judge {
        judge.add(&trajectory, judged..trajectory.len(), interface_residual.get(judged..).unwrap_or_default());
    }
    Ok(RunResult { report, trajectory, interface_residual, wall })
}

/// What is run.
enum Coupled {
    Pair(Box<Coupling>),
    Star(Box<Star>),
}

impl RunSpec {
    /// Divides the actuator side among the bonds of a run that has several.
    ///
    /// # Errors
    /// As [`SchemeEntry::couple`](rimbench_core::schemes::SchemeEntry::couple).
    pub fn star(&self, setup: &Setup, plan: &StarPlan, sides: Sides<'_>) -> Result<Star> {
        Star::new(setup, plan, sides, |bond, sides| {
            let scheme = self.bond_schemes.get(bond).unwrap_or(&self.scheme);
            let model = self.model.as_ref().filter(|_| scheme.has_model());
            let Coupling { scheme, exchange, .. } =
                scheme.couple(sides, model, self.gain.filter(|_| scheme.gain.is_some()))?;
            Ok((scheme, exchange))
        })
    }
}

/// Why there cannot be several bonds, if there are to be and cannot.
fn without_bonds(spec: &RunSpec, mut sides: Sides<'_>) -> Option<String> {
    let plan = spec.star.as_ref()?;
    let unmet = spec.bond_schemes.iter().find_map(|scheme| scheme.incompatibility(sides.lend()));
    let law = (plan.known == Known::Law).then_some(Requirement::OutputRates);
    let needs = law.into_iter().chain([Requirement::ForceDisplacement]);
    let needs: Vec<Requirement> = needs.collect();
    let unmet = unmet.or_else(|| needs.iter().find_map(|need| need.unmet(sides.lend())));
    unmet.or_else(|| cannot_divide(plan, sides))
}

/// Why a step control cannot work with these subsystems, if it cannot.
fn uncontrollable(rule: Option<StepRule>, sides: Sides<'_>) -> Option<String> {
    match rule?.control {
        StepControl::None => None,
        StepControl::ModelDefect | StepControl::ModelDefectBlind => {
            Requirement::OutputRates.unmet(sides).map(|reason| format!("step control model-defect: {reason}"))
        }
        StepControl::EnergyResidual | StepControl::EnergyResidualLibcosim => (!counts_interface_work(sides))
            .then(|| "step control energy-residual needs an interface whose work both sides count".to_owned()),
    }
}

/// Why the model cannot be wrong in this way, or its mass not be learned, if it cannot.
fn unusable_belief(spec: &RunSpec, sides: Sides<'_>) -> Option<String> {
    let model = sides.mechanics.capabilities().empty_interface_model()?;
    let wrong = spec.belief.as_ref().and_then(|belief| belief.check_model(&model).err());
    let unlearned = || spec.mass_learning.and_then(|learning| learning.check_model(&model).err());
    wrong.or_else(unlearned).map(|error| error.to_string())
}

/// Why the mechanics has no model of the actuator to bridge late forces, if it is to have one.
fn without_bridge(spec: &RunSpec, sides: Sides<'_>) -> Option<String> {
    spec.delivery.as_ref().filter(|delivery| delivery.bridge == ForceBridge::Rates)?;
    Requirement::OutputRates.unmet(sides).map(|reason| format!("late_forces = rates: {reason}"))
}

/// Why the scheme's model cannot set the macro steps, if it is to and cannot.
fn without_forecast(spec: &RunSpec, coupling: &Coupling) -> Option<String> {
    let by_defect = spec.step_control.is_some_and(|rule| rule.control.by_defect());
    (by_defect && coupling.scheme.forecast().is_none()).then(|| {
        let name = &spec.scheme.name;
        format!("step control model-defect: scheme {name} moves no model of the mechanics together with the actuator")
    })
}

/// Why the model of this mechanics does not go with the options of one, if it does not.
fn unusable_options(spec: &RunSpec, sides: Sides<'_>) -> Option<String> {
    let options = spec.model.as_ref()?;
    // A default that has no effect is no error.
    let usual = spec.scheme.detection(None).ok().flatten();
    let chosen = options.detection.filter(|own| Some(*own) != usual).map(|own| format!("contact_detection = {own}"));
    chosen.as_ref()?;
    let model = sides.mechanics.capabilities().empty_interface_model()?;
    let why =
        "the mechanics' interface model is a smooth one, which has its contacts within and lists none to choose from";
    chosen.filter(|_| model.smooth).map(|chosen| format!("{chosen}: {why}"))
}
