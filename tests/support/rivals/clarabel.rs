//! The problem as a quadratic program for a general interior-point solver: the outside opinion.
//!
//! ```text
//! min ½ Pᵀ H P + bᵀ P   subject to   P ≥ 0           optimality: w = H P + b ≥ 0, Pᵀ w = 0
//! ```
//! What comes back is used as it is, apart from cutting impulses below zero to zero. Nothing is polished: an interior
//! point leaves `P_i w_i ≈ μ > 0` everywhere, so a contact that is degenerate (`P_i = w_i = 0` in every solution) is
//! only found to the square root of the gap:
//!
//! ```text
//! gap = Pᵀ w          min(H_ii P_i, w_i)² ≤ H_ii P_i w_i          natural residual r ≤ √(max H_ii · gap) / ‖b‖_∞
//! ```
//! Hence the program is written in variables that give it a unit diagonal, with `‖b‖_∞ / √(max H_ii)` as unit, in which
//! this reads `r ≤ √gap`, and the gap asked for is the square of the accepted residual, 1e-14. A residual of 1e-9,
//! which pivoting solvers are held to, would take a gap below the rounding of the objective. The linear systems are
//! refined until that no longer helps: Clarabel stops at 1e-12 by itself, no better than the feasibility asked for, and
//! goes back and forth where contacts are redundant.
//!
//! A body clamped without play has no velocity that opens all its contacts, and its impulses are unbounded: no central
//! path, so no guarantee. Some of these problems end with impulses of 1e10 and more, which the residual rejects.
//!
//! The solver object, with its symbolic factorisation, is kept as long as `n` stays the same, and only the numbers are
//! replaced. Clarabel's own scaling of the data, which would remember those of the first problem, is switched off; ours
//! takes its place. An interior point has no use for the answer to the last problem.
//!
//! # Source
//! Goulart, Chen, *Clarabel: an interior-point solver for conic programs with quadratic objectives* (2024).

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use rimbench::complementarity::{ComplementaritySolver, Lcp, SolveStats, Unsolved};

/// Gap asked of Clarabel, on the scaled program: the square of the residual accepted in the list of solvers.
const GAP: f64 = 1e-14;
/// Feasibility asked of Clarabel; it enters the residual as it is.
const FEASIBILITY: f64 = 1e-12;

/// What is asked of Clarabel.
fn settings() -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        tol_gap_abs: GAP,
        // Of the objective; a smaller gap cannot be told.
        tol_gap_rel: f64::EPSILON,
        tol_feas: FEASIBILITY,
        // Until it no longer helps.
        iterative_refinement_abstol: 0.0,
        iterative_refinement_reltol: 0.0,
        // Both would stand in the way of replacing the data.
        presolve_enable: false,
        equilibrate_enable: false,
        ..DefaultSettings::default()
    }
}

/// True if the point Clarabel ended at is worth a look; short of the tolerance it may still do, and the residual
/// decides.
fn has_answer(status: SolverStatus) -> bool {
    matches!(status, SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress)
}

/// `1/√H_ii` (1 where there is none) from the diagonal, and `‖b‖_∞ / √(max H_ii)`: the units in which the root of the
/// gap bounds the residual.
fn scaling(diagonal: impl Iterator<Item = f64>, b: &[f64]) -> (Vec<f64>, f64) {
    let inverse_root = |m_ii: f64| if m_ii > 0.0 { 1.0 / m_ii.sqrt() } else { 1.0 };
    let scale: Vec<f64> = diagonal.map(inverse_root).collect();
    let b_max = b.iter().fold(f64::MIN_POSITIVE, |max, b| max.max(b.abs()));
    let unit = b_max * scale.iter().copied().fold(f64::INFINITY, f64::min);
    (scale, unit)
}

/// Interior-point solver. See the module for the program and its accuracy.
///
/// Guaranteed for symmetric positive semidefinite `H` if some impulses open every contact. Allocates at every problem.
#[derive(Default)]
pub struct Clarabel {
    /// For problems of the last size.
    kept: Option<(usize, DefaultSolver<f64>)>,
}

impl Clarabel {
    /// The solver object with the data of a program of size `n`; `None` if Clarabel refuses them.
    fn with_data(&mut self, n: usize, values: Vec<f64>, b: &[f64]) -> Option<&mut DefaultSolver<f64>> {
        let solver = match self.kept.take_if(|(kept, _)| *kept == n) {
            Some((_, mut solver)) => {
                solver.update_P(&values).ok()?;
                solver.update_q(&b.to_vec()).ok()?;
                solver
            }
            None => {
                // Upper triangle by columns.
                let starts = (0..=n).map(|j| j * (j + 1) / 2).collect();
                let p = CscMatrix::new(n, n, starts, (0..n).flat_map(|j| 0..=j).collect(), values);
                let minus_identity = CscMatrix::new(n, n, (0..=n).collect(), (0..n).collect(), vec![-1.0; n]);
                DefaultSolver::new(&p, b, &minus_identity, &vec![0.0; n], &[NonnegativeConeT(n)], settings()).ok()?
            }
        };
        Some(&mut self.kept.insert((n, solver)).1)
    }
}

/// The copy sets its own object up; the answers do not depend on which object gives them.
impl Clone for Clarabel {
    fn clone(&self) -> Self {
        Clarabel::default()
    }
}

impl ComplementaritySolver for Clarabel {
    fn attempt(&mut self, lcp: Lcp<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let n = lcp.size();
        impulses.fill(0.0);
        if lcp.is_solved_by_zero()? {
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        let (scale, unit) = scaling(lcp.h().iter().step_by(n + 1).copied(), lcp.b);
        // M is symmetric, so column j of its upper triangle is the head of row j.
        let values = (0..n).flat_map(|j| (0..=j).map(move |i| (i, j)));
        let values = values.map(|(i, j)| scale[i] * lcp.h()[j * n + i] * scale[j]).collect();
        let b: Vec<f64> = scale.iter().zip(lcp.b).map(|(s, b)| s * b / unit).collect();
        let unsolved = Unsolved::NotFound { residual: f64::INFINITY };
        let Some(solver) = self.with_data(n, values, &b) else { return Err(unsolved) };
        solver.solve();
        if !has_answer(solver.solution.status) {
            return Err(unsolved);
        }
        for ((p, s), x) in impulses.iter_mut().zip(&scale).zip(&solver.solution.x) {
            *p = (s * unit * x).max(0.0);
        }
        Ok(SolveStats { pivots: solver.solution.iterations, ..SolveStats::default() })
    }
}

/// Two bodies apart; the second contact is degenerate if nothing moves it (`q_2 = 0`).
#[test]
fn a_degenerate_contact_is_found_to_the_root_of_the_gap_and_any_other_to_the_gap() {
    let h = [4.0, 0.0, 0.0, 0.25];
    for gap in [1e-8, 1e-10, 1e-12, GAP] {
        let residual = |b: [f64; 2]| {
            let (mut solver, lcp, mut impulses) = (Clarabel::default(), Lcp::new(&h, &b), [0.0; 2]);
            solver.attempt(lcp, &mut impulses).unwrap();
            let asked = DefaultSettings { tol_gap_abs: gap, ..settings() };
            solver.kept.as_mut().unwrap().1.update_settings(asked).unwrap();
            solver.attempt(lcp, &mut impulses).unwrap();
            lcp.natural_residual(&impulses)
        };
        let (degenerate, strict) = (residual([-1.0, 0.0]), residual([-1.0, 1.0]));
        assert!(degenerate <= gap.sqrt() && degenerate > 0.01 * gap.sqrt(), "{gap}: {degenerate}");
        assert!(strict <= gap, "{gap}: {strict}");
    }
}
