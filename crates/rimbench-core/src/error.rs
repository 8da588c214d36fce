//! The two ways things go wrong that are not our bug: bad input ([`Error`]) and a run that fails ([`Failure`]).
//!
//! `Error` is written for the person who typed the input: what was found, where, what would be valid. It ends the
//! command with exit code 2. `Failure` is written for a table: a run that diverged or left the validity of a model is
//! a result, kept with its reason. A panic is neither; it is a defect of rimbench.

use std::fmt;
use std::path::{Path, PathBuf};

/// Bad input: what was wrong, where, and what would be valid.
#[derive(Debug)]
pub enum Error {
    /// A name that is in no list.
    UnknownName {
        /// What the name should have named, for example `scheme`.
        kind: &'static str,
        /// What was found.
        found: String,
        /// Every valid name.
        valid: Vec<String>,
    },
    /// A key whose value is outside what is valid.
    InvalidValue {
        /// The key, option or parameter.
        key: String,
        /// The value as it was given.
        found: String,
        /// What would be valid.
        expected: String,
    },
    /// Two things that each exist but do not go together.
    Incompatible(String),
    /// Rows that must be independent are not.
    Singular(String),
    /// A file that cannot be used.
    File {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong with it, and where in it.
        message: String,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::UnknownName { kind, found, valid } => {
                write!(f, "unknown {kind} `{found}`{}; valid: {}", did_you_mean(found, valid), valid.join(", "))
            }
            Error::InvalidValue { key, found, expected } => {
                write!(f, "{key} = {found} is not valid; valid: {expected}")
            }
            Error::Incompatible(message) | Error::Singular(message) => f.write_str(message),
            Error::File { path, message } => write!(f, "{}: {message}", path.display()),
        }
    }
}

impl std::error::Error for Error {}

impl Error {
    /// Builds [`Error::UnknownName`] from any list of names.
    pub fn unknown<'a>(kind: &'static str, found: &str, valid: impl IntoIterator<Item = &'a str>) -> Self {
        let valid = valid.into_iter().map(str::to_owned).collect();
        Error::UnknownName { kind, found: found.to_owned(), valid }
    }

    /// Builds [`Error::InvalidValue`].
    pub fn invalid(key: impl Into<String>, found: impl fmt::Display, expected: impl Into<String>) -> Self {
        Error::InvalidValue { key: key.into(), found: found.to_string(), expected: expected.into() }
    }

    /// Builds [`Error::File`].
    pub fn file(path: impl AsRef<Path>, message: impl fmt::Display) -> Self {
        Error::File { path: path.as_ref().to_owned(), message: message.to_string() }
    }
}

/// Result of anything that reads input.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a run cannot go on. `Copy` and free of allocation, because it is born in the hot path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Failure {
    /// A state outside the validity of a model: piston at the end of its stroke, pressure beyond the fluid law.
    OutOfRange {
        /// The quantity, with its unit, for example `pressure_1_pa`.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// The complementarity problem could not be solved to its tolerance by the solver and its fallback.
    SolverFailed {
        /// Natural residual of the best answer.
        residual: f64,
    },
    /// A state or coupling variable that is not a finite number.
    NonFinite {
        /// The quantity.
        quantity: &'static str,
    },
    /// A matrix that must be positive definite is not (dependent bilateral rows, vanishing mass).
    Singular {
        /// Which matrix.
        matrix: &'static str,
    },
    /// The coupling variables of a macro step were not found by iteration.
    NotConverged {
        /// Largest relative residual of the last iteration.
        residual: f64,
        /// Iterations made.
        iterations: u32,
    },
    /// A step was to be taken on a copy, and a subsystem or the scheme has none to give.
    NotCopied,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::OutOfRange { quantity, value } => {
                write!(f, "{quantity} = {value:.6e} is outside the model's range")
            }
            Failure::SolverFailed { residual } => write!(f, "complementarity residual {residual:.3e} above tolerance"),
            Failure::NonFinite { quantity } => write!(f, "{quantity} is not finite"),
            Failure::Singular { matrix } => write!(f, "{matrix} is singular"),
            Failure::NotConverged { residual, iterations } => {
                write!(f, "relative interface residual {residual:.3e} after {iterations} iterations")
            }
            Failure::NotCopied => {
                f.write_str("a subsystem or the scheme cannot be copied, so no step can be taken again")
            }
        }
    }
}

/// Looks a name up in a list of entries, or explains which names are valid.
pub fn find_by_name<'a, T>(
    kind: &'static str,
    entries: &'a [T],
    name_of: impl Fn(&T) -> &str,
    wanted: &str,
) -> Result<&'a T> {
    entries
        .iter()
        .find(|entry| name_of(entry) == wanted)
        .ok_or_else(|| Error::unknown(kind, wanted, entries.iter().map(&name_of)))
}

/// Checks a name that is to be added to a list: kebab-case, and not in the list yet.
pub fn check_new_name<'a>(kind: &'static str, name: &str, mut taken: impl Iterator<Item = &'a str>) -> Result<()> {
    let word = |word: &str| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
    if !(name.starts_with(|c: char| c.is_ascii_lowercase()) && name.split('-').all(word)) {
        let expected = "kebab-case: lower-case letters and digits in words joined by single hyphens, a letter first";
        return Err(Error::invalid(format!("name of the {kind}"), format!("`{name}`"), expected));
    }
    if taken.any(|known| known == name) {
        return Err(Error::invalid(format!("name of the {kind}"), format!("`{name}`"), "a name that is not taken yet"));
    }
    Ok(())
}

fn did_you_mean(found: &str, valid: &[String]) -> String {
    let nearest = valid.iter().map(|name| (strsim::damerau_levenshtein(found, name), name)).min();
    match nearest {
        Some((distance, name)) if distance <= 1 + name.len() / 3 => format!(" (did you mean `{name}`?)"),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_name_suggests_the_nearest_and_lists_all() {
        let message = Error::unknown("scheme", "rim-nonsmoth", ["zero-order-hold", "rim-nonsmooth"]).to_string();
        assert_eq!(
            message,
            "unknown scheme `rim-nonsmoth` (did you mean `rim-nonsmooth`?); valid: zero-order-hold, rim-nonsmooth"
        );
    }

    #[test]
    fn a_name_that_resembles_nothing_gets_no_suggestion() {
        assert!(!Error::unknown("scheme", "qqqqqq", ["rim-smooth"]).to_string().contains("did you mean"));
    }
}
