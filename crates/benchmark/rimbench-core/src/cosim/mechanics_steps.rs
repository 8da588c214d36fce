//! How many steps of its own the mechanics takes per macro step.

use crate::error::{Error, Result};
use std::fmt;
use std::num::NonZeroU32;
use std::str::FromStr;

/// Plausibility bound, far beyond any use, so that a slip of the exponent is an error and not an endless run.
const MOST: u32 = 1_000_000;

/// The mechanics' own steps per macro step, n_m.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MechanicsSteps {
    /// As many as this.
    Count(NonZeroU32),
    /// As many as the actuator side takes.
    AsActuator,
}

impl MechanicsSteps {
    /// One.
    pub const ONE: MechanicsSteps = MechanicsSteps::Count(NonZeroU32::MIN);

    /// Returns a count by number; none for zero.
    pub fn count(number: u32) -> Option<Self> {
        NonZeroU32::new(number).map(MechanicsSteps::Count)
    }
}

impl fmt::Display for MechanicsSteps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MechanicsSteps::Count(count) => count.fmt(f),
            MechanicsSteps::AsActuator => f.write_str("all"),
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
            Error::invalid("mechanics-steps", text, expected)
        })
    }
}
