//! What the iterated schemes share: linear interpolation between the sample at `t_k` and the guess for `t_{k+1}`.

use super::extrapolation::Extrapolation;
use crate::cosim::{Acceleration, Coupling, CouplingScheme, Iteration, MicroStep, Ports, Sample, Side};
use crate::error::Failure;

/// Largest residual of a coupling variable, relative to its size, at which an iteration ends.
const TOLERANCE: f64 = 1e-8;

/// Iterations after which a run fails. Those that converge need about three where nothing touches.
const MOST_ITERATIONS: u32 = 50;

/// A straight line through the last two samples, of which the newer is a guess of what is to come.
#[derive(Clone)]
pub(super) struct Implicit {
    line: Extrapolation,
    acceleration: Acceleration,
}

impl Implicit {
    pub(super) fn boxed(acceleration: Acceleration, mechanics: &Ports, actuator: &Ports) -> Box<dyn CouplingScheme> {
        Box::new(Implicit { line: Extrapolation::new(1, mechanics, actuator), acceleration })
    }
}

impl CouplingScheme for Implicit {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        self.line.receive(from, sample)
    }

    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        self.line.input(to, at, own, u)
    }

    fn coupling(&self) -> Coupling {
        Coupling::Implicit(Iteration {
            acceleration: self.acceleration,
            tolerance: TOLERANCE,
            most_iterations: MOST_ITERATIONS,
        })
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}
