//! Solvers that wrap another one and show what it is given.
//!
//! The recorders of a run are built by the entry that the run names, as any solver is; the stepping code knows nothing of them.

use rimbench_core::complementarity::{ActiveSet, ComplementaritySolver, Lcp, SolveStats, Solver, Unsolved};
use rimbench_core::friction::{ActiveStates, ContactState, FrictionProblem, StateMethod};
use rimbench_core::solver_entry::SolverEntry;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Told which of the run's solvers (in the order in which they were built) proposed what: the problem, and `answer` as far as it is found.
type Observer<F> = Arc<Mutex<F>>;

/// Counts the recorders that an entry has built.
#[derive(Debug, Clone, Default)]
pub(super) struct Built(Arc<AtomicUsize>);

impl Built {
    /// How many so far.
    pub(super) fn count(&self) -> usize {
        self.0.load(Ordering::Relaxed)
    }
}

/// Solves as `solver` does and reports every problem to `observer`.
struct Recorder<S, F> {
    number: usize,
    observer: Observer<F>,
    solver: S,
}

impl<S: Clone, F> Clone for Recorder<S, F> {
    fn clone(&self) -> Self {
        Recorder { number: self.number, observer: self.observer.clone(), solver: self.solver.clone() }
    }
}

/// Returns a function that wraps solvers, numbered in turn.
fn wrap<S, F>(observer: F, built: &Built) -> impl Fn(S) -> Recorder<S, F> + use<S, F> {
    let (observer, built) = (Arc::new(Mutex::new(observer)), built.clone());
    move |solver| {
        let number = built.0.fetch_add(1, Ordering::Relaxed);
        Recorder { number, observer: observer.clone(), solver }
    }
}

/// Records problems without friction of `active-set`. Not in any catalogue: it is no choice of an experiment.
pub(super) fn recording(observer: impl FnMut(usize, Lcp<'_>, &[f64]) + Send + 'static) -> (Arc<SolverEntry>, Built) {
    let built = Built::default();
    let recorder = wrap(observer, &built);
    let entry = SolverEntry {
        name: "recording".into(),
        about: "active-set, with every problem recorded".into(),
        build: Arc::new(move |capacity| Solver::other(recorder(ActiveSet::new(capacity)))),
        ..SolverEntry::active_set()
    };
    (Arc::new(entry), built)
}

/// Records problems with friction of `active-set`.
pub(super) fn recording_friction(
    observer: impl FnMut(usize, FrictionProblem<'_>, &[f64]) + Send + 'static,
) -> (Arc<SolverEntry>, Built) {
    let built = Built::default();
    let recorder = wrap(observer, &built);
    let build = move |contacts| Box::new(recorder(ActiveStates::new(contacts))) as Box<dyn StateMethod>;
    let entry = SolverEntry { build_with_friction: Some(Arc::new(build)), ..SolverEntry::active_set() };
    (Arc::new(entry), built)
}

impl<S: ComplementaritySolver + Clone + 'static, F> ComplementaritySolver for Recorder<S, F>
where
    F: FnMut(usize, Lcp<'_>, &[f64]) + Send + 'static,
{
    fn attempt(&mut self, lcp: Lcp<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let result = self.solver.attempt(lcp, impulses);
        self.observer.lock().unwrap_or_else(PoisonError::into_inner)(self.number, lcp, impulses);
        result
    }

    fn reset(&mut self) {
        self.solver.reset();
    }

    fn capacity(&self) -> usize {
        self.solver.capacity()
    }
}

impl<S: StateMethod + Clone + 'static, F> StateMethod for Recorder<S, F>
where
    F: FnMut(usize, FrictionProblem<'_>, &[f64]) + Send + 'static,
{
    fn attempt(
        &mut self,
        problem: FrictionProblem<'_>,
        same_matrix: bool,
        states: &mut [ContactState],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let result = self.solver.attempt(problem, same_matrix, states, impulses);
        self.observer.lock().unwrap_or_else(PoisonError::into_inner)(self.number, problem, impulses);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_problem_is_reported_with_its_solver() {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let log = Arc::clone(&seen);
        let (entry, built) =
            recording(move |solver, lcp, impulses| log.lock().unwrap().push((solver, lcp.b[0], impulses[0])));
        let (mut first, mut second) = (entry.checked(1), entry.checked(1));
        let mut impulses = [0.0];
        second.solve(Lcp::new(&[2.0], &[-1.0]), &mut impulses).unwrap();
        first.solve(Lcp::new(&[2.0], &[-2.0]), &mut impulses).unwrap();
        assert_eq!((impulses, built.count()), ([1.0], 2));
        assert_eq!(*seen.lock().unwrap(), [(1, -1.0, 0.5), (0, -2.0, 1.0)]);
    }
}
