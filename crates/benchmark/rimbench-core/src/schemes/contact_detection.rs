//! Which contacts a reduced interface model takes as closed at a communication point, as an option.

use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// Contact detection: where the model's set of contacts comes from, and which law they follow.
///
/// ```text
/// active          c = {α : row α was at its bound in the mechanics' last step}     0 ≤ w_c⁺ ⟂ P_c ≥ 0
/// mechanics-law   c = all        0 ≤ w_c⁺ + max(g, 0)/h + γ min(g, 0)/h ⟂ P_c ≥ 0      g as at t_k, h the mechanics' own step
/// margin:ε        c = {α : g_α ≤ ε}                                                0 ≤ w_c⁺ ⟂ P_c ≥ 0
/// ```
/// A model that makes contacts bilateral puts `=` for `≥` and leaves `P` free.
/// # Source
/// The paper has one contact set and one law for mechanics (Eq. 3) and model (Eq. 4); each of these is one way to read
/// that. See `docs/method/contact-detection.md`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ContactDetection {
    /// The contacts that the mechanics' own last step found closed. Nothing to choose.
    #[default]
    Active,
    /// All contacts, with the law of the mechanics' own next step.
    MechanicsLaw,
    /// Gaps up to a width.
    Margin {
        /// ε, m.
        width: f64,
    },
}

/// The rule of a scheme that detects contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectionRule {
    /// Used unless another is asked for.
    pub default: ContactDetection,
    /// Whether its contacts obey a complementarity condition, at `t_k` at least, in which a law can stand.
    pub has_law: bool,
}

impl fmt::Display for ContactDetection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ContactDetection::Active => f.write_str("active"),
            ContactDetection::MechanicsLaw => f.write_str("mechanics-law"),
            ContactDetection::Margin { width } => write!(f, "margin:{width:e}"),
        }
    }
}

impl FromStr for ContactDetection {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text.split_once(':') {
            None if text == "active" => Ok(ContactDetection::Active),
            None if text == "mechanics-law" => Ok(ContactDetection::MechanicsLaw),
            Some(("margin", number)) => number
                .parse()
                .ok()
                .filter(|width: &f64| width.is_finite() && *width >= 0.0)
                .map(|width| ContactDetection::Margin { width })
                .ok_or_else(|| {
                    Error::invalid("contact_detection", text, "margin:<m> with a finite width in metres, not below 0")
                }),
            _ => Err(Error::unknown("contact detection", text, ["active", "mechanics-law", "margin:<m>"])),
        }
    }
}
