//! The contact law over a step: gap term, impact and compliance, the parts of `b` and of the diagonal of `H` that are
//! not free motion.
//!
//! ```text
//! 0 ≤ w⁺ + t(g) ⟂ P ≥ 0        t = g/h of an open contact, γ g/h of a penetrated one; e w⁻ of one that rebounds
//! ```

mod gap;
mod rebounds;
mod spring;

pub use gap::{GapRates, discretisation_approach, gap_velocity, is_hit, landing_velocity, rounding_velocity};
pub use rebounds::{ImpactRows, ImpactStep, Rebounds, Solved};
pub use spring::ContactSpring;
