//! What an entry of the list builds: the default solver under its own type, all others behind a trait object.

use super::{ActiveSet, ComplementaritySolver, Lcp, SolveStats, Unsolved};

/// A solver by value.
///
/// The default solver answers in some ten nanoseconds (`benches/solvers.rs`), of which a call through a table of
/// functions would be a part worth having; so it is named.
#[derive(Clone)]
pub enum Solver {
    /// The default.
    ActiveSet(Box<ActiveSet>),
    /// Any other.
    Other(Box<dyn ComplementaritySolver>),
}

impl Solver {
    /// Wraps any solver that has no variant of its own.
    pub fn other(solver: impl ComplementaritySolver + 'static) -> Self {
        Solver::Other(Box::new(solver))
    }
}

impl ComplementaritySolver for Solver {
    #[inline(always)]
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        match self {
            Solver::ActiveSet(solver) => solver.attempt(lcp, z),
            Solver::Other(solver) => solver.attempt(lcp, z),
        }
    }

    #[inline(always)]
    fn attempt_again(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        match self {
            Solver::ActiveSet(solver) => solver.attempt_again(lcp, z),
            Solver::Other(solver) => solver.attempt_again(lcp, z),
        }
    }

    fn reset(&mut self) {
        match self {
            Solver::ActiveSet(solver) => solver.reset(),
            Solver::Other(solver) => solver.reset(),
        }
    }

    fn capacity(&self) -> usize {
        match self {
            Solver::ActiveSet(solver) => solver.capacity(),
            Solver::Other(solver) => solver.capacity(),
        }
    }

    fn boxed_clone(&self) -> Box<dyn ComplementaritySolver> {
        Box::new(self.clone())
    }
}
