//! Values of options, as a file or the command line gives them.

use rimbench_core::error::{Error, Result};
use std::fmt;

/// A value as a file or the command line gives it.
#[derive(Debug, Clone, PartialEq)]
pub enum Given {
    /// A word, or what is still to be read as one value or another.
    Text(String),
    /// A number; a time is in seconds.
    Number(f64),
}

impl Given {
    /// Reads a number, of the option `key`.
    pub(super) fn number(&self, key: &str) -> Result<f64> {
        match self {
            Given::Number(number) => Ok(*number),
            Given::Text(text) => text.trim().parse().map_err(|_| Error::invalid(key, text, "a number")),
        }
    }
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
