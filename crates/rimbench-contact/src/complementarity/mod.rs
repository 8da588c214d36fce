//! Linear complementarity problems: `w = M z + q`, `0 ≤ w ⟂ z ≥ 0`.
//!
//! `M` is symmetric positive semidefinite, and in mechanics with more contacts than degrees of freedom it is singular
//! as a rule (`M = H_uu = A_u G A_uᵀ`, 1/kg; `z` impulses, N·s; `w`, `q` velocities, m/s). Then `z` is not unique;
//! `w` and the resultant are.
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | `M` | matrix of the problem, n×n | 1/kg |
//! | `q` | velocities without contact impulse | m/s |
//! | `z`, `w` | impulses, velocities after them | N·s, m/s |
//! | `A` | active set: the indices with `w = 0` and `z ≥ 0` free | |
//! | `r` | natural residual, see [`natural_residual`] | |
//!
//! A solver only proposes a `z` ([`ComplementaritySolver::attempt`]); whether it is a solution is decided by
//! [`natural_residual`], the same for all of them. Simulations use [`Checked`], which also knows the fallback. A solver is
//! known by its [`SolverEntry`]; those that a program may choose from stand in its catalogue.

mod active_set;
mod checked;
mod entry;
mod lcp;
mod lemke;
mod lemke_tableau;
mod natural_residual;
mod problem_recorder;
mod proximal_guess;
mod solver;
mod sparse_active_set;
mod unsolved;

pub use active_set::ActiveSet;
pub use checked::{Checked, SolverCounters};
pub use entry::{BuildSolver, SolverEntry, standard_solvers};
pub use lcp::{ImpulseSet, Lcp};
pub use lemke::Lemke;
pub(crate) use lemke_tableau::LemkeTableau;
pub use natural_residual::natural_residual;
pub use problem_recorder::{ProblemRecorder, RecordedProblem};
pub use solver::Solver;
pub use sparse_active_set::SparseActiveSet;
pub use unsolved::Unsolved;

/// What a solver did.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SolveStats {
    /// Changes of the active set (or simplex pivots, or iterations of an iterative solver).
    pub pivots: u32,
    /// Factorisations from scratch.
    pub factorisations: u32,
    /// True if the fallback found the answer.
    pub fallback: bool,
    /// Natural residual, recomputed from `M`, `q`, `z` after the solve.
    pub residual: f64,
}

/// Solves linear complementarity problems of one size class, reusing its workspace.
///
/// Per problem: [`solve`](Self::solve), or [`attempt`](Self::attempt) and then [`natural_residual`]. Every solver
/// answers `z = 0` when `q ≥ 0`. [`reset`](Self::reset) when the next problem has nothing to do with the last.
pub trait ComplementaritySolver: Send {
    /// Writes a proposal to `z`; the residual in the returned stats is meaningless.
    ///
    /// # Errors
    /// If the algorithm ended without an answer; `z` then holds something finite or is to be ignored.
    /// # Panics
    /// If the lengths of `M`, `q` and `z` do not fit.
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved>;

    /// [`attempt`](Self::attempt) of a problem whose `M` is to the last bit that of the call before; only `q` may differ.
    ///
    /// The problems of one macro step share their matrix, and with many contacts finding that out takes longer than the
    /// solution (`benches/solvers.rs`, against size).
    ///
    /// # Errors
    /// As [`attempt`](Self::attempt).
    fn attempt_again(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        self.attempt(lcp, z)
    }

    /// Writes a solution to `z` and reports its natural residual, recomputed here and not by the solver.
    ///
    /// # Errors
    /// If the algorithm ended without an answer, or with one that is not finite. Whether a finite residual is small
    /// enough is for the caller to say; [`Checked`] does.
    fn solve(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let mut stats = self.attempt(lcp, z)?;
        stats.residual = natural_residual(lcp, z);
        if stats.residual.is_finite() { Ok(stats) } else { Err(Unsolved::NonFinite) }
    }

    /// A copy with the same warm start, which answers the next problem with the same bits.
    fn boxed_clone(&self) -> Box<dyn ComplementaritySolver>;

    /// Forgets the warm start, so that the next answer depends on its problem alone.
    fn reset(&mut self) {}

    /// Returns the largest `n` solved without allocating; 0 if the solver allocates at every problem.
    fn capacity(&self) -> usize {
        0
    }
}

impl Clone for Box<dyn ComplementaritySolver> {
    fn clone(&self) -> Self {
        (**self).boxed_clone()
    }
}
