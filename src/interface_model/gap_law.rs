//! The gap law, used alike by the mechanics and by the models made from it.

/// Velocity by which a contact must at least open, or may at most close, in one step.
///
/// ```text
/// 0 ≤ w⁺ + max(g, 0)/h_open + γ·min(g, 0)/h_closed ⟂ P ≥ 0
/// ```
/// An open contact may use up its gap within `h_open`; a penetration `−g` decays by the fraction γ within `h_closed`.
/// The mechanics uses its own step for both. A model that tracks the gap opens and closes at the actuator's micro step
/// but lets a penetration decay as slowly as the mechanics does.
/// # Shapes and units
/// `gap` m; `h_open`, `h_closed` s; returns m/s.
/// # Source
/// Ours.
#[inline]
pub fn gap_velocity(gap: f64, h_open: f64, h_closed: f64, stabilisation: f64) -> f64 {
    if gap > 0.0 { gap / h_open } else { stabilisation * gap / h_closed }
}
