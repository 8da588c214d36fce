//! The problem in velocities: Gauss' principle of least constraint for the interior-point solver.
//!
//! Among all velocities that do not penetrate, the true one is nearest (in kinetic energy) to the velocity without
//! contacts. With `M = B Bᵀ`, `x` the velocity change in mass-weighted coordinates that contacts can cause at all:
//!
//! ```text
//! min ½ xᵀ x   subject to   B x + q ≥ 0              optimality: x = Bᵀ z, z ≥ 0 the multipliers, w = B x + q
//! ```
//! As many unknowns as `M` has rank, and a unique one: redundant contacts cost constraints, not unknowns. A simulation
//! would take `B = A_u M_bodies^{-1/2}`; a problem that knows only `M` and `q` gets `B` from a pivoted Cholesky factor,
//! which is the same up to a rotation of `x`. Rows whose pivot is below 1e-11 of their diagonal count as dependent.
//!
//! # Source
//! Moreau, *Quadratic programming in mechanics: dynamics of one-sided constraints*, SIAM J. Control 4 (1966).

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSolver, IPSolver, NonnegativeConeT};

use super::clarabel::{has_answer, scaling, settings};
use rimbench_core::complementarity::{ComplementaritySolver, Lcp, SolveStats, Unsolved};

/// A row of the scaled matrix is dependent if what is left of its diagonal is below this.
const DEPENDENT: f64 = 1e-11;

/// Interior-point solver on the velocity form. See the module.
///
/// Guaranteed for symmetric positive semidefinite `M` if some impulses open every contact. Allocates at every problem.
#[derive(Default)]
pub struct ClarabelVelocity {
    /// For problems of the last size and rank.
    kept: Option<([usize; 2], DefaultSolver<f64>)>,
}

impl ClarabelVelocity {
    /// Builds the solver.
    pub fn new() -> Self {
        ClarabelVelocity::default()
    }

    /// The solver object for `−B x + s = q`; `None` if Clarabel refuses the data.
    fn with_data(&mut self, n: usize, minus_b: Vec<f64>, q: &[f64]) -> Option<&mut DefaultSolver<f64>> {
        let rank = minus_b.len() / n.max(1);
        match self.kept.take_if(|(size, _)| *size == [n, rank]) {
            Some((size, mut solver)) => {
                solver.update_A(&minus_b).ok()?;
                solver.update_b(&q.to_vec()).ok()?;
                Some(&mut self.kept.insert((size, solver)).1)
            }
            None => {
                let identity = CscMatrix::new(rank, rank, (0..=rank).collect(), (0..rank).collect(), vec![1.0; rank]);
                let starts = (0..=rank).map(|column| column * n).collect();
                let rows = (0..rank).flat_map(|_| 0..n).collect();
                let minus_b = CscMatrix::new(n, rank, starts, rows, minus_b);
                let cones = [NonnegativeConeT(n)];
                let solver = DefaultSolver::new(&identity, &vec![0.0; rank], &minus_b, q, &cones, settings()).ok()?;
                Some(&mut self.kept.insert(([n, rank], solver)).1)
            }
        }
    }
}

/// `−B` by columns, `M ≈ B Bᵀ`: Cholesky with the largest remaining diagonal first, until none is above [`DEPENDENT`].
fn minus_root(mut m: Vec<f64>, n: usize) -> Vec<f64> {
    let mut minus_b = Vec::new();
    for _ in 0..n {
        let Some(k) = (0..n).max_by(|&i, &j| m[i * n + i].total_cmp(&m[j * n + j])) else { break };
        let pivot = m[k * n + k];
        if pivot <= DEPENDENT {
            break;
        }
        let column: Vec<f64> = (0..n).map(|i| m[i * n + k] / pivot.sqrt()).collect();
        for i in 0..n {
            for j in 0..n {
                m[i * n + j] -= column[i] * column[j];
            }
        }
        // What is eliminated is zero, not almost.
        for i in 0..n {
            (m[i * n + k], m[k * n + i]) = (0.0, 0.0);
        }
        minus_b.extend(column.iter().map(|b| -b));
    }
    minus_b
}

/// The copy sets its own object up; the answers do not depend on which object gives them.
impl Clone for ClarabelVelocity {
    fn clone(&self) -> Self {
        ClarabelVelocity::new()
    }
}

impl ComplementaritySolver for ClarabelVelocity {
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let n = lcp.size();
        z.fill(0.0);
        if lcp.is_solved_by_zero()? {
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        let unsolved = || Unsolved::NotFound { residual: f64::INFINITY };
        let (scale, unit) = scaling(lcp);
        let q: Vec<f64> = scale.iter().zip(lcp.q).map(|(s, q)| s * q / unit).collect();
        let scaled = (0..n * n).map(|k| scale[k / n] * lcp.m[k] * scale[k % n]).collect();
        let minus_b = minus_root(scaled, n);
        // No contact can cause any velocity, and some q is negative.
        if minus_b.is_empty() {
            return Err(unsolved());
        }
        let solver = self.with_data(n, minus_b, &q).ok_or_else(unsolved)?;
        solver.solve();
        let stats = SolveStats { pivots: solver.solution.iterations, factorisations: 1, ..SolveStats::default() };
        if !has_answer(solver.solution.status) {
            return Err(unsolved());
        }
        for ((z, s), multiplier) in z.iter_mut().zip(&scale).zip(&solver.solution.z) {
            *z = (s * unit * multiplier).max(0.0);
        }
        Ok(stats)
    }

    fn boxed_clone(&self) -> Box<dyn ComplementaritySolver> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_has_as_many_columns_as_the_matrix_has_rank() {
        let m = vec![1.0, 1.0, 0.5, 1.0, 1.0, 0.5, 0.5, 0.5, 1.0];
        let minus_b = minus_root(m.clone(), 3);
        assert_eq!(minus_b.len(), 6);
        for (k, entry) in m.iter().enumerate() {
            let product: f64 = minus_b.chunks(3).map(|column| column[k / 3] * column[k % 3]).sum();
            assert!((product - entry).abs() < 1e-15);
        }
        assert!(minus_root(vec![0.0; 4], 2).is_empty());
    }
}
