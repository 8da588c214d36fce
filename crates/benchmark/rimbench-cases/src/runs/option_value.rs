//! Values of options, as a file or the command line gives them.

use rimbench_core::cosim::{
    ActuatorIntegrator, Channel, ForceBridge, ForceReturn, LateRule, MassLearning, MechanicsIntegrator, MechanicsSteps,
    Sequence, StepControl, TrialSettings,
};
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::{Belief, Redundancy};
use rimbench_core::schemes::{ContactDetection, ContactsAct, FrictionRows, ModelMotion, Split};
use std::fmt;

/// A value as a file or the command line gives it.
#[derive(Debug, Clone, PartialEq)]
pub enum Given {
    /// A word, or what is still to be read as one value or another.
    Text(String),
    /// A number; a time is in seconds.
    Number(f64),
}

impl From<f64> for Given {
    fn from(number: f64) -> Self {
        Given::Number(number)
    }
}

impl<T: AsRef<str> + ?Sized> From<&T> for Given {
    fn from(text: &T) -> Self {
        Given::Text(text.as_ref().to_owned())
    }
}

impl fmt::Display for Given {
    /// Writes a number as the shortest text that reads back to the same bits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Given::Text(text) => f.write_str(text),
            Given::Number(number) => write!(f, "{number:?}"),
        }
    }
}

/// The value of an option.
pub(super) trait OptionValue: Sized {
    fn read(key: &str, given: Given) -> Result<Self>;

    fn write(&self) -> Given;
}

impl OptionValue for String {
    fn read(_key: &str, given: Given) -> Result<Self> {
        Ok(given.to_string())
    }

    fn write(&self) -> Given {
        Given::from(self)
    }
}

impl OptionValue for f64 {
    fn read(key: &str, given: Given) -> Result<Self> {
        match given {
            Given::Number(number) => Ok(number),
            Given::Text(text) => text.trim().parse().map_err(|_| Error::invalid(key, text, "a number")),
        }
    }

    fn write(&self) -> Given {
        Given::Number(*self)
    }
}

/// What says itself what is wrong with a text.
macro_rules! read_by_name {
    ($($kind:ty),+) => {
        $(impl OptionValue for $kind {
            fn read(_key: &str, given: Given) -> Result<Self> {
                given.to_string().parse()
            }

            fn write(&self) -> Given {
                Given::Text(self.to_string())
            }
        })+
    };
}

read_by_name!(
    Sequence,
    ForceReturn,
    MechanicsSteps,
    MechanicsIntegrator,
    ActuatorIntegrator,
    Redundancy,
    ModelMotion,
    ContactDetection,
    Split,
    FrictionRows,
    ContactsAct,
    Channel,
    LateRule,
    ForceBridge,
    Belief,
    MassLearning,
    TrialSettings,
    StepControl
);
