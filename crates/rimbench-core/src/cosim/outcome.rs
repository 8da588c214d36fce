//! How a run ended. Every outcome but a stop is data: it stands in the table with its reason.

use crate::error::{Cause, Failure};
use crate::name::Name;
use std::fmt;

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
            // What was never there is no failure of the run.
            cause @ Cause::NotOffered { .. } if at_s == 0.0 => Outcome::Skipped { reason: cause.to_string() },
            cause @ (Cause::NotOffered { .. } | Cause::Reported { .. }) => Outcome::SubsystemFailed { at_s, cause },
            Cause::Stopped => Outcome::Stopped { at_s },
        }
    }

    /// Returns the kebab-case name in data.
    pub fn name(&self) -> &'static str {
        match self {
            Outcome::Completed => "completed",
            Outcome::Diverged { .. } => "diverged",
            Outcome::OutOfRange { .. } => "out-of-range",
            Outcome::SolverFailed { .. } => "solver-failed",
            Outcome::SubsystemFailed { .. } => "subsystem-failed",
            Outcome::Timeout { .. } => "timeout",
            Outcome::Stopped { .. } => "stopped",
            Outcome::Panicked { .. } => "panicked",
            Outcome::Skipped { .. } => "skipped",
        }
    }

    /// Says when the run left the path of [`Outcome::Completed`], s.
    pub fn at_s(&self) -> Option<f64> {
        match self {
            Outcome::Completed | Outcome::Skipped { .. } | Outcome::Panicked { .. } => None,
            Outcome::Diverged { at_s, .. }
            | Outcome::OutOfRange { at_s, .. }
            | Outcome::SolverFailed { at_s, .. }
            | Outcome::SubsystemFailed { at_s, .. }
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
            Outcome::SolverFailed { cause, .. } | Outcome::SubsystemFailed { cause, .. } => cause.to_string(),
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
