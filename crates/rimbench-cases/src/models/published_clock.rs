//! A quirk of a published co-simulation driver, to reproduce its digits.

use rimbench_core::cosim::{Ports, Subsystem, SubsystemCounters};
use rimbench_core::error::Failure;

/// Runs a subsystem one of its own micro steps ahead of the rest.
///
/// In the published driver (LIM cosim-benchmarks) the hydraulics steps `while t − t_goal < h/2`, one time too often in
/// its first call. From then on its clock, and with it the spool command it sees, is one micro step ahead.
#[derive(Debug, Clone)]
pub struct PublishedClock<S> {
    inner: S,
    started: bool,
}

impl<S: Subsystem> PublishedClock<S> {
    /// Wraps a subsystem.
    pub fn new(inner: S) -> Self {
        PublishedClock { inner, started: false }
    }
}

impl<S: Subsystem + Clone + 'static> Subsystem for PublishedClock<S> {
    fn ports(&self) -> &Ports {
        self.inner.ports()
    }

    fn outputs(&self, u: &[f64], y: &mut [f64]) {
        self.inner.outputs(u, y);
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        if !self.started {
            self.started = true;
            self.inner.step(t, u, h)?;
        }
        self.inner.step(t + h, u, h)
    }

    fn observables(&self) -> &[&'static str] {
        self.inner.observables()
    }

    fn observe(&mut self, h: f64, row: &mut [f64]) {
        self.inner.observe(h, row);
    }

    fn try_clone(&self) -> Option<Box<dyn Subsystem>> {
        Some(Box::new(self.clone()))
    }

    fn counters(&self) -> SubsystemCounters {
        self.inner.counters()
    }
}
