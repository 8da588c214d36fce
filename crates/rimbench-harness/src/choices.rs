//! What may be said of a run beyond its case, scheme and macro step, in words as experiment files and the command line have them.

use super::run::RunSpec;
use rimbench_cases::cases::Case;
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::cosim::StepControl;
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::Redundancy;
use rimbench_core::schemes::{SchemeEntry, SchemeOptions};

/// Relative compliance of the `regularised` redundancy treatment.
const REGULARISATION: f64 = 1e-8;

/// Choices of a run; `None` leaves what is usual for the scheme or the case.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Choices<'a> {
    /// Who goes first.
    pub sequence: Option<&'a str>,
    /// What the mechanics receives.
    pub force_return: Option<&'a str>,
    /// What becomes of dependent contacts.
    pub redundancy: Option<&'a str>,
    /// The interface model within a macro step.
    pub model_motion: Option<&'a str>,
    /// Contacts taken into the model.
    pub contacts: Option<&'a str>,
    /// Gain of a scheme that can be tuned.
    pub gain: Option<f64>,
    /// How the macro step is controlled.
    pub step_control: Option<&'a str>,
    /// Error allowed per controlled macro step.
    pub step_tolerance: Option<f64>,
    /// Shortest controlled macro step, s.
    pub min_macro_step: Option<f64>,
    /// Longest micro step of the actuator side, s.
    pub micro_step: Option<f64>,
    /// Simulated time, s.
    pub duration: Option<f64>,
}

impl RunSpec {
    /// The run that an experiment means where it says no more than case, scheme and macro step (s). `solver` serves both sides.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for a scheme whose own sequence, force return and gain do not go together.
    pub fn usual(
        case: &'static Case,
        scheme: &'static SchemeEntry,
        solver: &'static SolverEntry,
        macro_step: f64,
    ) -> Result<Self> {
        Self::chosen(case, scheme, solver, macro_step, &Choices::default())
    }

    /// The same with choices of one's own.
    ///
    /// # Errors
    /// [`Error::UnknownName`], [`Error::InvalidValue`] or [`Error::Incompatible`] for a choice that there is not, or that the
    /// scheme does not have.
    pub fn chosen(
        case: &'static Case,
        scheme: &'static SchemeEntry,
        solver: &'static SolverEntry,
        macro_step: f64,
        choices: &Choices<'_>,
    ) -> Result<Self> {
        let sequence = choices.sequence.map(str::parse).transpose()?;
        let force_return = choices.force_return.map(str::parse).transpose()?;
        let (sequence, force_return) = scheme.sequence_and_return(sequence, force_return)?;
        let options = scheme_options(choices.redundancy, choices.model_motion, solver)?;
        let step_control = StepControl::new(
            choices.step_control,
            choices.step_tolerance,
            choices.min_macro_step,
            macro_step,
            scheme.order,
        )?;
        Ok(RunSpec {
            case,
            parameters: case.default_parameters(),
            scheme,
            options: SchemeOptions { gain: scheme.gain_value(choices.gain)?, ..options }
                .with_contacts(choices.contacts)?,
            macro_step,
            step_control,
            phase: 1.0,
            // A macro step below the usual micro step is its own micro step, unless one is asked for.
            micro_step: choices.micro_step.unwrap_or(case.defaults.micro_step_s.min(macro_step)),
            mechanics_steps: 1,
            sequence,
            force_return,
            duration: choices.duration.unwrap_or(case.defaults.duration_s),
            solver,
            wall_limit: None,
        })
    }
}

/// Options of the schemes from their names; the gain is left to its default.
///
/// # Errors
/// [`Error::UnknownName`] with all names.
pub fn scheme_options(
    redundancy: Option<&str>,
    motion: Option<&str>,
    solver: &'static SolverEntry,
) -> Result<SchemeOptions> {
    let redundancy = match redundancy.unwrap_or("drop") {
        "drop" => Redundancy::Drop,
        "pseudo-inverse" => Redundancy::PseudoInverse,
        "regularised" => Redundancy::Regularised { epsilon: REGULARISATION },
        other => return Err(Error::unknown("redundancy", other, ["drop", "pseudo-inverse", "regularised"])),
    };
    let motion = motion.map(str::parse).transpose()?.unwrap_or_default();
    Ok(SchemeOptions { redundancy, motion, ..SchemeOptions::of(solver) })
}
