//! The associated law as a conic program, for Clarabel: the outside opinion on contacts with friction in space.
//!
//! ```text
//! min ½ Pᵀ H P + cᵀ P   subject to   |P_t| ≤ μ P_n
//! ```
//! With `c = b` this relaxes Coulomb's law: a contact that slides lifts off with `μ |w_t|`. With `c = b + s`,
//! `s_n = μ |w_t|` of Coulomb's own answer, that answer solves it, and its velocities are unique.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SecondOrderConeT, SolverStatus, SupportedConeT};
use rimbench::friction::space::SpaceProblem;

/// Returns the impulses, N·s; none where Clarabel has none.
pub fn relaxed_cones(problem: SpaceProblem<'_>, c: &[f64]) -> Option<Vec<f64>> {
    let (n, size, h) = (problem.contacts(), c.len(), problem.delassus.h);
    let scale = (0..size).map(|i| h[i * size + i]).fold(f64::MIN_POSITIVE, f64::max);
    let unit = c.iter().fold(f64::MIN_POSITIVE, |most, c| most.max(c.abs()));
    let starts = (0..=size).map(|j| j * (j + 1) / 2).collect();
    let upper = (0..size).flat_map(|j| (0..=j).map(move |i| h[j * size + i] / scale)).collect();
    let p = CscMatrix::new(size, size, starts, (0..size).flat_map(|j| 0..=j).collect(), upper);
    let q: Vec<f64> = c.iter().map(|c| c / unit).collect();
    // Rows contact by contact, columns all normal ones first.
    let row = |column: usize| 3 * (column % n) + column / n;
    let values = (0..size).map(|column| if column < n { -problem.cone.friction[column] } else { -1.0 }).collect();
    let a = CscMatrix::new(size, size, (0..=size).collect(), (0..size).map(row).collect(), values);
    let cones: Vec<SupportedConeT<f64>> = (0..n).map(|_| SecondOrderConeT(3)).collect();
    let tight = 1e-13;
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: tight,
        tol_gap_rel: tight,
        tol_feas: tight,
        ..Default::default()
    };
    let mut solver = DefaultSolver::new(&p, &q, &a, &vec![0.0; size], &cones, settings).ok()?;
    solver.solve();
    let found = matches!(
        solver.solution.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress
    );
    found.then(|| solver.solution.x.iter().map(|x| x * unit / scale).collect())
}
