//! A solver that tells what it was given.
//!
//! The recorders of a run are built by the entry that the run names, as any solver is; the stepping code knows nothing of them.

use rimbench_core::complementarity::{
    ActiveSet, ComplementaritySolver, Lcp, ProblemRecorder, RecordedProblem, SolveStats, Solver, SolverEntry, Unsolved,
};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Told which of the run's solvers (in the order in which they were built) solved what, with the impulses found.
type Observer = Arc<Mutex<dyn FnMut(usize, Lcp<'_>, &[f64]) + Send>>;

/// Counts the recorders that an entry has built.
#[derive(Debug, Clone, Default)]
pub(super) struct Built(Arc<AtomicUsize>);

impl Built {
    /// How many so far.
    pub(super) fn count(&self) -> usize {
        self.0.load(Ordering::Relaxed)
    }
}

/// Solves as `active-set` does and reports every problem to `observer`. Not in any catalogue: it is no choice of an experiment.
pub(super) fn recording(observer: impl FnMut(usize, Lcp<'_>, &[f64]) + Send + 'static) -> (Arc<SolverEntry>, Built) {
    let (observer, built) = (Arc::new(Mutex::new(observer)), Built::default());
    let counter = built.clone();
    let build = move |capacity| {
        let number = counter.0.fetch_add(1, Ordering::Relaxed);
        let observer: Observer = observer.clone();
        Solver::other(Recorder { number, observer, solver: ActiveSet::new(capacity) })
    };
    let entry = SolverEntry {
        name: "recording".into(),
        about: "active-set, with every problem recorded".into(),
        build: Arc::new(build),
        ..SolverEntry::active_set()
    };
    (Arc::new(entry), built)
}

/// Solves as `active-set` does and reports every problem with friction to `observer`. Not in any catalogue either.
pub(super) fn witnessing(
    observer: impl Fn(RecordedProblem<'_>) + Send + Sync + 'static,
) -> (Arc<SolverEntry>, ProblemRecorder) {
    let witness = ProblemRecorder::new(observer);
    (Arc::new(SolverEntry { witness: Some(witness.clone()), ..SolverEntry::active_set() }), witness)
}

#[derive(Clone)]
struct Recorder {
    number: usize,
    observer: Observer,
    solver: ActiveSet,
}

impl ComplementaritySolver for Recorder {
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let result = self.solver.attempt(lcp, z);
        let mut observer = self.observer.lock().unwrap_or_else(PoisonError::into_inner);
        observer(self.number, lcp, z);
        result
    }

    fn reset(&mut self) {
        self.solver.reset();
    }

    fn capacity(&self) -> usize {
        self.solver.capacity()
    }

    fn boxed_clone(&self) -> Box<dyn ComplementaritySolver> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_problem_is_reported_with_its_solver() {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let log = Arc::clone(&seen);
        let (entry, built) = recording(move |solver, lcp, z| log.lock().unwrap().push((solver, lcp.b[0], z[0])));
        let (mut first, mut second) = (entry.checked(1), entry.checked(1));
        let mut z = [0.0];
        second.solve(Lcp::new(&[2.0], &[-1.0]), &mut z).unwrap();
        first.solve(Lcp::new(&[2.0], &[-2.0]), &mut z).unwrap();
        assert_eq!((z, built.count()), ([1.0], 2));
        assert_eq!(*seen.lock().unwrap(), [(1, -1.0, 0.5), (0, -2.0, 1.0)]);
    }
}
