//! The records of a run, put together at its end.

use super::communication_grid::MacroStep;
use super::communication_point::CommunicationPoint;
use super::coupled_pair::CoupledPair;
use super::energy_account::EnergyAudit;
use super::outcome::Outcome;
use super::report::Report;
use super::run_control::{Stopwatch, Timer};
use super::setup::Setup;
use super::side::{PerSide, Side};
use super::work::Work;
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
        pair: &mut CoupledPair<'_>,
        step: MacroStep,
        effective_mass: Option<f64>,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) {
        self.stopwatch.pause();
        pair.show(step, effective_mass, observe);
        self.stopwatch.resume();
    }

    /// Returns the report of the whole run, which took `work` and ended like this.
    pub(crate) fn report(self, pair: &mut CoupledPair<'_>, work: Work, ended: Result<End, Failure>) -> Report {
        let at_s = pair.state.time;
        let outcome = match (pair.state.diverged.take(), ended) {
            // A stopped run does not report how it might have ended.
            (_, Err(failure)) if failure.is_stop() => Outcome::Stopped { at_s },
            (Some(diverged), _) => diverged,
            (None, Err(failure)) => Outcome::from_failure(failure, at_s),
            (None, Ok(End::Overdue)) => Outcome::Timeout { at_s },
            (None, Ok(End::Reached)) => Outcome::Completed,
        };
        Report {
            outcome,
            ended_at_s: at_s,
            work,
            energy_identity_residual_j: pair.sides.mechanics.capabilities().energy_identity_residual(),
            audit: EnergyAudit {
                accounts: PerSide::from_fn(|side: Side| pair.sides[side].capabilities().energy_account()),
                work: pair.interface_work(),
                model: pair.state.audit.as_ref().and_then(|audit| audit.energy()),
            },
            scheme: pair.scheme.report(),
            model_defect: self.model_defect,
            learned_mass: pair.state.learner.as_ref().map(|learner| learner.mass_factor()),
            late_acceleration_correlation: pair.state.late.as_ref().and_then(|late| late.acceleration_correlation()),
            latencies: self.stopwatch.latencies,
            inside: pair.state.inside.take(),
        }
    }
}
