//! The options that determine a run, shared by the commands that make runs.

use clap::Args;
use rimbench::cases::case_by_name;
use rimbench::complementarity::solver_by_name;
use rimbench::cosim::{ForceReturn, Sequence, StepControl};
use rimbench::error::{Error, Result};
use rimbench::harness::{RunSpec, parse_mechanics_steps, scheme_options};
use rimbench::schemes::{SchemeOptions, scheme_by_name};

/// Case, scheme and everything else that determines a run, but for the macro step and the phase.
#[derive(Debug, Args)]
pub struct RunOptions {
    /// Case by name (see `rimbench list cases`)
    #[arg(long)]
    case: String,
    /// Coupling scheme by name (see `rimbench list schemes`)
    #[arg(long)]
    scheme: String,
    /// Order of the sides: jacobi, gauss-seidel (actuator first), gauss-seidel-mechanics-first
    #[arg(long)]
    sequence: Option<String>,
    /// What the mechanics receives: held, end, mean, profile
    #[arg(long)]
    force_return: Option<String>,
    /// The mechanics' own steps per macro step, or `all` for as many as the actuator takes
    #[arg(long, value_name = "N", default_value = "1", allow_hyphen_values = true)]
    mechanics_steps: String,
    /// Longest micro step of the actuator side, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    micro_step: Option<f64>,
    /// Simulated time, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Solver of the complementarity problems (see `rimbench list solvers`)
    #[arg(long, default_value = "active-set")]
    solver: String,
    /// Dependent contacts that become bilateral: drop, pseudo-inverse, regularised
    #[arg(long)]
    redundancy: Option<String>,
    /// Interface model within a macro step: frozen, extrapolated
    #[arg(long)]
    model_motion: Option<String>,
    /// The scheme's gain, where it has one (see `rimbench list schemes`)
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    gain: Option<f64>,
    /// How the macro step is controlled, H being the first and the longest: none, energy-residual, step-doubling
    #[arg(long)]
    step_control: Option<String>,
    /// Error allowed per macro step where the step is controlled, a pure number
    #[arg(long, value_name = "TOL", allow_negative_numbers = true)]
    step_tolerance: Option<f64>,
    /// Shortest macro step where the step is controlled, s; default H/100
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    min_macro_step: Option<f64>,
    /// A parameter of the case, key=value (see `rimbench list parameters`); may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl RunOptions {
    /// The run at macro step `macro_step` (the case's own if none is given) and phase `phase`.
    pub(super) fn spec(&self, macro_step: Option<f64>, phase: f64) -> Result<RunSpec> {
        let case = case_by_name(&self.case)?;
        let scheme = scheme_by_name(&self.scheme)?;
        let solver = solver_by_name(&self.solver)?;
        let mut parameters = case.default_parameters();
        for assignment in &self.set {
            let (key, value) = assignment
                .split_once('=')
                .ok_or_else(|| Error::invalid("--set", assignment, "key=value, for example box_mass_kg=250"))?;
            parameters.set(key.trim(), value.trim())?;
        }
        let sequence: Option<Sequence> = self.sequence.as_deref().map(str::parse).transpose()?;
        let force_return: Option<ForceReturn> = self.force_return.as_deref().map(str::parse).transpose()?;
        let (sequence, force_return) = scheme.sequence_and_return(sequence, force_return)?;
        let macro_step = macro_step.unwrap_or(case.defaults.macro_step_s);
        let options = scheme_options(self.redundancy.as_deref(), self.model_motion.as_deref(), solver)?;
        let step_control = StepControl::new(
            self.step_control.as_deref(),
            self.step_tolerance,
            self.min_macro_step,
            macro_step,
            scheme.order,
        )?;
        let spec = RunSpec {
            step_control,
            case,
            parameters,
            scheme,
            options: SchemeOptions { gain: scheme.gain_value(self.gain)?, ..options },
            macro_step,
            phase,
            // A macro step below the usual micro step is its own micro step, unless one is asked for.
            micro_step: self.micro_step.unwrap_or(case.defaults.micro_step_s.min(macro_step)),
            mechanics_steps: parse_mechanics_steps(&self.mechanics_steps)?,
            sequence,
            force_return,
            duration: self.duration.unwrap_or(case.defaults.duration_s),
            solver,
            wall_limit: None,
        };
        spec.check()?;
        // Impossible parameters are found before anything is computed.
        (spec.case.build)(&spec.parameters, spec.solver)?;
        Ok(spec)
    }

    /// Whether the micro step was asked for, rather than the case's own.
    pub(super) fn fixes_micro_step(&self) -> bool {
        self.micro_step.is_some()
    }
}
