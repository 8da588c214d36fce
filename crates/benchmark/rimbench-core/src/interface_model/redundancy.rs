//! The treatment of dependent contacts, as an option.

use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// Relative compliance of `regularised` where no number is given.
const USUAL_COMPLIANCE: f64 = 1e-8;

/// Treatment of the case that the contacts that become bilateral are dependent (`H_cc` singular).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Redundancy {
    /// Keep a largest independent subset, found by pivoted Cholesky; the dependent rows drop out.
    #[default]
    Drop,
    /// Moore–Penrose inverse of `H_cc`: spreads an inconsistent contact velocity over the redundant rows.
    PseudoInverse,
    /// `(H_cc + ε tr(H_cc)/n_c)⁻¹`: compliant contacts; ε is dimensionless.
    Regularised {
        /// Relative compliance ε > 0.
        epsilon: f64,
    },
}

impl fmt::Display for Redundancy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Redundancy::Drop => f.write_str("drop"),
            Redundancy::PseudoInverse => f.write_str("pseudo-inverse"),
            Redundancy::Regularised { epsilon } => write!(f, "regularised:{epsilon:e}"),
        }
    }
}

impl FromStr for Redundancy {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text.split_once(':') {
            None if text == "drop" => Ok(Redundancy::Drop),
            None if text == "pseudo-inverse" => Ok(Redundancy::PseudoInverse),
            None if text == "regularised" => Ok(Redundancy::Regularised { epsilon: USUAL_COMPLIANCE }),
            Some(("regularised", number)) => number
                .parse()
                .ok()
                .filter(|epsilon: &f64| epsilon.is_finite() && *epsilon > 0.0)
                .map(|epsilon| Redundancy::Regularised { epsilon })
                .ok_or_else(|| {
                    Error::invalid("redundancy", text, "regularised:<compliance> with a finite compliance above 0")
                }),
            _ => Err(Error::unknown("redundancy", text, ["drop", "pseudo-inverse", "regularised:<compliance>"])),
        }
    }
}
