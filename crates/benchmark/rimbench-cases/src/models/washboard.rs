//! A floor that is flat up to a point and wavy from there on.

use std::f64::consts::TAU;

/// Height of the floor, `f(x) = ½ a (1 − cos(2π (x − x₀)/λ))` for `x > x₀`, else 0; slope and height join, the bend
/// does not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Washboard {
    start: f64,
    height: f64,
    wave_number: f64,
}

impl Washboard {
    /// Builds the floor from x₀ (m) and `[a, λ]` (m).
    pub fn new(start: f64, [height, length]: [f64; 2]) -> Self {
        Washboard { start, height, wave_number: TAU / length }
    }

    /// Tells whether there are waves at `x`.
    #[inline]
    pub fn is_wavy(&self, x: f64) -> bool {
        self.height != 0.0 && x > self.start
    }

    /// Returns height (m), slope, and second derivative (1/m) at `x`.
    #[inline]
    pub fn at(&self, x: f64) -> [f64; 3] {
        if !self.is_wavy(x) {
            return [0.0; 3];
        }
        let (sine, cosine) = libm::sincos(self.wave_number * (x - self.start));
        let half = 0.5 * self.height;
        [half * (1.0 - cosine), half * self.wave_number * sine, half * self.wave_number * self.wave_number * cosine]
    }
}
