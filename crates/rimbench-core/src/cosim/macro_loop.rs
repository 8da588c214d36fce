//! The macro loop, written once for every case, scheme and sequence.

use super::communication_grid::{CommunicationGrid, MacroStep};
use super::coupled_pair::{CoupledPair, Interval};
use super::coupling_scheme::{CouplingScheme, Diagnostics};
use super::energy_account::EnergyAudit;
use super::force_return::{ForceReturn, Sequence};
use super::latency::{Stopwatch, Timing};
use super::outcome::Outcome;
use super::pace::Pace;
use super::report::Report;
use super::step_control::StepControl;
use super::subsystem::Subsystem;
use crate::error::Failure;

/// Everything that determines a run besides the subsystems and the scheme.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// The communication points.
    pub grid: CommunicationGrid,
    /// How the length of the macro steps is found. The first one of `grid` is the start, its `H` the longest.
    pub step_control: StepControl,
    /// Longest micro step of the actuator side, s; the one used divides the macro step.
    pub micro_step: f64,
    /// The mechanics' own steps per macro step n_m; 0 stands for as many as the actuator side takes.
    pub mechanics_steps: usize,
    /// Who goes first.
    pub sequence: Sequence,
    /// What the mechanics receives.
    pub force_return: ForceReturn,
    /// Outputs with direct feedthrough are evaluated with the input used last, not with the fresh one.
    pub stale_feedthrough: bool,
    /// Beyond these the run counts as diverged.
    pub bounds: Bounds,
    /// What to do with the clock.
    pub timing: Timing,
}

/// Largest admissible magnitude of each coupling variable, by side; `+inf` where there is none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bounds {
    /// For the outputs of the mechanics.
    pub mechanics: Vec<f64>,
    /// For the outputs of the actuator.
    pub actuator: Vec<f64>,
}

/// What an observer sees at a communication point.
pub struct CommunicationPoint<'a> {
    /// `t_k`, s.
    pub time: f64,
    /// Outputs of the mechanics.
    pub y_mechanics: &'a [f64],
    /// Outputs of the actuator: its own, at this instant.
    pub y_actuator: &'a [f64],
    /// What the mechanics received over the macro step that ends here (at `t_0`: what it would be held at).
    pub received: &'a [f64],
    /// The scheme's own picture.
    pub diagnostics: Diagnostics,
    /// The mechanics' own step in the macro step that starts here, s.
    pub mechanics_step: f64,
    /// The mechanics.
    pub mechanics: &'a mut dyn Subsystem,
    /// The actuator.
    pub actuator: &'a mut dyn Subsystem,
}

/// Runs two subsystems coupled by a scheme, and calls `observe` at each communication point.
///
/// The ports must fit (see [`check_coupling`](super::check_coupling)) and the force return must suit the sequence (see
/// [`ForceReturn::check`]). Nothing is allocated once the first macro step has begun, unless the scheme iterates or the
/// step is controlled. Such a run goes on with copies: what is to be known of the subsystems then is what `observe` sees and
/// what the report holds, while those given may be left where they were.
pub fn cosimulate(
    setup: &Setup,
    mechanics: &mut dyn Subsystem,
    actuator: &mut dyn Subsystem,
    scheme: &mut dyn CouplingScheme,
    observe: &mut dyn FnMut(CommunicationPoint<'_>),
) -> Report {
    let mut run = Run {
        pair: CoupledPair::new(setup, mechanics, actuator, scheme),
        interface_residual: Vec::with_capacity(setup.grid.macro_steps() + 1),
        stopwatch: Stopwatch::new(setup.timing, setup.grid.macro_steps()),
    };
    let result = match setup.step_control {
        StepControl::StepDoubling(rule) => run.doubled_steps(rule, observe),
        StepControl::None | StepControl::EnergyResidual(_) => run.macro_steps(observe),
    };
    let mut pair = run.pair;
    let outcome = match (pair.diverged.take(), result) {
        (Some(diverged), _) => diverged,
        (None, Err(failure)) => Outcome::from_failure(failure, pair.time),
        (None, Ok(End::Overdue)) => Outcome::Timeout { at_s: pair.time },
        (None, Ok(End::Reached)) => Outcome::Completed,
    };
    let (work, spent) = (pair.interface_work(), pair.work());
    let (mechanics, actuator) = (pair.mechanics.energy_account(), pair.actuator.energy_account());
    Report {
        outcome,
        ended_at_s: pair.time,
        counters: spent.cosim,
        spent,
        energy_identity_residual_j: pair.mechanics.energy_identity_residual(),
        work,
        scheme_dissipated_j: pair.scheme.dissipated_j(),
        audit: EnergyAudit { mechanics, actuator, work },
        interface_residual: run.interface_residual,
        latencies_s: run.stopwatch.latencies,
    }
}

/// How the loop ended, where nothing failed.
pub(super) enum End {
    Reached,
    Overdue,
}

/// The loop: the pair, and what is noted along the way.
pub(super) struct Run<'a> {
    pub(super) pair: CoupledPair<'a>,
    interface_residual: Vec<[f64; 2]>,
    pub(super) stopwatch: Stopwatch,
}

impl Run<'_> {
    /// The algorithm: exchange, then let both sides cover the macro step.
    fn macro_steps(&mut self, observe: &mut dyn FnMut(CommunicationPoint<'_>)) -> Result<End, Failure> {
        let mut pace = Pace::new(self.pair.setup);
        let mut next = pace.first();
        loop {
            if self.stopwatch.expired() {
                return Ok(End::Overdue);
            }
            let Interval { step, end } = next;
            self.stopwatch.begin();
            self.pair.exchange(step)?;
            self.note(step, observe);
            self.pair.advance(next)?;
            self.stopwatch.end();
            match pace.after(next, self.pair.interface_work()) {
                Some(interval) => next = interval,
                None => return self.finish(MacroStep { index: step.index + 1, start: end, ..step }, observe),
            }
        }
    }

    /// The last communication point; `step` would follow it.
    pub(super) fn finish(
        &mut self,
        step: MacroStep,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) -> Result<End, Failure> {
        self.pair.exchange(step)?;
        self.note(step, observe);
        Ok(End::Reached)
    }

    /// Notes the communication point at which `step` starts, and shows it; that is no part of the macro step.
    pub(super) fn note(&mut self, step: MacroStep, observe: &mut dyn FnMut(CommunicationPoint<'_>)) {
        if let Some(residual) = self.pair.interface_work().residual_j() {
            self.interface_residual.push([self.pair.time, residual]);
        }
        self.stopwatch.pause();
        self.pair.show(step, observe);
        self.stopwatch.resume();
    }
}
