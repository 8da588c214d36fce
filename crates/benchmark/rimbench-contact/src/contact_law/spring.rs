//! Compliant contacts: an implicit spring and damper per contact, as interactive simulators have them.

use super::gap::GapRates;

/// A contact that gives way.
///
/// ```text
/// overlapping, g ≤ 0     P = h max(0, −k g⁺ − c w⁺)          0 ≤ w⁺ + k g/(h k + c) + P/(h (h k + c)) ⟂ P ≥ 0
/// open, g > 0            P = h max(0, −(k + c/h) g⁺)         0 ≤ w⁺ + g/h           + P/(h (h k + c)) ⟂ P ≥ 0
/// g⁺ = g + h w⁺
/// ```
/// The complementarity problem of the rigid contact, with `k/(h k + c)` for `γ/h` and something on the diagonal of
/// `H_uu`, so that the forces of redundant contacts are unique. A resting contact is slightly penetrated. Simulators
/// make such contacts on overlap; ours are there beforehand, and of an open one the damper takes only what it goes too
/// far. With the first line for both, it would push as soon as `g < c |w|/k`, millimetres before anything touches.
/// # Shapes and units
/// `stiffness` k, N/m, above 0; `damping` c, N·s/m; gaps m; steps s.
/// # Source
/// Implicit Euler on spring and damper; in interactive simulators usually given as constraint force mixing and error
/// reduction. What open contacts do is ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSpring {
    /// k, N/m.
    pub stiffness: f64,
    /// c, N·s/m.
    pub damping: f64,
}

impl ContactSpring {
    /// Returns the gap term as rates over a step `h` (s).
    #[inline]
    pub fn gap_rates(self, h: f64) -> GapRates {
        GapRates { open: 1.0 / h, closed: self.stiffness / (h * self.stiffness + self.damping) }
    }

    /// Returns what a step `step` adds to the diagonal of `H_uu` where the law is that of a step `h`,
    /// `1/(step (h k + c))`, 1/kg.
    #[inline]
    pub fn diagonal(self, step: f64, h: f64) -> f64 {
        1.0 / (step * (h * self.stiffness + self.damping))
    }

    /// Returns the energy stored at a gap, `½ k min(g, 0)²`, J.
    #[inline]
    pub fn energy(self, gap: f64) -> f64 {
        0.5 * self.stiffness * gap.min(0.0) * gap.min(0.0)
    }

    /// Returns the energy that the damper takes in a step `h` from `gap` with velocity `w` at its end, J: the work of
    /// the `impulse` less the spring's; where nothing presses, the energy that the spring still held.
    #[inline]
    pub fn loss(self, impulse: f64, gap: f64, w: f64, h: f64) -> f64 {
        let after = gap + h * w;
        if impulse > 0.0 {
            -w * (impulse + h * self.stiffness * after.min(0.0))
        } else {
            self.energy(gap) - self.energy(after)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_penetration_that_nothing_presses_goes_to_the_damper() {
        let spring = ContactSpring { stiffness: 1e4, damping: 0.0 };
        approx::assert_relative_eq!(spring.loss(0.0, -1e-3, 10.0, 1e-3), 0.5 * 1e4 * 1e-6, max_relative = 1e-12);
        assert_eq!(spring.loss(0.0, 1e-3, 10.0, 1e-3), 0.0);
    }
}
