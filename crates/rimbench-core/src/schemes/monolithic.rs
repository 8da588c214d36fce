//! No coupling at all: both sides step together at the micro step.
//!
//! ```text
//! λ_j = y_actuator(x_j, w_j)        mechanics: j → j+1 with λ_j;     actuator: j → j+1 with (s, w)_{j+1}
//! ```
//! What a sweep over H tends to and cannot pass: the rule of the [reference](crate::cosim), at the run's own micro step.
//! Communication points only say where rows are written; sequence, force return and `mechanics_steps` mean nothing here.
//!
//! **Not real-time**: one solver owns both sides, which is what co-simulation is there to avoid. **Needs** nothing.
//! **Order** 1 in the micro step, none in H: the error does not depend on it. **Known weakness**: the mechanics pays for
//! its own step at every micro step. **Source**: textbook (semi-implicit Euler for the whole system).

use super::entry::{Family, SchemeEntry};
use super::extrapolation::Extrapolation;
use crate::cosim::{Coupling, CouplingScheme, MicroStep, Sample, Sequence, Side};
use crate::error::Failure;

pub(super) const ENTRY: SchemeEntry = SchemeEntry {
    name: "monolithic",
    about: "Ceiling: both sides together at the micro step",
    family: Family::Ceiling,
    order: 1,
    samples: 1,
    sequence: Sequence::Jacobi,
    needs: &[],
    gain: None,
    build: |mechanics, actuator, _options| Box::new(Monolithic(Extrapolation::new(0, mechanics, actuator))),
};

/// Holds what it receives, for whoever asks; the loop does not.
#[derive(Clone)]
struct Monolithic(Extrapolation);

impl CouplingScheme for Monolithic {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        self.0.receive(from, sample)
    }

    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        self.0.input(to, at, own, u)
    }

    fn coupling(&self) -> Coupling {
        Coupling::Monolithic
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}
