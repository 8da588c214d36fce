//! The two ways things go wrong that are not our bug: bad input ([`Error`]) and a run that fails ([`Failure`]).
//!
//! `Error` is written for the person at the input: what was found, where, what would be valid. It ends the
//! command with exit code 2. `Failure` is written for a table: a run that diverged or left the validity of a model is
//! a result, kept with its reason. A panic is neither; it is a defect of rimbench.

use rimbench_contact::complementarity::Unsolved;
use rimbench_contact::linear_algebra::Singular;
use std::borrow::Cow;
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
    /// No bad input at all: the program was asked to end what it was doing.
    Stopped,
    /// No bad input either: the reference took longer than a run may take.
    Overdue {
        /// How long that is, s.
        limit_s: f64,
    },
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
            Error::UnknownName { kind, found, valid } if valid.is_empty() => {
                write!(f, "unknown {kind} `{found}`: there is none here")
            }
            Error::UnknownName { kind, found, valid } => {
                let named = valid.iter().map(|name| if name.is_empty() { "\"\"" } else { name }).collect::<Vec<_>>();
                write!(f, "unknown {kind} `{found}`{}; valid: {}", did_you_mean(found, valid), named.join(", "))
            }
            Error::InvalidValue { key, found, expected } => {
                write!(f, "{key} = {found} is not valid; valid: {expected}")
            }
            Error::Incompatible(message) => f.write_str(message),
            Error::Stopped => f.write_str("stopped"),
            Error::Overdue { limit_s } => write!(f, "the reference took longer than wall_limit_s = {limit_s} s"),
            Error::File { path, message } if path.as_os_str().is_empty() => write!(f, "\"\": {message}"),
            Error::File { path, message } => write!(f, "{}: {message}", path.display()),
        }
    }
}

impl std::error::Error for Error {}

impl Error {
    /// Builds [`Error::UnknownName`] from any list of names. Of a long text only the beginning is repeated.
    pub fn unknown<'a>(kind: &'static str, found: &str, valid: impl IntoIterator<Item = &'a str>) -> Self {
        let valid = valid.into_iter().map(str::to_owned).collect();
        Error::UnknownName { kind, found: shortened(found), valid }
    }

    /// Builds [`Error::InvalidValue`]. Of a long text only the beginning is repeated.
    pub fn invalid(key: impl Into<String>, found: impl fmt::Display, expected: impl Into<String>) -> Self {
        let (key, found) = (shortened(&key.into()), shortened(&found.to_string()));
        // In quotes, or an empty text would not be seen in the message.
        let found = if found.trim().is_empty() { format!("{found:?}") } else { found };
        Error::InvalidValue { key, found, expected: with_short_numbers(&expected.into()) }
    }

    /// Builds [`Error::File`].
    pub fn file(path: impl AsRef<Path>, message: impl fmt::Display) -> Self {
        Error::File { path: path.as_ref().to_owned(), message: message.to_string() }
    }
}

/// Result of anything that reads input.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a run cannot go on.
///
/// Born in the hot path, but only where it ends: as small as a pointer, so that a step that goes well costs one
/// register and allocates nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure(Box<Cause>);

/// The cause of a [`Failure`].
#[derive(Debug, Clone, PartialEq)]
pub enum Cause {
    /// A state outside the validity of a model: piston at the end of its stroke, pressure beyond the fluid law.
    OutOfRange {
        /// The quantity, with its unit, for example `pressure_1_pa`.
        quantity: Cow<'static, str>,
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
        quantity: Cow<'static, str>,
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
    /// The scheme needs something of a subsystem that it does not offer, or no longer.
    NotOffered {
        /// What, for example `the mechanics offers no reduced interface model`.
        what: Cow<'static, str>,
    },
    /// A subsystem says in words that it cannot go on: a program of its own, or a foreign one.
    Reported {
        /// What it says.
        message: String,
    },
    /// A scheme from outside says in words that it cannot go on, or gives what is no input.
    SchemeReported {
        /// What it says, or what is wrong.
        message: String,
    },
    /// The run was asked to end.
    Stopped,
}

impl From<Cause> for Failure {
    #[cold]
    fn from(cause: Cause) -> Self {
        Failure(Box::new(cause))
    }
}

impl From<Unsolved> for Failure {
    #[cold]
    fn from(unsolved: Unsolved) -> Self {
        match unsolved {
            Unsolved::NotFound { residual } => Cause::SolverFailed { residual }.into(),
            Unsolved::NonFinite => Failure::non_finite("complementarity problem"),
            Unsolved::TooLarge { size } => Failure::out_of_range("contacts of a complementarity problem", size as f64),
        }
    }
}

impl From<Singular> for Failure {
    #[cold]
    fn from(Singular { matrix }: Singular) -> Self {
        Cause::Singular { matrix }.into()
    }
}

impl Failure {
    /// Builds [`Cause::NonFinite`].
    #[cold]
    pub fn non_finite(quantity: impl Into<Cow<'static, str>>) -> Self {
        Cause::NonFinite { quantity: quantity.into() }.into()
    }

    /// Builds [`Cause::OutOfRange`].
    #[cold]
    pub fn out_of_range(quantity: impl Into<Cow<'static, str>>, value: f64) -> Self {
        Cause::OutOfRange { quantity: quantity.into(), value }.into()
    }

    /// Builds [`Cause::Reported`], for a subsystem with a reason of its own.
    #[cold]
    pub fn reported(message: impl Into<String>) -> Self {
        Cause::Reported { message: message.into() }.into()
    }

    /// Tells whether the run was asked to end.
    pub fn is_stop(&self) -> bool {
        *self.0 == Cause::Stopped
    }

    /// Returns its cause.
    pub fn cause(&self) -> &Cause {
        &self.0
    }

    /// Returns its cause, to keep.
    pub fn into_cause(self) -> Cause {
        *self.0
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for Failure {}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Cause::OutOfRange { quantity, value } => {
                write!(f, "{quantity} = {value:.6e} is outside the model's range")
            }
            Cause::SolverFailed { residual } => write!(f, "complementarity residual {residual:.3e} above tolerance"),
            Cause::NonFinite { quantity } => write!(f, "{quantity} is not finite"),
            Cause::Singular { matrix } => write!(f, "{matrix} is singular"),
            Cause::NotConverged { residual, iterations } => {
                write!(f, "relative interface residual {residual:.3e} after {iterations} iterations")
            }
            Cause::NotCopied => {
                f.write_str("a subsystem or the scheme cannot be copied, so no step can be taken again")
            }
            Cause::NotOffered { what } => f.write_str(what),
            Cause::Reported { message } | Cause::SchemeReported { message } => f.write_str(message),
            Cause::Stopped => f.write_str("stopped"),
        }
    }
}

/// Characters of a text from outside that an error repeats.
const REPEATED: usize = 80;
/// Digits that a number may have before it is written with an exponent.
const DIGITS: usize = 20;

/// Returns the beginning of a text that came from outside, with its numbers short and its line ends visible, for an
/// error in one line.
pub fn shortened(text: &str) -> String {
    let text = with_short_numbers(text);
    let cut = match text.char_indices().nth(REPEATED) {
        Some((end, _)) => format!("{}… ({} characters)", &text[..end], text.chars().count()),
        None => text,
    };
    if cut.contains(char::is_control) { cut.escape_debug().to_string() } else { cut }
}

/// Says without the system's own number that a file is not there: the number helps nobody.
pub fn without_system_number(message: &str) -> String {
    message.replace("No such file or directory (os error 2)", "there is no such file")
}

/// Writes numbers of more than twenty digits with an exponent: `1e300` and not three hundred zeros.
pub fn with_short_numbers(text: &str) -> String {
    let numeric = |c: char| c.is_ascii_digit() || c == '.';
    let (mut short, mut rest) = (String::with_capacity(text.len().min(1000)), text);
    while let Some(start) = rest.find(numeric) {
        let length = rest[start..].find(|c| !numeric(c)).unwrap_or(rest.len() - start);
        let (before, number) = (&rest[..start], &rest[start..start + length]);
        short.push_str(before);
        match number.parse::<f64>() {
            Ok(value) if length > DIGITS && value.is_finite() => short.push_str(&format!("{value:e}")),
            _ => short.push_str(number),
        }
        rest = &rest[start + length..];
    }
    short + rest
}

fn did_you_mean(found: &str, valid: &[String]) -> String {
    // The empty name is close to every short word.
    let named = valid.iter().filter(|name| !name.is_empty());
    let nearest = named.map(|name| (strsim::damerau_levenshtein(found, name), name)).min();
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
    fn what_is_repeated_is_bounded_and_in_one_line() {
        for (error, wanted) in [
            (Error::invalid("gain", 1e300, "0 to 1"), "gain = 1e300 is not valid; valid: 0 to 1"),
            (Error::invalid("gain", "", "0 to 1"), "gain = \"\" is not valid"),
            (Error::invalid("gain", -1e-300, "0 to 1"), "gain = -1e-300 is not valid"),
            (Error::invalid("to", 5.0, format!("at least {} s", 1e200)), "valid: at least 1e200 s"),
            (Error::invalid("gain", 0.1 + 0.2, "0 to 1"), "gain = 0.30000000000000004 is"),
            (Error::invalid("label", "x\ny".repeat(100_000), "text"), "… (300000 characters)"),
            (Error::unknown("scheme", &"é".repeat(400_000), ["rim-smooth"]), "… (400000 characters)"),
        ] {
            let message = error.to_string();
            assert!(message.contains(wanted) && message.len() < 400 && message.lines().count() == 1, "{message}");
        }
    }

    #[test]
    fn a_name_that_resembles_nothing_gets_no_suggestion() {
        assert!(!Error::unknown("scheme", "qqqqqq", ["rim-smooth"]).to_string().contains("did you mean"));
        assert_eq!(Error::unknown("set", "x", ["", "mass=20"]).to_string(), "unknown set `x`; valid: \"\", mass=20");
    }
}
