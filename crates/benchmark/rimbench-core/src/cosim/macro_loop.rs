//! The macro loop, written once for every case, scheme and sequence.

mod log;
mod star;

pub(crate) use log::{End, Log};
use star::RunningStar;
pub use star::{Every, Known, MicroSteps, Order, Partition, Share, Star, StarPlan, Tells, cannot_divide};

use super::communication_grid::MacroStep;
use super::communication_point::CommunicationPoint;
use super::coupled_pair::CoupledPair;
use super::coupling_scheme::CouplingScheme;
use super::exchange_data::ExchangeData;
use super::force_return::ForceReturn;
use super::interface_work::InterfaceWork;
use super::late_samples::Shadow;
use super::micro_log::micro_log;
use super::model_audit::ModelAudit;
use super::pair_state::PairState;
use super::report::Report;
use super::run_control::{RunControl, Timer};
use super::setup::Setup;
use super::step_size_control::{ErrorEstimate, ErrorMeter, MacroInterval, StepSizeControl};
use super::subsystem::Sides;
use crate::error::Failure;

/// Runs two subsystems coupled by a scheme, and calls `observe` at each communication point.
///
/// The ports must fit (see [`check_coupling`](super::check_coupling)), the force return must suit the sequence (see
/// [`ForceReturn::check`](super::ForceReturn::check)), and `exchange` must be what the scheme needs. Nothing is
/// allocated once the first macro step has begun, and no step is ever taken back.
pub fn cosimulate(
    setup: &Setup,
    mut sides: Sides<'_>,
    scheme: &mut dyn CouplingScheme,
    exchange: ExchangeData,
    control: RunControl<'_>,
    observe: &mut dyn FnMut(CommunicationPoint<'_>),
) -> Report {
    let inside = control.inside.map(|most| micro_log(setup, &sides, most));
    let averages = matches!(setup.force_return, ForceReturn::Mean | ForceReturn::Profile);
    let state = &mut PairState { inside, ..PairState::new(setup, sides.lend(), exchange) };
    if let Some(model) = state.model.as_mut().filter(|_| control.audit && averages) {
        model.audit = Some(ModelAudit::new(&model.model, setup.belief.is_some()));
        let copy = state.late.as_ref().and_then(|_| scheme.try_clone());
        model.in_time = copy.map(|copy| Shadow::new(copy, sides.actuator.ports()));
    }
    let pair = CoupledPair { setup, sides: sides.lend(), scheme, state, stop: control.stop };
    cover(MacroInterval::whole, |pair, interval| pair.advance(interval), pair, control.timer, observe)
}

/// Runs a pair with every macro step covered by `advance`, after the exchange for what is `first` of it.
pub(crate) fn cover(
    first: impl Fn(MacroInterval) -> MacroStep,
    advance: impl Fn(&mut CoupledPair<'_>, MacroInterval) -> Result<(), Failure>,
    mut pair: CoupledPair<'_>,
    timer: Option<Timer>,
    observe: &mut dyn FnMut(CommunicationPoint<'_>),
) -> Report {
    let mut log = Log::new(timer, pair.setup);
    let ended = macro_steps(&mut pair, |pair| View::Pair(pair.lend()), (first, advance), &mut log, observe);
    let work = pair.work();
    log.report(&mut pair, work, ended)
}

/// What the loop runs: a mechanics with one bond, or with several.
pub(crate) enum View<'a> {
    Pair(CoupledPair<'a>),
    Star(RunningStar<'a>),
}

impl View<'_> {
    fn setup(&self) -> &Setup {
        match self {
            View::Pair(pair) => pair.setup,
            View::Star(star) => star.setup(),
        }
    }

    fn exchange(&mut self, step: MacroStep) -> Result<(), Failure> {
        match self {
            View::Pair(pair) => pair.exchange(step),
            View::Star(star) => star.exchange(step),
        }
    }

    pub(super) fn show(
        &mut self,
        step: MacroStep,
        effective_mass: Option<f64>,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) {
        match self {
            View::Pair(pair) => pair.show(step, effective_mass, observe),
            View::Star(star) => star.show(step, effective_mass, observe),
        }
    }

    fn effective_mass(&mut self) -> Option<f64> {
        match self {
            View::Pair(pair) => pair.scheme.report().effective_mass,
            View::Star(star) => star.effective_mass(),
        }
    }

    fn interface_work(&mut self) -> InterfaceWork {
        match self {
            View::Pair(pair) => pair.interface_work(),
            View::Star(star) => star.interface_work(),
        }
    }

    fn error_meter(&self) -> ErrorMeter {
        match self {
            View::Pair(pair) => ErrorMeter::of(pair.setup.step_rule, pair.sides.actuator.ports()),
            // No rule sets the macro steps of a star.
            View::Star(_) => ErrorMeter::Work,
        }
    }

    fn estimate(&mut self, meter: &mut ErrorMeter, end: f64) -> Result<ErrorEstimate, Failure> {
        match self {
            View::Pair(pair) => pair.estimate(meter, end),
            View::Star(_) => Ok(ErrorEstimate::Work),
        }
    }
}

/// Runs the algorithm: exchange for what is `first` of a macro step, then let all cover it in the way that `advance`
/// says.
///
/// `run` is the run, or what stands for it where steps are taken again; `lend` gives it as the exchange knows it.
pub(crate) fn macro_steps<P>(
    run: &mut P,
    lend: impl Fn(&mut P) -> View<'_>,
    (first, advance): (impl Fn(MacroInterval) -> MacroStep, impl Fn(&mut P, MacroInterval) -> Result<(), Failure>),
    log: &mut Log,
    observe: &mut dyn FnMut(CommunicationPoint<'_>),
) -> Result<End, Failure> {
    let view = lend(run);
    let mut meter = view.error_meter();
    let mut control = StepSizeControl::new(view.setup().grid, view.setup().step_rule);
    let mut next = control.first();
    let mut effective_mass = None;
    loop {
        if log.stopwatch.expired() {
            return Ok(End::Overdue);
        }
        log.stopwatch.begin();
        let mut before = lend(run);
        let step = first(next);
        before.exchange(step)?;
        log.note(&mut before, step, effective_mass, observe);
        advance(run, next)?;
        log.stopwatch.end();
        let mut after = lend(run);
        effective_mass = after.effective_mass();
        let estimate = after.estimate(&mut meter, next.end)?;
        if let ErrorEstimate::Defect(defect) = &estimate {
            log.record_defect(next.end, defect.force);
        }
        match control.after(next, after.interface_work(), estimate) {
            Some(interval) => next = interval,
            None => return finish(&mut after, log, next.after(), effective_mass, observe),
        }
    }
}

/// Exchanges at the last communication point; `step` would follow it, and `effective_mass` is that of the macro step
/// before.
pub(crate) fn finish(
    run: &mut View<'_>,
    log: &mut Log,
    step: MacroStep,
    effective_mass: Option<f64>,
    observe: &mut dyn FnMut(CommunicationPoint<'_>),
) -> Result<End, Failure> {
    run.exchange(step)?;
    log.note(run, step, effective_mass, observe);
    Ok(End::Reached)
}
