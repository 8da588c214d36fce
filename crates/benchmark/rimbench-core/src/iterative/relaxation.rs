//! From one guess of the coupling variables to the next.

use nalgebra::DVector;

/// Aitken's relaxation, with one factor for all variables.
///
/// ```text
/// x: guess     G(x): what comes back     r = G(x) − x, sought: r = 0
/// x_{n+1} = x_n + ω_n r_n         ω_n = −(Δx · Δr)/(Δr · Δr),   Δ: last minus the one before,  ω_0 = 1
/// ```
/// It is the usual recursion `ω_n = −ω_{n−1} (r_{n−1} · Δr)/(Δr · Δr)` with `Δx = ω_{n−1} r_{n−1}` put in, and stays
/// right where a guess was drawn back. For one variable it is the secant rule.
/// # Source
/// Irons, Tuck 1969; Küttler, Wall, *Fixed-point fluid–structure interaction solvers with dynamic relaxation*, Comput.
/// Mech. 43 (2008).
#[derive(Debug, Clone, Default)]
pub(super) struct Relaxation {
    /// The last guess of the macro step that led somewhere, and its residual, in units of each variable's size.
    last: Option<(DVector<f64>, DVector<f64>)>,
}

impl Relaxation {
    /// Returns the next guess after `x` had the residual `r`.
    pub(super) fn next(&mut self, x: DVector<f64>, r: DVector<f64>) -> DVector<f64> {
        let next = match &self.last {
            Some((x_before, r_before)) => {
                let (dx, dr) = (&x - x_before, &r - r_before);
                let square = dr.norm_squared();
                // A residual that does not move says nothing about the factor.
                let factor = if square > 0.0 { -dx.dot(&dr) / square } else { 1.0 };
                &x + factor * &r
            }
            None => &x + &r,
        };
        self.last = Some((x, r));
        next
    }

    /// Returns the last guess that led somewhere.
    pub(super) fn last_guess(&self) -> Option<&DVector<f64>> {
        self.last.as_ref().map(|(x, _)| x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals of the iterates of `G(x) = j x + b` until one is 0.
    fn residuals(j: f64, b: f64) -> Vec<f64> {
        let mut relaxation = Relaxation::default();
        let mut x = DVector::zeros(1);
        let mut residuals = Vec::new();
        while residuals.last() != Some(&0.0) && residuals.len() < 100 {
            let r = j * &x - &x + DVector::from_element(1, b);
            residuals.push(r.amax());
            x = relaxation.next(x, r);
        }
        residuals
    }

    #[test]
    fn aitken_finds_the_fixed_point_of_a_scalar_linear_problem_in_two_steps() {
        // G(x) = −3 x + 8, x* = 2; plain iteration diverges. x₀ = 0: r₀ = 8, x₁ = 8: r₁ = −24, ω₁ = −8·(−32)/32² = ¼,
        // x₂ = 8 − 24/4 = 2. Sums of small integers and powers of two: no rounding, so equality is meant.
        assert_eq!(residuals(-3.0, 8.0), [8.0, 24.0, 0.0]);
    }

    #[test]
    fn a_residual_that_stays_the_same_must_not_divide_by_zero() {
        // G(x) = x + 1 has no fixed point.
        assert!(residuals(1.0, 1.0).iter().all(|residual| residual.is_finite()));
    }
}
