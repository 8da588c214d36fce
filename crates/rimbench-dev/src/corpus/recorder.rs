//! A solver that lets one look over its shoulder: `active-set`, with every problem it is given reported.
//!
//! Cases and schemes build their solvers from a [`SolverEntry`], so a run is recorded by giving it [`RECORDING`]; the
//! stepping code knows nothing of it. An entry holds a plain function, so what the recorders report goes to the observer of
//! the present thread, which runs the whole simulation.

use rimbench_core::complementarity::{ActiveSet, ComplementaritySolver, Lcp, SolveStats, Solver, SolverEntry};
use rimbench_core::error::Failure;
use std::cell::RefCell;

/// Told which of the run's solvers (in the order in which they were built) solved what, with the impulses found.
type Observer = Box<dyn FnMut(usize, Lcp<'_>, &[f64])>;

#[derive(Default)]
struct Present {
    observer: Option<Observer>,
    built: usize,
}

thread_local! {
    static PRESENT: RefCell<Present> = RefCell::default();
}

/// Solves as `active-set` does and reports every problem. Not in the list of solvers: it is no choice of an experiment.
pub(super) static RECORDING: SolverEntry = SolverEntry {
    name: "recording",
    about: "active-set, with every problem recorded",
    guaranteed: "symmetric positive semidefinite, feasible",
    tolerance: 1e-9,
    fallback: true,
    build: |capacity| Solver::other(Recorder::new(capacity)),
};

/// Runs `simulation` on this thread with every problem of its recorders reported to `observer`; also returns how many
/// recorders it built.
pub(super) fn observe<T>(
    observer: impl FnMut(usize, Lcp<'_>, &[f64]) + 'static,
    simulation: impl FnOnce() -> T,
) -> (T, usize) {
    PRESENT.set(Present { observer: Some(Box::new(observer)), built: 0 });
    let result = simulation();
    (result, PRESENT.take().built)
}

#[derive(Clone)]
struct Recorder {
    number: usize,
    solver: ActiveSet,
}

impl Recorder {
    fn new(capacity: usize) -> Self {
        let number = PRESENT.with_borrow_mut(|present| {
            present.built += 1;
            present.built - 1
        });
        Recorder { number, solver: ActiveSet::new(capacity) }
    }
}

impl ComplementaritySolver for Recorder {
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Failure> {
        let result = self.solver.attempt(lcp, z);
        PRESENT.with_borrow_mut(|present| {
            if let Some(observer) = &mut present.observer {
                observer(self.number, lcp, z);
            }
        });
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
    use std::rc::Rc;

    #[test]
    fn every_problem_is_reported_with_its_solver_and_only_while_observed() {
        let seen = Rc::new(RefCell::new(Vec::new()));
        let log = Rc::clone(&seen);
        let solve = |q: f64| {
            let mut z = [0.0];
            let mut solvers = [RECORDING.checked(1), RECORDING.checked(1)];
            solvers[1].solve(Lcp { m: &[2.0], q: &[q] }, &mut z).unwrap();
            solvers[0].solve(Lcp { m: &[2.0], q: &[2.0 * q] }, &mut z).unwrap();
            z[0] / 2.0
        };
        let (z, built) = observe(move |solver, lcp, z| log.borrow_mut().push((solver, lcp.q[0], z[0])), || solve(-1.0));
        solve(-5.0);
        assert_eq!((z, built, seen.take()), (0.5, 2, vec![(1, -1.0, 0.5), (0, -2.0, 1.0)]));
    }
}
