//! Somebody who is told which problems with friction a run poses: no solver that can be named solves them.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A contact problem with friction and its answer, as slices.
#[derive(Debug, Clone, Copy)]
pub struct Witnessed<'a> {
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

/// Tells somebody about every problem with friction, and counts the solvers that do.
#[derive(Clone)]
pub struct Witness {
    told: Arc<dyn Fn(Witnessed<'_>) + Send + Sync>,
    built: Arc<AtomicUsize>,
}

impl Witness {
    /// Tells this function.
    pub fn new(told: impl Fn(Witnessed<'_>) + Send + Sync + 'static) -> Self {
        Witness { told: Arc::new(told), built: Arc::default() }
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
    pub fn tell(&self, witnessed: Witnessed<'_>) {
        (self.told)(witnessed);
    }
}

impl fmt::Debug for Witness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Witness").field("built", &self.built).finish_non_exhaustive()
    }
}
