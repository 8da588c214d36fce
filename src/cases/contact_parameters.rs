//! The contact law as parameters, shared by the contact cases.

use super::parameters::{Parameter, Parameters, Range, number};
use crate::mechanics::ContactLaw;

const OURS: &str = "ours";

pub(super) const fn margin(default: f64) -> Parameter {
    number(
        "contact_margin_m",
        "m",
        default,
        Range::NotNegative,
        "a contact with gap ≤ margin counts as closed at t_k",
        OURS,
    )
}

pub(super) const STABILISATION: Parameter =
    number("stabilisation", "-", 0.2, Range::Fraction, "fraction γ of a penetration removed per mechanics step", OURS);

pub(super) const fn restitution(default: f64, source: &'static str) -> Parameter {
    number("restitution", "-", default, Range::Fraction, "restitution e of the mechanics' contacts", source)
}

/// The contact law as the parameters say.
pub(super) fn law(parameters: &Parameters) -> ContactLaw {
    ContactLaw {
        stabilisation: parameters.number("stabilisation"),
        restitution: parameters.number("restitution"),
        contact_margin: parameters.number("contact_margin_m"),
    }
}
