//! Quirks of published co-simulation drivers and units, to reproduce their digits.

use rimbench_core::cosim::{Subsystem, subsystem_methods};
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
    subsystem_methods!(clone ports_of_inner outputs_of_inner capabilities_of_inner counters_of_inner);

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        if !self.started {
            self.started = true;
            self.inner.step(t, u, h)?;
        }
        self.inner.step(t + h, u, h)
    }
}

/// Lets a subsystem with direct feedthrough answer with the input of its last step instead of the one it is asked with.
///
/// Two independent public codes do so: the driver of the LIM crane makes the force at a communication point with the
/// velocity that the hydraulics was given for the step before, and so does the wheel of the OSP quarter truck. Before
/// the first step there is none: then the answer is the usual one.
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
    subsystem_methods!(clone ports_of_inner capabilities_of_inner counters_of_inner);

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.inner.outputs(if self.stepped { &self.last } else { u }, y)
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.last.copy_from_slice(u);
        self.stepped = true;
        self.inner.step(t, u, h)
    }
}

/// Lets a subsystem that is driven by position and velocity of the other side keep a position of its own, the integral
/// of the velocities it was given, which it never compares with the one it is sent. The wheel of the OSP quarter truck
/// does so.
#[derive(Debug, Clone)]
pub struct OwnPosition<S> {
    inner: S,
    /// Once it was sent one.
    position: Option<f64>,
}

impl<S: Subsystem> OwnPosition<S> {
    /// Wraps a subsystem with the inputs position (m) and velocity (m/s).
    pub fn new(inner: S) -> Self {
        debug_assert_eq!(inner.ports().inputs.len(), 2);
        OwnPosition { inner, position: None }
    }
}

impl<S: Subsystem + Clone + 'static> Subsystem for OwnPosition<S> {
    subsystem_methods!(clone ports_of_inner capabilities_of_inner counters_of_inner);

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.inner.outputs(&[self.position.unwrap_or(u[0]), u[1]], y)
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let (position, velocity) = (self.position.unwrap_or(u[0]), u[1]);
        if let Some(inputs) = self.inner.capabilities().input_polynomials() {
            inputs.give(|polynomials| {
                polynomials[0] = [position, velocity, 0.0, 0.0];
                polynomials[1] = [velocity, 0.0, 0.0, 0.0];
                true
            });
        }
        self.position = Some(position + h * velocity);
        self.inner.step(t, &[position + 0.5 * h * velocity, velocity], h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::{Carriage, SpringActuator};
    use crate::parameter::ParameterSet;
    use std::ptr;

    #[test]
    fn a_wrapper_must_return_the_capabilities_of_the_subsystem_inside_it() {
        let inner = SpringActuator::new(Carriage { spring_stiffness_n_m: 1.0, ..Carriage::defaults() }).unwrap();
        let mut clock = PublishedClock::new(inner.clone());
        let mut stale = StaleFeedthrough::new(inner.clone());
        let mut own = OwnPosition::new(inner);
        let addresses = [
            (ptr::from_mut(clock.capabilities()).cast::<()>(), ptr::from_mut(&mut clock.inner).cast::<()>()),
            (ptr::from_mut(stale.capabilities()).cast(), ptr::from_mut(&mut stale.inner).cast()),
            (ptr::from_mut(own.capabilities()).cast(), ptr::from_mut(&mut own.inner).cast()),
        ];
        assert!(addresses.iter().all(|(returned, inner)| returned == inner));
    }
}
