//! One run: everything that determines it, and what comes of it.

use super::cache::hex;
use rimbench_cases::cases::{Case, CoupledSystem, Parameters, Recorder};
use rimbench_core::complementarity::{SolverCounters, SolverEntry};
use rimbench_core::cosim::{
    Bounds, CommunicationGrid, CouplingScheme, ForceReturn, Outcome, Report, Sequence, Setup, StepControl,
    SubsystemCounters, Timing, Trajectory, check_coupling, cosimulate, counts_interface_work,
};
use rimbench_core::error::{Error, Result};
use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_core::schemes::{ContactChoice, Need, SchemeEntry, SchemeOptions};
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::time::{Duration, Instant};

/// Everything that determines a run.
#[derive(Debug, Clone)]
pub struct RunSpec {
    /// The case.
    pub case: &'static Case,
    /// Its parameters, resolved.
    pub parameters: Parameters,
    /// The coupling scheme.
    pub scheme: &'static SchemeEntry,
    /// Options of the scheme.
    pub options: SchemeOptions,
    /// Macro step H, s.
    pub macro_step: f64,
    /// How the macro step is controlled; H is then the first and the longest.
    pub step_control: StepControl,
    /// Communication phase φ ∈ (0, 1].
    pub phase: f64,
    /// Longest micro step of the actuator side, s.
    pub micro_step: f64,
    /// The mechanics' own steps per macro step; 0 stands for as many as the actuator side takes.
    pub mechanics_steps: usize,
    /// Who goes first.
    pub sequence: Sequence,
    /// What the mechanics receives.
    pub force_return: ForceReturn,
    /// Simulated time, s.
    pub duration: f64,
    /// Solver of the mechanics' complementarity problems (the scheme's own is in `options`).
    pub solver: &'static SolverEntry,
    /// Wall time after which the run ends with [`Outcome::Timeout`]. No part of the run id.
    pub wall_limit: Option<Duration>,
}

/// What comes of a run.
#[derive(Debug, Clone)]
pub struct RunResult {
    /// How it ended, and the loop's own counters.
    pub report: Report,
    /// One row per communication point.
    pub trajectory: Trajectory,
    /// Work of the mechanics, that on copies included.
    pub mechanics: SubsystemCounters,
    /// Work of the actuator, that on copies included.
    pub actuator: SubsystemCounters,
    /// Complementarity solves inside the scheme.
    pub scheme: SolverCounters,
    /// Largest violation of the mechanics' energy identity in one step, J.
    pub energy_identity_residual_j: Option<f64>,
    /// Wall time of the macro loop.
    pub wall: Duration,
}

impl RunSpec {
    /// Hash of everything that determines the run, 16 hexadecimal digits.
    pub fn id(&self) -> String {
        let mut key = format!("numerics {NUMERICS_VERSION}\ncase {}\n", self.case.name);
        // Writing to a string cannot fail.
        for (parameter, value) in self.parameters.iter() {
            let _ = writeln!(key, "{} = {value}", parameter.name);
        }
        let _ = write!(
            key,
            "scheme {} {:?} {} {}\nH = {:?} φ = {:?} h = {:?} n_m = {} T = {:?}\nsequence {} return {} solver {}\n",
            self.scheme.name,
            self.options.redundancy,
            self.options.motion,
            self.options.solver.name,
            self.macro_step,
            self.phase,
            self.micro_step,
            self.mechanics_steps,
            self.duration,
            self.sequence,
            self.force_return,
            self.solver.name,
        );
        if let Some(gain) = self.options.gain {
            key += &format!("gain {gain:?}\n");
        }
        // Ids from before there was a choice stay valid.
        if self.options.contacts != ContactChoice::All {
            key += &format!("contacts {}\n", self.options.contacts);
        }
        // Runs with steps of the grid keep the ids they always had.
        if let Some(rule) = self.step_control.rule() {
            key += &format!(
                "step control {} tolerance {:?} shortest {:?}\n",
                self.step_control, rule.tolerance, rule.shortest
            );
        }
        hex(&Sha256::digest(key))[..16].to_owned()
    }

    /// Checks everything that can be checked without running.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] or [`Error::Incompatible`], naming what is wrong and what would be valid.
    pub fn check(&self) -> Result<()> {
        let macro_steps = self.grid()?.macro_steps();
        if macro_steps < self.scheme.samples {
            return Err(Error::invalid(
                "macro-step",
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
        self.scheme.gain_value(self.options.gain)?;
        self.step_control.check(self.macro_step)?;
        if let Some(rule) = self.step_control.rule()
            && self.duration / rule.shortest > MOST_STEPS
        {
            let expected = format!("at least {:e} s for this duration", self.duration / MOST_STEPS);
            return Err(Error::invalid("min_macro_step_s", rule.shortest, expected));
        }
        self.scheme.check_sequence(self.sequence)?;
        self.scheme.check_force_return(self.force_return)?;
        self.force_return.check(self.sequence)
    }

    /// The communication points.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for steps that are not positive, or a micro step above the macro step.
    pub fn grid(&self) -> Result<CommunicationGrid> {
        let nonsense = !(self.macro_step > 0.0 && self.duration > 0.0);
        if !nonsense && self.duration / self.macro_step > MOST_STEPS {
            let least = self.duration / MOST_STEPS;
            return Err(Error::invalid(
                "macro-step",
                self.macro_step,
                format!("at least {least:e} s for this duration"),
            ));
        }
        let grid = CommunicationGrid::new(self.macro_step, self.phase, self.duration)?;
        if !(self.micro_step.is_finite() && self.micro_step > 0.0) {
            return Err(Error::invalid("micro-step", self.micro_step, "a finite time above 0 s"));
        }
        if self.macro_step / self.micro_step > MOST_STEPS {
            let least = self.macro_step / MOST_STEPS;
            return Err(Error::invalid(
                "micro-step",
                self.micro_step,
                format!("at least {least:e} s for this macro step"),
            ));
        }
        if self.micro_step > self.macro_step {
            let expected = format!("at most the macro step, {} s", self.macro_step);
            return Err(Error::invalid("micro-step", self.micro_step, expected));
        }
        Ok(grid)
    }

    /// What the macro loop of the run needs to know, each macro step timed. `system` is that of its case; `bounds` say beyond
    /// what it counts as diverged.
    ///
    /// # Errors
    /// Those of [`RunSpec::grid`].
    pub fn setup(&self, system: &CoupledSystem, bounds: Bounds) -> Result<Setup> {
        Ok(Setup {
            grid: self.grid()?,
            step_control: self.step_control,
            micro_step: self.micro_step,
            mechanics_steps: self.mechanics_steps,
            sequence: self.sequence,
            force_return: self.force_return,
            stale_feedthrough: system.stale_feedthrough,
            bounds,
            timing: Timing { latency: true, wall_limit: self.wall_limit },
        })
    }
}

/// Runs one simulation. `bounds` say beyond what it counts as diverged.
///
/// # Errors
/// Bad input only. A run that fails is a result, with its reason in [`Report::outcome`].
pub fn simulate(spec: &RunSpec, bounds: Bounds) -> Result<RunResult> {
    spec.check()?;
    let mut system = (spec.case.build)(&spec.parameters, spec.solver)?;
    let setup = spec.setup(&system, bounds)?;
    check_coupling(system.mechanics.ports(), system.actuator.ports())?;
    let mut scheme = (spec.scheme.build)(system.mechanics.ports(), system.actuator.ports(), &spec.options);
    let skip = spec
        .scheme
        .incompatibility(&*system.mechanics, &*system.actuator)
        .or_else(|| uncontrollable(spec.step_control, &system, &*scheme));
    let mut recorder = Recorder::new(spec.case, &mut system);
    let mut trajectory = Trajectory::with_capacity(spec.case.recorded_columns(), setup.grid.macro_steps() + 1);
    let started = Instant::now();
    let report = match skip {
        Some(reason) => Report::not_run(Outcome::Skipped { reason }),
        None => cosimulate(&setup, &mut *system.mechanics, &mut *system.actuator, &mut *scheme, &mut |point| {
            recorder.record(point, &mut trajectory)
        }),
    };
    let wall = started.elapsed();
    Ok(RunResult {
        mechanics: report.spent.mechanics,
        actuator: report.spent.actuator,
        scheme: report.spent.scheme,
        energy_identity_residual_j: report.energy_identity_residual_j,
        report,
        trajectory,
        wall,
    })
}

/// Why a step control cannot work with these subsystems and this scheme, if it cannot.
fn uncontrollable(control: StepControl, system: &CoupledSystem, scheme: &dyn CouplingScheme) -> Option<String> {
    let (mechanics, actuator) = (&*system.mechanics, &*system.actuator);
    match control {
        StepControl::None => None,
        StepControl::EnergyResidual(_) => (!counts_interface_work(mechanics, actuator))
            .then(|| "step control energy-residual needs an interface whose work both sides count".to_owned()),
        StepControl::StepDoubling(_) => Need::Copies
            .unmet(mechanics, actuator)
            .or_else(|| scheme.try_clone().is_none().then(|| "the scheme cannot be copied".to_owned()))
            .map(|reason| format!("step control step-doubling takes steps back: {reason}")),
    }
}

/// Reads the number of mechanics steps per macro step: a whole number from 1, or `all` (0 in [`RunSpec`]).
///
/// # Errors
/// [`Error::InvalidValue`] for anything else.
pub fn parse_mechanics_steps(text: &str) -> Result<usize> {
    match text.trim() {
        "all" => Ok(0),
        number => number.parse().ok().filter(|count| (1..=MOST_MECHANICS_STEPS).contains(count)).ok_or_else(|| {
            let expected =
                format!("a whole number from 1 to {MOST_MECHANICS_STEPS}, or `all` for as many as the actuator takes");
            Error::invalid("mechanics-steps", text, expected)
        }),
    }
}

/// A wall-time limit from seconds.
///
/// # Errors
/// [`Error::InvalidValue`] for anything but a time above zero.
pub fn wall_limit(seconds: f64) -> Result<Duration> {
    let limit = Duration::try_from_secs_f64(seconds).ok().filter(|limit| !limit.is_zero());
    limit.ok_or_else(|| Error::invalid("wall_limit_s", seconds, "a finite time above 0 s"))
}

/// Plausibility bounds, far beyond any use, so that a slip of the exponent is an error and not an endless run.
const MOST_MECHANICS_STEPS: usize = 1_000_000;
const MOST_STEPS: f64 = 1e7;
