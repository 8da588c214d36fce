//! A recorder of the problems with friction that a run poses.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A contact problem with friction and its answer, as slices.
#[derive(Debug, Clone, Copy)]
pub struct RecordedProblem<'a> {
    /// Which of the run's solvers it was, in the order in which they were built.
    pub solver: usize,
    /// `[H_nn H_nt; H_tn H_tt]`, 1/kg.
    pub h: &'a [f64],
    /// `[b_n; b_t]`, m/s.
    pub b: &'a [f64],
    /// Coefficient of each contact.
    pub friction: &'a [f64],
    /// `[P_n; P_t]`, N·s; not a solution where there is none.
    pub impulses: &'a [f64],
}

/// Records every problem with friction, and counts the solvers that report to it.
#[derive(Clone)]
pub struct ProblemRecorder {
    told: Arc<dyn Fn(RecordedProblem<'_>) + Send + Sync>,
    built: Arc<AtomicUsize>,
}

impl ProblemRecorder {
    /// Tells this function.
    pub fn new(told: impl Fn(RecordedProblem<'_>) + Send + Sync + 'static) -> Self {
        ProblemRecorder { told: Arc::new(told), built: Arc::default() }
    }

    /// Returns how many solvers have been built that tell it.
    pub fn solvers(&self) -> usize {
        self.built.load(Ordering::Relaxed)
    }

    /// Counts one more, and returns its number.
    pub fn number(&self) -> usize {
        self.built.fetch_add(1, Ordering::Relaxed)
    }

    /// Tells it.
    pub fn tell(&self, witnessed: RecordedProblem<'_>) {
        (self.told)(witnessed);
    }
}

impl fmt::Debug for ProblemRecorder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ProblemRecorder").field("built", &self.built).finish_non_exhaustive()
    }
}
