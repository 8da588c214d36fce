//! Inputs as polynomials of the time since the communication point: what the extrapolating schemes send.

use crate::cosim::{Cubic, MicroStep};

/// The inputs of one side over a macro step.
///
/// ```text
/// u_i(t_k + τ) = Σ_p c_ip τ^p,   p = 0 … 3
/// mean over [a, a + δ], m = a + ½δ:   u(m) + δ²/24 ü(m) = u(m) + δ²/12 (c₂ + 3 c₃ m)
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct InputPolynomial {
    /// Highest power that is ever there: no more is worked out than that.
    degree: usize,
    pub(super) rows: Vec<Cubic>,
}

impl InputPolynomial {
    /// Makes room for polynomials up to a degree of 3 or less.
    pub(super) fn new(inputs: usize, degree: usize) -> Self {
        debug_assert!(degree <= 3);
        InputPolynomial { degree, rows: vec![[0.0; 4]; inputs] }
    }

    /// Takes polynomials whose coefficients beyond `degree` (at most 3) are zero. Of degree 0 they are inputs that are
    /// held.
    pub fn of(rows: Vec<Cubic>, degree: usize) -> Self {
        InputPolynomial { degree: degree.min(3), rows }
    }

    /// Takes others, whose coefficients beyond `degree` (at most 3) are zero.
    pub(super) fn set(&mut self, degree: usize, rows: impl Iterator<Item = Cubic>) {
        self.degree = degree;
        self.rows.iter_mut().zip(rows).for_each(|(row, new)| *row = new);
    }

    /// Writes the means over a micro step.
    #[inline]
    pub fn mean(&self, at: MicroStep, u: &mut [f64]) {
        let middle = at.since_exchange + 0.5 * at.length;
        let bend = at.length * at.length / 12.0;
        let rows = u.iter_mut().zip(&self.rows);
        match self.degree {
            0 => rows.for_each(|(u, [c0, ..])| *u = *c0),
            1 => rows.for_each(|(u, [c0, c1, ..])| *u = c0 + middle * c1),
            2 => rows.for_each(|(u, [c0, c1, c2, _])| *u = c0 + middle * (c1 + middle * c2) + bend * c2),
            _ => rows.for_each(|(u, [c0, c1, c2, c3])| {
                *u = c0 + middle * (c1 + middle * (c2 + middle * c3)) + bend * (c2 + 3.0 * c3 * middle);
            }),
        }
    }

    /// Writes the polynomials of the time since the start of a micro step. False, and nothing, for inputs that are
    /// held.
    pub fn within(&self, at: MicroStep, polynomials: &mut [Cubic]) -> bool {
        if self.degree == 0 {
            return false;
        }
        for (row, within) in self.rows.iter().zip(polynomials) {
            *within = shifted(*row, at.since_exchange);
        }
        true
    }
}

/// Shifts a polynomial to the time since `by`.
pub(super) fn shifted([c0, c1, c2, c3]: Cubic, by: f64) -> Cubic {
    [c0 + by * (c1 + by * (c2 + by * c3)), c1 + by * (2.0 * c2 + 3.0 * by * c3), c2 + 3.0 * by * c3, c3]
}

/// Returns the motion that meets position and velocity at both ends of a macro step: a cubic for the position, and its
/// slope for the velocity, so that the two never contradict each other.
///
/// ```text
/// s = s₀ + w₀ τ + A τ² + B τ³       A = (3 (s₁ − s₀)/H − 2 w₀ − w₁)/H       B = (w₀ + w₁ − 2 (s₁ − s₀)/H)/H²
/// ```
pub(super) fn hermite([s0, w0]: [f64; 2], [s1, w1]: [f64; 2], h: f64) -> [Cubic; 2] {
    let slope = (s1 - s0) / h;
    let (a, b) = ((3.0 * slope - 2.0 * w0 - w1) / h, (w0 + w1 - 2.0 * slope) / (h * h));
    [[s0, w0, a, b], [w0, 2.0 * a, 3.0 * b, 0.0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::MacroStep;

    const STEP: MacroStep = MacroStep { index: 3, start: 7.0, length: 2.0 };

    #[test]
    fn means_add_up_to_the_integral_and_shifted_polynomials_go_on() {
        let polynomials = InputPolynomial { degree: 3, rows: vec![[1.0, -2.0, 0.5, 3.0]] };
        let integral = |t: f64| t - t * t + 0.5 * t.powi(3) / 3.0 + 0.75 * t.powi(4);
        for j in 0..5 {
            let at = MicroStep::new(STEP, j, 5);
            let (mut mean, mut within) = ([0.0], [[0.0; 4]]);
            polynomials.mean(at, &mut mean);
            assert!(polynomials.within(at, &mut within));
            let (from, to) = (at.since_exchange, at.since_exchange + at.length);
            approx::assert_relative_eq!(mean[0], (integral(to) - integral(from)) / at.length, epsilon = 1e-12);
            let [c0, c1, c2, c3] = within[0];
            let x = 0.3;
            let t = from + x;
            let value = 1.0 - 2.0 * t + 0.5 * t * t + 3.0 * t.powi(3);
            approx::assert_relative_eq!(c0 + x * (c1 + x * (c2 + x * c3)), value, epsilon = 1e-12);
        }
    }

    #[test]
    fn the_hermite_motion_meets_both_ends_and_its_velocity_is_its_slope() {
        let [s, w] = hermite([1.0, 0.5], [2.0, -3.0], 0.4);
        let value = |c: Cubic, t: f64| c[0] + t * (c[1] + t * (c[2] + t * c[3]));
        approx::assert_relative_eq!(value(s, 0.4), 2.0, epsilon = 1e-13);
        approx::assert_relative_eq!(value(w, 0.4), -3.0, epsilon = 1e-12);
        assert_eq!((s[0], w[0]), (1.0, 0.5));
        assert_eq!([w[0], w[1], w[2]], [s[1], 2.0 * s[2], 3.0 * s[3]]);
    }
}
