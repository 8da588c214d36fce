//! Why a solver has no answer.

use crate::error::{Cause, Failure};
use std::fmt;

/// Why a solver has no answer. Small and copied freely: a proposal that fails is replaced by the fallback's, in the hot path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unsolved {
    /// The algorithm ended without an answer, or with one that is not good enough.
    NotFound {
        /// Natural residual of the best answer; `+inf` without one.
        residual: f64,
    },
    /// The problem, or the answer, is not finite.
    NonFinite,
    /// The solver refuses problems of this size.
    TooLarge {
        /// Number of contacts n.
        size: usize,
    },
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

impl fmt::Display for Unsolved {
    /// Writes what the failure of a step would say.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Failure::from(*self).fmt(f)
    }
}

impl std::error::Error for Unsolved {}
