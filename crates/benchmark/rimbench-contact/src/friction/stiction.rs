//! A coefficient at rest above that in motion.

use super::ContactState;

/// Coefficients of friction where they differ: which of them holds in a step is history.
///
/// ```text
/// μ of a step = μ_s  if the contact carried load in the solution of the step before and stood still along the surface
///               μ_k  if it slid, was open or carried nothing
/// ```
/// Within a step the law is Coulomb's with one coefficient per contact, so nothing else changes. A contact that lets go
/// slides through the step in which it does with `μ_s`, and from the next on with `μ_k`: an error of the first order in
/// the step, as that of the instant.
/// # Source
/// Ours; the two coefficients are Coulomb's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiction {
    /// μ_s, at least that in motion.
    pub at_rest: f64,
    /// μ_k ≥ 0.
    pub in_motion: f64,
}

impl Stiction {
    /// Returns μ of the step that follows one in which the contact did this.
    #[inline]
    pub fn after(self, state: ContactState) -> f64 {
        if state == ContactState::Stick { self.at_rest } else { self.in_motion }
    }

    /// Writes the coefficients of the step that follows one that ends in these states, moving by `w_t` (m/s), which is
    /// rounding up to `rounding` (m/s).
    pub fn update(self, friction: &mut [f64], states: &[ContactState], w_t: impl Iterator<Item = f64>, rounding: f64) {
        for ((coefficient, state), w_t) in friction.iter_mut().zip(states).zip(w_t) {
            *coefficient = self.after(state.moving(w_t, rounding));
        }
    }
}
