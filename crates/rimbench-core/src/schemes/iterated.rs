//! What the iterated schemes share: linear interpolation between the sample at `t_k` and the guess for `t_{k+1}`.

use super::entry::SchemeEntry;
use super::extrapolation::Extrapolation;
use super::need::Need;
use crate::ceilings::{Acceleration, Driver, Iteration};
use crate::cosim::{Sequence, Side};

/// Largest residual of a coupling variable, relative to its size, at which an iteration ends.
const TOLERANCE: f64 = 1e-8;

/// Iterations after which a run fails. Those that converge need about three where nothing touches.
const MOST_ITERATIONS: u32 = 50;

/// A straight line through the last two samples, of which the newer is a guess of what is to come.
pub(super) fn entry(name: &'static str, about: &'static str, acceleration: Acceleration) -> SchemeEntry {
    SchemeEntry {
        order: 2,
        sequence: Sequence::GaussSeidel { first: Side::Actuator },
        needs: vec![Need::Copies],
        driver: Driver::Iterated(Iteration { acceleration, tolerance: TOLERANCE, most_iterations: MOST_ITERATIONS }),
        ..SchemeEntry::new(name, about, |construction| Ok(Extrapolation::boxed(1, construction.ports)))
    }
}
