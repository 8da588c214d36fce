//! Why a solver has no answer.

use std::fmt;

/// Says why a solver has no answer. Small, as it is returned in the hot path, before the fallback.
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
        /// Number of contacts.
        size: usize,
    },
}

impl fmt::Display for Unsolved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Unsolved::NotFound { residual } => write!(f, "complementarity residual {residual:.3e} above tolerance"),
            Unsolved::NonFinite => f.write_str("complementarity problem is not finite"),
            Unsolved::TooLarge { size } => {
                write!(
                    f,
                    "contacts of a complementarity problem = {size:.6e} is outside the model's range",
                    size = *size as f64
                )
            }
        }
    }
}

impl std::error::Error for Unsolved {}
