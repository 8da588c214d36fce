//! How a run ended. Every outcome but a stop is data: it stands in the table with its reason.
//!
//! ```text
//! Outcome        what happened, with when and why       of one run
//! OutcomeKind    its name in data                       read back from a table
//! OutcomeClass   what it says of the coupling           the one classification; no other place compares names
//! ```

use crate::error::{Cause, Failure};
use crate::name::{Name, by_name};
use std::fmt;

/// What a run that ended so says of its coupling.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum OutcomeClass {
    /// It holds: the run reached its end within bounds.
    Completed,
    /// It does not hold: the run left its bounds or its models, or could not be solved.
    Failed,
    /// Nothing: the run took longer than it may, was stopped or not begun, or the program failed.
    NoAnswer,
}

/// An outcome by its name in data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum OutcomeKind {
    /// [`Outcome::Completed`].
    Completed,
    /// [`Outcome::Diverged`].
    Diverged,
    /// [`Outcome::OutOfRange`].
    OutOfRange,
    /// [`Outcome::SolverFailed`].
    SolverFailed,
    /// [`Outcome::SubsystemFailed`].
    SubsystemFailed,
    /// [`Outcome::SchemeFailed`].
    SchemeFailed,
    /// [`Outcome::Timeout`].
    Timeout,
    /// [`Outcome::Stopped`].
    Stopped,
    /// [`Outcome::Panicked`].
    Panicked,
    /// [`Outcome::Skipped`].
    Skipped,
}

impl OutcomeKind {
    /// All of them by name.
    pub const NAMES: [(&'static str, OutcomeKind); 10] = [
        ("completed", OutcomeKind::Completed),
        ("diverged", OutcomeKind::Diverged),
        ("out-of-range", OutcomeKind::OutOfRange),
        ("solver-failed", OutcomeKind::SolverFailed),
        ("subsystem-failed", OutcomeKind::SubsystemFailed),
        ("scheme-failed", OutcomeKind::SchemeFailed),
        ("timeout", OutcomeKind::Timeout),
        ("stopped", OutcomeKind::Stopped),
        ("panicked", OutcomeKind::Panicked),
        ("skipped", OutcomeKind::Skipped),
    ];

    /// Returns the name in data.
    pub const fn name(self) -> &'static str {
        Self::NAMES[self as usize].0
    }

    /// Says what it counts as.
    pub fn class(self) -> OutcomeClass {
        match self {
            OutcomeKind::Completed => OutcomeClass::Completed,
            OutcomeKind::Diverged
            | OutcomeKind::OutOfRange
            | OutcomeKind::SolverFailed
            | OutcomeKind::SubsystemFailed
            | OutcomeKind::SchemeFailed => OutcomeClass::Failed,
            OutcomeKind::Timeout | OutcomeKind::Stopped | OutcomeKind::Panicked | OutcomeKind::Skipped => {
                OutcomeClass::NoAnswer
            }
        }
    }

    /// Tells whether anything was run: what was skipped is counted in no share.
    pub fn was_run(self) -> bool {
        self != OutcomeKind::Skipped
    }
}

by_name!(OutcomeKind, NAMES, "outcome");

impl OutcomeClass {
    /// All of them by name.
    pub const NAMES: [(&'static str, OutcomeClass); 3] = [
        ("completed", OutcomeClass::Completed),
        ("failed", OutcomeClass::Failed),
        ("no-answer", OutcomeClass::NoAnswer),
    ];
}

by_name!(OutcomeClass, NAMES, "class of an outcome");

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// Ran to the end with every interface quantity within bounds.
    Completed,
    /// An interface quantity became non-finite or went beyond its bound (three times its reference maximum).
    Diverged {
        /// When, s.
        at_s: f64,
        /// Which quantity.
        quantity: Name,
        /// Its value.
        value: f64,
    },
    /// A state left the validity of its model.
    OutOfRange {
        /// When, s.
        at_s: f64,
        /// Which quantity.
        quantity: Name,
        /// Its value.
        value: f64,
    },
    /// A complementarity problem, a factorisation or the iteration over a macro step failed.
    SolverFailed {
        /// When, s.
        at_s: f64,
        /// Why.
        cause: Cause,
    },
    /// A subsystem said that it cannot go on, or withdrew what the scheme needs.
    SubsystemFailed {
        /// When, s.
        at_s: f64,
        /// Why.
        cause: Cause,
    },
    /// A scheme from outside said that it cannot go on, or gave what is no input.
    SchemeFailed {
        /// When, s.
        at_s: f64,
        /// Why.
        cause: Cause,
    },
    /// The run took longer than it was allowed to.
    Timeout {
        /// Simulated time reached, s.
        at_s: f64,
    },
    /// The run was asked to end. No result: it is never stored.
    Stopped {
        /// Simulated time reached, s.
        at_s: f64,
    },
    /// The program failed: a defect of rimbench, kept as a record.
    Panicked {
        /// What it said.
        message: String,
    },
    /// Not run, because case and scheme do not go together.
    Skipped {
        /// Why not.
        reason: String,
    },
}

impl Outcome {
    /// Makes the outcome of a run that `failure` ended at `at_s`.
    pub fn from_failure(failure: Failure, at_s: f64) -> Self {
        match failure.into_cause() {
            Cause::OutOfRange { quantity, value } => Outcome::OutOfRange { at_s, quantity, value },
            Cause::NonFinite { quantity } => Outcome::Diverged { at_s, quantity, value: f64::NAN },
            cause @ (Cause::SolverFailed { .. } | Cause::Singular { .. } | Cause::NotConverged { .. }) => {
                Outcome::SolverFailed { at_s, cause }
            }
            cause @ Cause::NotCopied => Outcome::Skipped { reason: cause.to_string() },
            // Missing from the start: the run is skipped. Missing later: it has failed.
            cause @ Cause::NotOffered { .. } if at_s == 0.0 => Outcome::Skipped { reason: cause.to_string() },
            cause @ (Cause::NotOffered { .. } | Cause::Reported { .. }) => Outcome::SubsystemFailed { at_s, cause },
            cause @ Cause::SchemeReported { .. } => Outcome::SchemeFailed { at_s, cause },
            Cause::Stopped => Outcome::Stopped { at_s },
        }
    }

    /// Returns what stands of it in a table: its name.
    pub fn kind(&self) -> OutcomeKind {
        match self {
            Outcome::Completed => OutcomeKind::Completed,
            Outcome::Diverged { .. } => OutcomeKind::Diverged,
            Outcome::OutOfRange { .. } => OutcomeKind::OutOfRange,
            Outcome::SolverFailed { .. } => OutcomeKind::SolverFailed,
            Outcome::SubsystemFailed { .. } => OutcomeKind::SubsystemFailed,
            Outcome::SchemeFailed { .. } => OutcomeKind::SchemeFailed,
            Outcome::Timeout { .. } => OutcomeKind::Timeout,
            Outcome::Stopped { .. } => OutcomeKind::Stopped,
            Outcome::Panicked { .. } => OutcomeKind::Panicked,
            Outcome::Skipped { .. } => OutcomeKind::Skipped,
        }
    }

    /// Returns the kebab-case name in data.
    pub fn name(&self) -> &'static str {
        self.kind().name()
    }

    /// Says what it counts as.
    pub fn class(&self) -> OutcomeClass {
        self.kind().class()
    }

    /// Says when the run left the path of [`Outcome::Completed`], s.
    pub fn at_s(&self) -> Option<f64> {
        match self {
            Outcome::Completed | Outcome::Skipped { .. } | Outcome::Panicked { .. } => None,
            Outcome::Diverged { at_s, .. }
            | Outcome::OutOfRange { at_s, .. }
            | Outcome::SolverFailed { at_s, .. }
            | Outcome::SubsystemFailed { at_s, .. }
            | Outcome::SchemeFailed { at_s, .. }
            | Outcome::Timeout { at_s }
            | Outcome::Stopped { at_s } => Some(*at_s),
        }
    }

    /// Returns the reason in words; empty for a completed run.
    pub fn reason(&self) -> String {
        match self {
            Outcome::Completed => String::new(),
            Outcome::Diverged { quantity, value, .. } if value.is_finite() => {
                format!("{quantity} reached {value:.4e}, beyond 3 times the reference maximum")
            }
            Outcome::Diverged { quantity, .. } => Cause::NonFinite { quantity: quantity.clone() }.to_string(),
            Outcome::OutOfRange { quantity, value, .. } => {
                Cause::OutOfRange { quantity: quantity.clone(), value: *value }.to_string()
            }
            Outcome::SolverFailed { cause, .. }
            | Outcome::SubsystemFailed { cause, .. }
            | Outcome::SchemeFailed { cause, .. } => cause.to_string(),
            Outcome::Timeout { .. } => "wall-time limit".to_owned(),
            Outcome::Stopped { .. } => Cause::Stopped.to_string(),
            Outcome::Panicked { message } => format!("defect of rimbench: {message}"),
            Outcome::Skipped { reason } => reason.clone(),
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.at_s() {
            Some(at_s) => write!(f, "{} at {at_s:.6} s ({})", self.name(), self.reason()),
            None if matches!(self, Outcome::Completed) => f.write_str(self.name()),
            None => write!(f, "{} ({})", self.name(), self.reason()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_outcome_has_one_name_and_counts_as_one_thing() {
        use OutcomeClass::{Completed, Failed, NoAnswer};
        let (at_s, quantity, value) = (0.1, Name::from("force"), 1.0);
        let cause = Cause::Stopped;
        let all = [
            (Outcome::Completed, "completed", Completed),
            (Outcome::Diverged { at_s, quantity: quantity.clone(), value }, "diverged", Failed),
            (Outcome::OutOfRange { at_s, quantity, value }, "out-of-range", Failed),
            (Outcome::SolverFailed { at_s, cause: cause.clone() }, "solver-failed", Failed),
            (Outcome::SubsystemFailed { at_s, cause: cause.clone() }, "subsystem-failed", Failed),
            (Outcome::SchemeFailed { at_s, cause }, "scheme-failed", Failed),
            (Outcome::Timeout { at_s }, "timeout", NoAnswer),
            (Outcome::Stopped { at_s }, "stopped", NoAnswer),
            (Outcome::Panicked { message: String::new() }, "panicked", NoAnswer),
            (Outcome::Skipped { reason: String::new() }, "skipped", NoAnswer),
        ];
        assert_eq!(all.len(), OutcomeKind::NAMES.len());
        for (outcome, name, class) in all {
            assert_eq!((outcome.name(), outcome.class()), (name, class));
            assert_eq!(name.parse::<OutcomeKind>().unwrap(), outcome.kind());
            assert_eq!(outcome.kind().to_string(), name);
            assert_eq!(outcome.kind().was_run(), name != "skipped");
        }
        let message = "Completed".parse::<OutcomeKind>().unwrap_err().to_string();
        assert!(message.contains("`Completed`") && message.contains("subsystem-failed"), "{message}");
    }
}
