//! The default solver without its memory: what the warm start is worth is the difference.

use rimbench_core::complementarity::{ActiveSet, ComplementaritySolver, Lcp, SolveStats, Unsolved};

/// [`ActiveSet`] from an empty active set at every problem, so that an answer depends on its problem alone.
///
/// Guaranteed for symmetric positive semidefinite `M` when a solution exists. Free of allocation up to `capacity`.
#[derive(Debug, Clone)]
pub struct ActiveSetCold {
    solver: ActiveSet,
}

impl ActiveSetCold {
    /// Reserves room for problems up to `capacity` contacts; up to 8 need no heap.
    pub fn new(capacity: usize) -> Self {
        ActiveSetCold { solver: ActiveSet::new(capacity) }
    }
}

impl ComplementaritySolver for ActiveSetCold {
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        self.solver.reset();
        self.solver.attempt(lcp, z)
    }

    fn capacity(&self) -> usize {
        self.solver.capacity()
    }

    fn boxed_clone(&self) -> Box<dyn ComplementaritySolver> {
        Box::new(self.clone())
    }
}
