//! Where a quantity that is known with its rate at both ends of a step vanishes within it.

/// A cubic over `0 ≤ t ≤ length` through values and rates at both ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HermiteCubic {
    /// Coefficients of `x⁰ … x³`, `x = t/length`.
    coefficients: [f64; 4],
    length: f64,
}

impl HermiteCubic {
    /// Puts a cubic through `[value, rate]` at the start and at the end, `length` (s) apart.
    pub(super) fn new(start: [f64; 2], end: [f64; 2], length: f64) -> Self {
        let ([g0, w0], [g1, w1]) = (start, end);
        let (rise0, rise1) = (length * w0, length * w1);
        let coefficients = [g0, rise0, 3.0 * (g1 - g0) - 2.0 * rise0 - rise1, 2.0 * (g0 - g1) + rise0 + rise1];
        HermiteCubic { coefficients, length }
    }

    fn at(&self, x: f64) -> f64 {
        let [c0, c1, c2, c3] = self.coefficients;
        c0 + x * (c1 + x * (c2 + x * c3))
    }

    /// The ends of the pieces over which it rises or falls: 0, what lies between in order, 1.
    fn pieces(&self) -> [f64; 4] {
        let [_, c1, c2, c3] = self.coefficients;
        // c1 + 2 c2 x + 3 c3 x² = 0, in the form that loses no digits; what is not a number is not inside.
        let root = (c2 * c2 - 3.0 * c1 * c3).sqrt();
        let q = -(c2 + root.copysign(c2));
        let [a, b] = [q / (3.0 * c3), c1 / q].map(|x| if x > 0.0 && x < 1.0 { x } else { 0.0 });
        [0.0, a.min(b), a.max(b), 1.0]
    }

    /// Returns when it first falls below zero, s; where it starts below, when it first falls at all. None: not within
    /// the length.
    pub(super) fn first_fall(&self) -> Option<f64> {
        let pieces = self.pieces();
        pieces.windows(2).find_map(|piece| {
            let (from, to) = (piece[0], piece[1]);
            let (high, low) = (self.at(from), self.at(to));
            if !(to > from && low < high && low < 0.0) {
                return None;
            }
            Some(self.length * if high > 0.0 { self.root(from, to) } else { from })
        })
    }

    /// Returns when it first changes its sign, s; none if it does not, or starts at zero.
    pub(super) fn first_change(&self) -> Option<f64> {
        let start = self.at(0.0);
        let pieces = self.pieces();
        let changed = |piece: &&[f64]| self.at(piece[1]) * start < 0.0;
        pieces.windows(2).find(changed).map(|piece| self.length * self.root(piece[0], piece[1]))
    }

    /// The zero between `from` and `to`, where it has two signs and does not turn.
    fn root(&self, mut from: f64, mut to: f64) -> f64 {
        let falls = self.at(from) > self.at(to);
        // Halving: after 60 times nothing is left of the step.
        for _ in 0..60 {
            let middle = 0.5 * (from + to);
            if (self.at(middle) > 0.0) == falls {
                from = middle;
            } else {
                to = middle;
            }
        }
        to
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cubic of a polynomial with these coefficients over a length.
    fn of(polynomial: [f64; 4], length: f64) -> HermiteCubic {
        let value = |t: f64| polynomial[0] + t * (polynomial[1] + t * (polynomial[2] + t * polynomial[3]));
        let rate = |t: f64| polynomial[1] + t * (2.0 * polynomial[2] + 3.0 * t * polynomial[3]);
        HermiteCubic::new([value(0.0), rate(0.0)], [value(length), rate(length)], length)
    }

    #[test]
    fn a_fall_is_found_where_the_polynomial_has_its_first_zero() {
        // A ball: g = 1 + 2t − 3t², zero at t = 1.
        approx::assert_relative_eq!(of([1.0, 2.0, -3.0, 0.0], 4.0).first_fall().unwrap(), 1.0, epsilon = 1e-14);
        // Linear.
        approx::assert_relative_eq!(of([1.0, -4.0, 0.0, 0.0], 1.0).first_fall().unwrap(), 0.25, epsilon = 1e-14);
        // (t − 1)(t − 2)(t − 3) from t = 1.5: positive, falls through 2, comes back at 3.
        let shifted = of([0.375, -0.25, -1.5, 1.0], 2.0);
        approx::assert_relative_eq!(shifted.first_fall().unwrap(), 0.5, epsilon = 1e-13);
        // It never falls, or never so far.
        assert_eq!(of([1.0, 1.0, 0.0, 0.0], 1.0).first_fall(), None);
        assert_eq!(of([1.0, -1.0, 0.5, 0.0], 2.0).first_fall(), None);
    }

    #[test]
    fn what_starts_below_zero_falls_when_it_turns() {
        // −0.1 + t − t² has its top of 0.15 at 0.5 and crosses zero after it; −1 + t − t² never gets there and turns at
        // 0.5.
        let crossing = 0.5 + 0.15_f64.sqrt();
        approx::assert_relative_eq!(of([-0.1, 1.0, -1.0, 0.0], 2.0).first_fall().unwrap(), crossing, epsilon = 1e-14);
        approx::assert_relative_eq!(of([-1.0, 1.0, -1.0, 0.0], 2.0).first_fall().unwrap(), 0.5, epsilon = 1e-14);
        assert_eq!(of([-1.0, -1.0, 0.0, 0.0], 2.0).first_fall(), Some(0.0));
    }

    #[test]
    fn a_change_of_sign_is_found_in_both_directions() {
        approx::assert_relative_eq!(of([-1.0, 2.0, 0.0, 0.0], 1.0).first_change().unwrap(), 0.5, epsilon = 1e-14);
        approx::assert_relative_eq!(of([1.0, -2.0, 0.0, 0.0], 1.0).first_change().unwrap(), 0.5, epsilon = 1e-14);
        assert_eq!(of([1.0, 2.0, 0.0, 0.0], 1.0).first_change(), None);
        assert_eq!(of([0.0, 2.0, 0.0, 0.0], 1.0).first_change(), None);
    }
}
