//! The contact law over the micro steps of a macro step.

use crate::contact_law::GapRates;

/// The contact law over the micro steps of a macro step.
#[derive(Debug, Clone, Copy, Default)]
pub struct StepContactLaw {
    /// The gap law.
    pub rates: GapRates,
    /// ∂g/∂w of a micro step, s: δ, or 0 where gaps are frozen.
    pub gap_step: f64,
    /// Restitution of contacts that close within `closing_time` (s).
    pub restitution: f64,
    /// Time within which a contact that is hit closes, s.
    pub closing_time: f64,
}

impl StepContactLaw {
    /// Returns the gap term of a row, m/s: tangential rows, which come after those with gaps, have none.
    #[inline(always)]
    pub(super) fn gap_term(&self, gap: &[f64], row: usize) -> f64 {
        gap.get(row).map_or(0.0, |gap| self.rates.velocity(*gap))
    }

    /// Tells whether a contact moves further in than its gap term and `tolerance` allow.
    #[inline]
    pub(super) fn is_violated(&self, w: &[f64], gap: &[f64], tolerance: f64) -> bool {
        let mut violated = false;
        for (w, gap) in w.iter().zip(gap) {
            violated |= w + self.rates.velocity(*gap) < -tolerance;
        }
        violated
    }

    /// Tells whether a contact that rebounds closes within the micro step.
    #[inline]
    pub(super) fn closes(&self, w: &[f64], gap: &[f64], rounding: f64) -> bool {
        w.iter().zip(gap).any(|(&w, &gap)| w < -rounding && gap + self.closing_time * w <= 0.0)
    }

    /// Returns the part of `r` of a contact that decays by `decay` in each micro step: `−δ (γ/h)² g / ρ` of one that is
    /// penetrated, m/s.
    #[inline]
    pub(super) fn decaying_part(&self, decay: f64, gap: f64) -> f64 {
        let decays = gap < 0.0 && decay > 0.0;
        if decays { -self.gap_step * self.rates.closed.powi(2) * gap / decay } else { 0.0 }
    }
}
