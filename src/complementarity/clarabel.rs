//! The problem as a quadratic program for a general interior-point solver: the outside opinion.
//!
//! ```text
//! min ½ zᵀ M z + qᵀ z   subject to   z ≥ 0           optimality: w = M z + q ≥ 0, zᵀ w = 0
//! ```
//! The program is scaled to unit diagonal and unit `q`, given to Clarabel with its tolerances far below the defaults,
//! and what comes back is used as it is, apart from cutting impulses below zero to zero. Nothing is polished: an
//! interior point leaves `z_i w_i ≈ μ > 0` everywhere, so where a contact is degenerate (`z_i = w_i = 0`) the answer is
//! only good to `√μ`. That is why the accepted residual is larger than for the pivoting solvers.
//!
//! # Source
//! Goulart, Chen, *Clarabel: an interior-point solver for conic programs with quadratic objectives* (2024).

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};

use super::{ComplementaritySolver, Lcp, SolveStats};
use crate::error::Failure;

/// Gap and feasibility asked of Clarabel, on the scaled program.
const TOLERANCE: f64 = 1e-12;

/// Interior-point solver. See the module for the program and its accuracy.
///
/// Guaranteed for symmetric positive semidefinite `M` when a solution exists. Allocates at every problem.
#[derive(Debug, Clone, Default)]
pub struct Clarabel {}

impl Clarabel {
    /// Builds the solver; it keeps nothing between problems.
    pub fn new() -> Self {
        Clarabel {}
    }
}

impl ComplementaritySolver for Clarabel {
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Failure> {
        let n = lcp.size();
        z.fill(0.0);
        if lcp.is_solved_by_zero()? {
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        let unsolved = Failure::SolverFailed { residual: f64::INFINITY };
        let scale: Vec<f64> = (0..n)
            .map(|i| match lcp.m[i * n + i] {
                m_ii if m_ii > 0.0 => 1.0 / m_ii.sqrt(),
                _ => 1.0,
            })
            .collect();
        let q_max = scale.iter().zip(lcp.q).fold(f64::MIN_POSITIVE, |max, (s, q)| max.max((s * q).abs()));
        let q: Vec<f64> = scale.iter().zip(lcp.q).map(|(s, q)| s * q / q_max).collect();

        // Upper triangle by columns; M is symmetric, so column j of it is the head of row j.
        let starts = (0..=n).map(|j| j * (j + 1) / 2).collect();
        let rows = (0..n).flat_map(|j| 0..=j).collect();
        let values = (0..n).flat_map(|j| (0..=j).map(move |i| (i, j)));
        let values = values.map(|(i, j)| scale[i] * lcp.m[j * n + i] * scale[j]).collect();
        let p = CscMatrix::new(n, n, starts, rows, values);
        let minus_identity = CscMatrix::new(n, n, (0..=n).collect(), (0..n).collect(), vec![-1.0; n]);
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: TOLERANCE,
            tol_gap_rel: TOLERANCE,
            tol_feas: TOLERANCE,
            ..DefaultSettings::default()
        };
        let cones = [NonnegativeConeT(n)];
        let mut solver =
            DefaultSolver::new(&p, &q, &minus_identity, &vec![0.0; n], &cones, settings).map_err(|_| unsolved)?;
        solver.solve();
        let stats = SolveStats { pivots: solver.solution.iterations, ..SolveStats::default() };
        // Short of the tolerance the point may still do; the residual decides.
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress => {}
            _ => return Err(unsolved),
        }
        for ((z, s), x) in z.iter_mut().zip(&scale).zip(&solver.solution.x) {
            *z = (s * q_max * x).max(0.0);
        }
        Ok(stats)
    }

    fn boxed_clone(&self) -> Box<dyn ComplementaritySolver> {
        Box::new(self.clone())
    }
}
