//! How many steps of its own the mechanics takes per macro step.

use super::communication_grid::division;
use crate::error::{Error, Result};
use std::fmt;
use std::num::NonZeroU32;
use std::str::FromStr;

/// Plausibility bound, far beyond any use, so that a slip of the exponent is an error and not an endless run.
const MOST: u32 = 1_000_000;

/// The mechanics' own steps per macro step, n_m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MechanicsSteps {
    /// As many as this.
    Count(NonZeroU32),
    /// As many as the actuator side takes.
    AsActuator,
    /// As few equal ones as are no longer than this, s: a step of its own, however long the macro step is.
    AtMost(f64),
}

impl MechanicsSteps {
    /// One.
    pub const ONE: MechanicsSteps = MechanicsSteps::Count(NonZeroU32::MIN);

    /// Returns a count by number; none for zero.
    pub fn count(number: u32) -> Option<Self> {
        NonZeroU32::new(number).map(MechanicsSteps::Count)
    }

    /// Tells whether they are one in every macro step of at most this length, s.
    pub fn is_one_in(self, macro_step: f64) -> bool {
        match self {
            MechanicsSteps::AtMost(step) => division(macro_step, step) == 1,
            steps => steps == MechanicsSteps::ONE,
        }
    }

    /// Returns their longest length, s, where they are said by it.
    pub fn longest(self) -> Option<f64> {
        match self {
            MechanicsSteps::AtMost(step) => Some(step),
            MechanicsSteps::Count(_) | MechanicsSteps::AsActuator => None,
        }
    }

    /// Counts them in a macro step of this length, in which the micro steps of the actuator are no longer than
    /// `micro_step` (s).
    pub fn within(self, length: f64, micro_step: f64) -> usize {
        match self {
            MechanicsSteps::Count(count) => count.get() as usize,
            MechanicsSteps::AsActuator => division(length, micro_step),
            MechanicsSteps::AtMost(step) => division(length, step),
        }
    }

    /// Checks a longest step (s) of its own in macro steps of at most `macro_step` (s).
    ///
    /// # Errors
    /// [`Error::InvalidValue`], with what would be valid.
    pub fn check(self, macro_step: f64) -> Result<()> {
        let MechanicsSteps::AtMost(step) = self else { return Ok(()) };
        let expected = match step {
            _ if !(step.is_finite() && step > 0.0) => "a finite time above 0 s".to_owned(),
            _ if step > macro_step => format!("at most the macro step, {macro_step} s"),
            _ if macro_step / step > f64::from(MOST) => {
                format!("at least {:e} s for this macro step", macro_step / f64::from(MOST))
            }
            _ => return Ok(()),
        };
        Err(Error::invalid("mechanics_step_s", step, expected))
    }
}

impl fmt::Display for MechanicsSteps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MechanicsSteps::Count(count) => count.fmt(f),
            MechanicsSteps::AsActuator => f.write_str("all"),
            MechanicsSteps::AtMost(step) => write!(f, "of at most {step} s"),
        }
    }
}

impl FromStr for MechanicsSteps {
    type Err = Error;

    /// Reads a whole number from 1, or `all`.
    fn from_str(text: &str) -> Result<Self> {
        if text.trim() == "all" {
            return Ok(MechanicsSteps::AsActuator);
        }
        let count = text.trim().parse().ok().filter(|count| *count <= MOST);
        count.and_then(MechanicsSteps::count).ok_or_else(|| {
            let expected = format!("a whole number from 1 to {MOST}, or `all` for as many as the actuator takes");
            Error::invalid("mechanics_steps", text, expected)
        })
    }
}
