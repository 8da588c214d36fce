//! Which contacts a reduced interface model takes along in a macro step, as an option.

use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// Which contacts take part within a macro step; those left out are chosen anew at each communication point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ContactChoice {
    /// All that the scheme wants.
    #[default]
    All,
    /// Without those that stay open in a prediction of the macro step.
    Near,
    /// Besides, without those that press but hardly move the interface; their predicted forces stay as loads.
    Coupled {
        /// Largest error of a diagonal entry of the interface's mobility (1/m_eff), as a part of `H_ii`.
        tolerance: f64,
    },
}

impl fmt::Display for ContactChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ContactChoice::All => f.write_str("all"),
            ContactChoice::Near => f.write_str("near"),
            ContactChoice::Coupled { tolerance } => write!(f, "coupled:{tolerance:e}"),
        }
    }
}

impl FromStr for ContactChoice {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text.split_once(':') {
            None if text == "all" => Ok(ContactChoice::All),
            None if text == "near" => Ok(ContactChoice::Near),
            Some(("coupled", number)) => number
                .parse()
                .ok()
                .filter(|tolerance: &f64| tolerance.is_finite() && *tolerance > 0.0)
                .map(|tolerance| ContactChoice::Coupled { tolerance })
                .ok_or_else(|| Error::invalid("contacts", text, "coupled:<tolerance> with a finite tolerance above 0")),
            _ => Err(Error::unknown("choice of contacts", text, ["all", "near", "coupled:<tolerance>"])),
        }
    }
}
