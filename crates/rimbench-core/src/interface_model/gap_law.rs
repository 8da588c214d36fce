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

/// The gap law with both times fixed, for use in many steps of the same length: products instead of divisions.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GapRates {
    /// `1/h_open`, 1/s.
    pub open: f64,
    /// `γ/h_closed`, 1/s.
    pub closed: f64,
}

impl GapRates {
    /// Fixes `h_open`, `h_closed` (s) and γ.
    pub fn new(h_open: f64, h_closed: f64, stabilisation: f64) -> Self {
        GapRates { open: 1.0 / h_open, closed: stabilisation / h_closed }
    }

    /// The same as [`gap_velocity`] to round-off, m/s.
    #[inline]
    pub fn velocity(&self, gap: f64) -> f64 {
        gap * if gap > 0.0 { self.open } else { self.closed }
    }
}
