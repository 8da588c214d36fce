//! From one guess of the coupling variables to the next.

use nalgebra::{DMatrix, DVector};

/// How an iteration over a macro step finds its next guess.
///
/// ```text
/// x: guess     G(x): what comes back     r = G(x) − x, sought: r = 0
///
/// aitken           x_{n+1} = x_n + ω_n r_n         ω_n = −(Δx · Δr)/(Δr · Δr),   Δ: last minus the one before,  ω_0 = 1
/// quasi-newton     x_{n+1} = x_n + W c + r_n       c = argmin ‖V c + r_n‖,   columns V_i = r_i − r_n, W_i = G(x_i) − G(x_n)
/// ```
/// Aitken's formula is the usual recursion `ω_n = −ω_{n−1} (r_{n−1} · Δr)/(Δr · Δr)` with `Δx = ω_{n−1} r_{n−1}` put in, and
/// stays right where a guess was drawn back. For one variable both are the secant rule. The quasi-Newton rule (IQN-ILS)
/// finds the solution of a linear problem of m variables with m + 1 evaluations of G.
/// # Source
/// Irons, Tuck 1969; Küttler, Wall, *Fixed-point fluid–structure interaction solvers with dynamic relaxation*, Comput. Mech.
/// 43 (2008). Degroote, Bathe, Vierendeels, *Performance of a new partitioned procedure versus a monolithic procedure in
/// fluid–structure interaction*, Comput. Struct. 87 (2009).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Acceleration {
    /// Dynamic relaxation with one factor for all variables.
    Aitken,
    /// Least squares over the last iterations of the same macro step.
    QuasiNewton,
}

/// Directions whose singular value is below this part of the largest are round-off.
const DEPENDENT: f64 = 1e-10;

/// The guesses of one macro step and what came of them, in units of each variable's size.
#[derive(Debug, Clone)]
pub(super) struct Accelerator {
    acceleration: Acceleration,
    /// Pairs (x, r), the last one last.
    history: Vec<(DVector<f64>, DVector<f64>)>,
}

impl Accelerator {
    pub(super) fn new(acceleration: Acceleration) -> Self {
        Accelerator { acceleration, history: Vec::new() }
    }

    /// The next guess after `x` had the residual `r`.
    pub(super) fn next(&mut self, x: DVector<f64>, r: DVector<f64>) -> DVector<f64> {
        // More differences than variables are more than a linear problem needs, and older than a curved one can use.
        let kept = match self.acceleration {
            Acceleration::Aitken => 1,
            Acceleration::QuasiNewton => x.len(),
        };
        let surplus = self.history.len().saturating_sub(kept);
        self.history.drain(..surplus);
        let step = match self.acceleration {
            Acceleration::Aitken => self.relaxed(&x, &r),
            Acceleration::QuasiNewton => self.least_squares(&x, &r),
        };
        let next = &x + step;
        self.history.push((x, r));
        next
    }

    /// The last guess that led somewhere.
    pub(super) fn last_guess(&self) -> Option<&DVector<f64>> {
        self.history.last().map(|(x, _)| x)
    }

    fn relaxed(&self, x: &DVector<f64>, r: &DVector<f64>) -> DVector<f64> {
        let Some((x_before, r_before)) = self.history.last() else { return r.clone() };
        let (dx, dr) = (x - x_before, r - r_before);
        let square = dr.norm_squared();
        // A residual that does not move says nothing about the factor.
        let factor = if square > 0.0 { -dx.dot(&dr) / square } else { 1.0 };
        factor * r
    }

    fn least_squares(&self, x: &DVector<f64>, r: &DVector<f64>) -> DVector<f64> {
        if self.history.is_empty() {
            return r.clone();
        }
        let columns = self.history.len();
        let v = DMatrix::from_fn(x.len(), columns, |row, column| self.history[column].1[row] - r[row]);
        let w = DMatrix::from_fn(x.len(), columns, |row, column| {
            let (x_i, r_i) = &self.history[column];
            (x_i[row] + r_i[row]) - (x[row] + r[row])
        });
        let svd = v.svd(true, true);
        let cut = DEPENDENT * svd.singular_values.max();
        match svd.solve(&-r, cut) {
            Ok(coefficients) => w * coefficients + r,
            Err(_) => r.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals of the iterates of `G(x) = J x + b` until one is below `tolerance`.
    fn iterate(acceleration: Acceleration, j: &DMatrix<f64>, b: &DVector<f64>, tolerance: f64) -> Vec<f64> {
        let mut accelerator = Accelerator::new(acceleration);
        let mut x = DVector::zeros(b.len());
        let mut residuals = Vec::new();
        while residuals.last().is_none_or(|last| *last > tolerance) && residuals.len() < 100 {
            let r = j * &x + b - &x;
            residuals.push(r.amax());
            x = accelerator.next(x, r);
        }
        residuals
    }

    #[test]
    fn aitken_finds_the_fixed_point_of_a_scalar_linear_problem_in_two_steps() {
        // G(x) = −3 x + 8, x* = 2; plain iteration diverges. x₀ = 0: r₀ = 8, x₁ = 8: r₁ = −24, ω₁ = −8·(−32)/32² = ¼,
        // x₂ = 8 − 24/4 = 2. Sums of small integers and powers of two: no rounding, so equality is meant.
        let (j, b) = (DMatrix::from_element(1, 1, -3.0), DVector::from_element(1, 8.0));
        assert_eq!(iterate(Acceleration::Aitken, &j, &b, 0.0), [8.0, 24.0, 0.0]);
    }

    #[test]
    fn quasi_newton_solves_a_linear_problem_of_m_variables_with_m_plus_one_evaluations() {
        for m in 1..=6 {
            // Diagonally dominant with gains up to −8: plain iteration diverges.
            let j = DMatrix::from_fn(m, m, |row, column| {
                if row == column { -2.0 - row as f64 } else { 0.3 * libm::sin((1 + row + 2 * column) as f64) }
            });
            let b = DVector::from_fn(m, |row, _| 1.0 + row as f64);
            let residuals = iterate(Acceleration::QuasiNewton, &j, &b, 1e-9);
            println!("m = {m}: {residuals:?}");
            // m + 1 evaluations, and one more that finds nothing left. Rounding of x is amplified by the gains, and once
            // more by the least squares: 1e-9 is far above 8² ε and far below any residual before the last.
            assert_eq!(residuals.len(), m + 2);
            assert!(residuals[m] > 1e-3 && residuals[m + 1] <= 1e-9);
        }
    }

    #[test]
    fn a_residual_that_stays_the_same_must_not_divide_by_zero() {
        for acceleration in [Acceleration::Aitken, Acceleration::QuasiNewton] {
            // G(x) = x + 1 has no fixed point.
            let (j, b) = (DMatrix::from_element(1, 1, 1.0), DVector::from_element(1, 1.0));
            assert!(iterate(acceleration, &j, &b, 0.0).iter().all(|residual| residual.is_finite()));
        }
    }
}
