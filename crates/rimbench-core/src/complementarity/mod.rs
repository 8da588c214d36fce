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
//! [`natural_residual`], the same for all of them. Simulations use [`Checked`], which also knows the fallback. To add
//! a solver: one file, one line in [`SOLVERS`]; the tests run over the list.

mod active_set;
mod checked;
mod lemke;
mod natural_residual;
mod solver;

pub use active_set::ActiveSet;
pub use checked::{Checked, SolverCounters};
pub use lemke::Lemke;
pub use natural_residual::natural_residual;
pub use solver::Solver;

use crate::error::{Error, Failure, find_by_name};
use std::sync::{PoisonError, RwLock};

/// One problem `w = M z + q`, `0 ≤ w ⟂ z ≥ 0`.
#[derive(Debug, Clone, Copy)]
pub struct Lcp<'a> {
    /// `n×n`, row-major, symmetric positive semidefinite.
    pub m: &'a [f64],
    /// Length `n`.
    pub q: &'a [f64],
}

impl Lcp<'_> {
    /// Returns `n`.
    ///
    /// # Panics
    /// If `M` is not `n×n`.
    #[inline]
    pub fn size(&self) -> usize {
        let n = self.q.len();
        assert_eq!(self.m.len(), n * n, "M is n×n and q has length n");
        n
    }

    /// Tells whether `z = 0` is a solution, that is `q ≥ 0`. Looks at `q` only.
    ///
    /// # Errors
    /// [`Failure::NonFinite`] if `q` is not finite.
    #[inline]
    pub fn is_solved_by_zero(&self) -> Result<bool, Failure> {
        let (mut finite, mut nonnegative) = (true, true);
        for q in self.q {
            finite &= q.is_finite();
            nonnegative &= *q >= 0.0;
        }
        if finite { Ok(nonnegative) } else { Err(NON_FINITE) }
    }

    /// Checks every entry of `M`.
    ///
    /// # Errors
    /// [`Failure::NonFinite`].
    pub fn require_finite_matrix(&self) -> Result<(), Failure> {
        if self.m.iter().all(|m| m.is_finite()) { Ok(()) } else { Err(NON_FINITE) }
    }
}

const NON_FINITE: Failure = Failure::NonFinite { quantity: "complementarity problem" };

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
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Failure>;

    /// [`attempt`](Self::attempt) of a problem whose `M` is to the last bit that of the call before; only `q` may differ.
    ///
    /// The problems of one macro step share their matrix, and with many contacts finding that out takes longer than the
    /// solution.
    ///
    /// # Errors
    /// As [`attempt`](Self::attempt).
    fn attempt_again(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Failure> {
        self.attempt(lcp, z)
    }

    /// Writes a solution to `z` and reports its natural residual, recomputed here and not by the solver.
    ///
    /// # Errors
    /// If the algorithm ended without an answer, or with one that is not finite. Whether a finite residual is small
    /// enough is for the caller to say; [`Checked`] does.
    fn solve(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Failure> {
        let mut stats = self.attempt(lcp, z)?;
        stats.residual = natural_residual(lcp, z);
        if stats.residual.is_finite() { Ok(stats) } else { Err(NON_FINITE) }
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

/// A solver that can be named in an experiment.
#[derive(Debug, Clone, Copy)]
pub struct SolverEntry {
    /// The name in data, for example `active-set`.
    pub name: &'static str,
    /// The idea in a sentence.
    pub about: &'static str,
    /// The class of problems it is guaranteed to solve in exact arithmetic.
    pub guaranteed: &'static str,
    /// Natural residual up to which an answer is accepted.
    pub tolerance: f64,
    /// True if a rejected problem is given to `lemke`.
    pub fallback: bool,
    /// Builds the bare solver with room for problems up to the given `n`.
    pub build: fn(capacity: usize) -> Solver,
}

impl SolverEntry {
    /// Builds the solver behind the check and with the fallback its entry states.
    pub fn checked(&self, capacity: usize) -> Checked {
        let fallback = self.fallback.then(|| Lemke::new(capacity));
        Checked::new((self.build)(capacity), fallback, self.tolerance)
    }
}

/// The solvers that simulations need, the default first.
pub const SOLVERS: &[SolverEntry] = &[
    SolverEntry {
        name: "active-set",
        about: "symmetric principal pivoting (Keller) from the last active set; the real-time default",
        guaranteed: "symmetric positive semidefinite, feasible",
        tolerance: 1e-9,
        fallback: true,
        build: |capacity| Solver::ActiveSet(Box::new(ActiveSet::new(capacity))),
    },
    SolverEntry {
        name: "lemke",
        about: "Lemke's complementary pivoting with the lexicographic rule; no warm start",
        guaranteed: "positive semidefinite, feasible",
        tolerance: 1e-9,
        fallback: false,
        build: |capacity| Solver::other(Lemke::new(capacity)),
    },
];

/// Looks a solver up in [`SOLVERS`].
///
/// # Errors
/// [`Error::UnknownName`] with the valid names.
pub fn solver_by_name(name: &str) -> Result<&'static SolverEntry, Error> {
    find_by_name("complementarity solver", &all_solvers(), |entry| entry.name, name).copied()
}

static REGISTERED: RwLock<Vec<&'static SolverEntry>> = RwLock::new(Vec::new());

/// Adds solvers to those that are found by name, for as long as the program runs; names that are there already are left out.
pub fn register(entries: &'static [SolverEntry]) {
    let mut registered = REGISTERED.write().unwrap_or_else(PoisonError::into_inner);
    for entry in entries {
        if !SOLVERS.iter().chain(registered.iter().copied()).any(|known| known.name == entry.name) {
            registered.push(entry);
        }
    }
}

/// Every solver: the built-in ones, then those registered.
pub fn all_solvers() -> Vec<&'static SolverEntry> {
    let registered = REGISTERED.read().unwrap_or_else(PoisonError::into_inner);
    SOLVERS.iter().chain(registered.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_and_unique() {
        for entry in SOLVERS {
            assert_eq!(solver_by_name(entry.name).unwrap().about, entry.about);
            assert_eq!(SOLVERS.iter().filter(|other| other.name == entry.name).count(), 1);
        }
        assert!(solver_by_name("active_set").unwrap_err().to_string().contains("did you mean `active-set`?"));
    }
}
