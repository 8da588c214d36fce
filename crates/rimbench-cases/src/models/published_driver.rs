//! Quirks of a published co-simulation driver, to reproduce its digits.

use rimbench_core::cosim::{Abilities, Ports, Subsystem, SubsystemCounters};
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

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.inner.outputs(u, y)
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        if !self.started {
            self.started = true;
            self.inner.step(t, u, h)?;
        }
        self.inner.step(t + h, u, h)
    }

    fn abilities(&mut self) -> &mut dyn Abilities {
        self.inner.abilities()
    }

    fn try_clone(&self) -> Option<Box<dyn Subsystem>> {
        Some(Box::new(self.clone()))
    }

    fn counters(&self) -> SubsystemCounters {
        self.inner.counters()
    }
}

/// Lets a subsystem with direct feedthrough answer with the input of its last step instead of the one it is asked with.
///
/// The published driver makes the force at a communication point with the velocity that the hydraulics was given for the step
/// before. Before the first step there is none: then the answer is the usual one.
#[derive(Debug, Clone)]
pub struct StaleFeedthrough<S> {
    inner: S,
    /// Input of the last step, once there was one.
    last: Vec<f64>,
    stepped: bool,
}

impl<S: Subsystem> StaleFeedthrough<S> {
    /// Wraps a subsystem.
    pub fn new(inner: S) -> Self {
        let last = vec![0.0; inner.ports().inputs.len()];
        StaleFeedthrough { inner, last, stepped: false }
    }
}

impl<S: Subsystem + Clone + 'static> Subsystem for StaleFeedthrough<S> {
    fn ports(&self) -> &Ports {
        self.inner.ports()
    }

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.inner.outputs(if self.stepped { &self.last } else { u }, y)
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.last.copy_from_slice(u);
        self.stepped = true;
        self.inner.step(t, u, h)
    }

    fn abilities(&mut self) -> &mut dyn Abilities {
        self.inner.abilities()
    }

    fn try_clone(&self) -> Option<Box<dyn Subsystem>> {
        Some(Box::new(self.clone()))
    }

    fn counters(&self) -> SubsystemCounters {
        self.inner.counters()
    }
}
