//! Contact problems without friction, as linear complementarity problems: `w = H P + b`, `0 ≤ w ⟂ P ≥ 0`.
//!
//! `H` is symmetric positive semidefinite, and in mechanics with more contacts than degrees of freedom it is singular
//! as a rule (`H = A_u G A_uᵀ`, 1/kg; `P` impulses, N·s; `w`, `b` velocities, m/s). Then `P` is not unique;
//! `w` and the resultant are.
//!
//! | symbol | of LCPs | here | unit |
//! |---|---|---|---|
//! | `H` | `M` | Delassus operator, n×n | 1/kg |
//! | `b` | `q` | velocities without contact impulse | m/s |
//! | `P`, `w` | `z`, `w` | impulses, velocities after them | N·s, m/s |
//! | `A` | | active set: the indices with `w = 0` and `P ≥ 0` free | |
//! | `r` | | [natural residual](ContactProblem::natural_residual) | |
//!
//! A solver only proposes impulses ([`ComplementaritySolver::attempt`]); whether they are a solution is decided by the
//! natural residual, one for all of them. Simulations use [`Checked`], which also knows the fallback. A solver is known
//! by its [`SolverEntry`](crate::solver_entry::SolverEntry); those that a program may choose from stand in its
//! catalogue.

mod active_set;
mod checked;
mod lemke;
mod lemke_tableau;
mod propose;
mod proximal_guess;
mod solver;
mod sparse_active_set;

pub use crate::problem::Unsolved;
pub use active_set::ActiveSet;
pub use checked::{Checked, SolverCounters};
pub use lemke::Lemke;
pub(crate) use lemke_tableau::LemkeTableau;
pub use propose::{ProblemOf, ProposeImpulses};
pub use solver::Solver;
pub use sparse_active_set::{SparseActiveSet, SparseSolver};

use crate::linear_algebra::SymmetricRows;
use crate::problem::{ContactProblem, DenseDelassus, Signorini};
use dyn_clone::DynClone;

/// A linear complementarity problem with a full matrix.
pub type Lcp<'a> = ContactProblem<'a, DenseDelassus<'a>, Signorini>;

/// One whose matrix has a fixed pattern.
pub type SparseLcp<'a> = ContactProblem<'a, SymmetricRows<'a>, Signorini>;

/// Work and outcome of one solve.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SolveStats {
    /// Changes of the active set (or simplex pivots, or iterations of an iterative solver).
    pub pivots: u32,
    /// Factorisations from scratch.
    pub factorisations: u32,
    /// True if the fallback found the answer.
    pub fallback: bool,
    /// Natural residual, recomputed from `H`, `b` and `P` after the solve.
    pub residual: f64,
}

/// Solves linear complementarity problems of one size class, reusing its workspace.
///
/// Per problem [`attempt`](Self::attempt) and then [`ContactProblem::natural_residual`], as [`Checked`] does. Every
/// solver answers `P = 0` when `b ≥ 0`. [`reset`](Self::reset) when the next problem has nothing to do with the last.
pub trait ComplementaritySolver: DynClone + Send {
    /// Writes a proposal for P to `impulses`; the residual in the returned stats is meaningless.
    ///
    /// # Errors
    /// If the algorithm ended without an answer; `impulses` then hold something finite or are to be ignored.
    /// # Panics
    /// If the lengths of `H`, `b` and `impulses` do not fit.
    fn attempt(&mut self, lcp: Lcp<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved>;

    /// Forgets the warm start, so that the next answer depends on its problem alone.
    fn reset(&mut self) {}

    /// Returns the largest `n` solved without allocating; 0 if the solver allocates at every problem.
    fn capacity(&self) -> usize {
        0
    }
}

dyn_clone::clone_trait_object!(ComplementaritySolver);
