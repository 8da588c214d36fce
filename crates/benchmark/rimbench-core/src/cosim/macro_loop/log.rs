//! The records of a run, put together at its end.

use super::View;
use crate::cosim::communication_grid::MacroStep;
use crate::cosim::communication_point::CommunicationPoint;
use crate::cosim::coupled_pair::CoupledPair;
use crate::cosim::energy_account::EnergyAudit;
use crate::cosim::interface_work::InterfaceWork;
use crate::cosim::outcome::Outcome;
use crate::cosim::report::Report;
use crate::cosim::run_control::{Stopwatch, Timer};
use crate::cosim::setup::Setup;
use crate::cosim::side::{PerSide, Side};
use crate::cosim::subsystem::Sides;
use crate::cosim::work::Work;
use crate::error::Failure;

/// How the loop ended, where nothing failed.
pub(crate) enum End {
    Reached,
    Overdue,
}

/// The stopwatch and the defects so far. Room for all of it is made beforehand.
pub(crate) struct Log {
    pub(crate) stopwatch: Stopwatch,
    model_defect: Vec<[f64; 2]>,
}

impl Log {
    /// Makes room for a run that is set up like this.
    pub(crate) fn new(timer: Option<Timer>, setup: &Setup) -> Self {
        let macro_steps = setup.expected_macro_steps();
        let by_defect = setup.step_rule.is_some_and(|rule| rule.control.by_defect());
        Log {
            stopwatch: Stopwatch::new(timer),
            model_defect: Vec::with_capacity(if by_defect { macro_steps } else { 0 }),
        }
    }

    /// Notes by how much the scheme's model was wrong, N, at `time` (s).
    #[cold]
    pub(crate) fn record_defect(&mut self, time: f64, defect: f64) {
        self.model_defect.push([time, defect]);
    }

    /// Notes the communication point at which `step` starts, and shows it; that is no part of the macro step.
    /// `effective_mass` is what the scheme says of the macro step before.
    pub(crate) fn note(
        &mut self,
        run: &mut View<'_>,
        step: MacroStep,
        effective_mass: Option<f64>,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) {
        self.stopwatch.pause();
        run.show(step, effective_mass, observe);
        self.stopwatch.resume();
    }

    /// Returns the report of the whole run, which took `work` and ended like this.
    pub(crate) fn report(self, pair: &mut CoupledPair<'_>, work: Work, ended: Result<End, Failure>) -> Report {
        let at_s = pair.state.time;
        let outcome = self.outcome(at_s, pair.state.diverged.take(), ended);
        let of_interface = pair.interface_work();
        let mut report = self.of_sides(outcome, at_s, pair.sides.lend(), of_interface);
        let model = pair.state.model.as_ref();
        report.audit.model = model.and_then(|model| model.audit.as_ref()?.energy());
        Report {
            work,
            scheme: pair.scheme.report(),
            learned_mass: model.and_then(|model| Some(model.learner.as_ref()?.mass_factor())),
            late_acceleration_correlation: pair.state.late.as_ref().and_then(|late| late.acceleration_correlation()),
            inside: pair.state.inside.take(),
            ..report
        }
    }

    /// How a run ended at `at_s` that may have `diverged` before.
    pub(crate) fn outcome(&self, at_s: f64, diverged: Option<Outcome>, ended: Result<End, Failure>) -> Outcome {
        match (diverged, ended) {
            // A stopped run does not report how it might have ended.
            (_, Err(failure)) if failure.is_stop() => Outcome::Stopped { at_s },
            (Some(diverged), _) => diverged,
            (None, Err(failure)) => Outcome::from_failure(failure, at_s),
            (None, Ok(End::Overdue)) => Outcome::Timeout { at_s },
            (None, Ok(End::Reached)) => Outcome::Completed,
        }
    }

    /// The part of a report that both sides know, and this log.
    pub(crate) fn of_sides(
        self,
        outcome: Outcome,
        ended_at_s: f64,
        mut sides: Sides<'_>,
        work: InterfaceWork,
    ) -> Report {
        Report {
            ended_at_s,
            energy_identity_residual_j: sides.mechanics.capabilities().energy_identity_residual(),
            audit: EnergyAudit {
                accounts: PerSide::from_fn(|side: Side| sides[side].capabilities().energy_account()),
                work,
                model: None,
            },
            model_defect: self.model_defect,
            latencies: self.stopwatch.latencies,
            ..Report::not_run(outcome)
        }
    }
}
