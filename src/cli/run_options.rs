//! The options that determine a run, shared by the commands that make runs.

use clap::Args;
use rimbench::cases::case_by_name;
use rimbench::complementarity::solver_by_name;
use rimbench::error::{Error, Result};
use rimbench::harness::{Choices, RunSpec, parse_mechanics_steps};
use rimbench::schemes::scheme_by_name;

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
    /// Contacts inside a non-smooth interface model: all, near, coupled:<tolerance>
    #[arg(long)]
    contacts: Option<String>,
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
        let macro_step = macro_step.unwrap_or(case.defaults.macro_step_s);
        let choices = Choices {
            sequence: self.sequence.as_deref(),
            force_return: self.force_return.as_deref(),
            redundancy: self.redundancy.as_deref(),
            model_motion: self.model_motion.as_deref(),
            contacts: self.contacts.as_deref(),
            gain: self.gain,
            step_control: self.step_control.as_deref(),
            step_tolerance: self.step_tolerance,
            min_macro_step: self.min_macro_step,
            micro_step: self.micro_step,
            duration: self.duration,
        };
        let spec = RunSpec {
            parameters,
            phase,
            mechanics_steps: parse_mechanics_steps(&self.mechanics_steps)?,
            ..RunSpec::chosen(case, scheme, solver, macro_step, &choices)?
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
