//! No coupling at all: both sides step together at the micro step.
//!
//! ```text
//! λ_j = y_actuator(x_j, w_j)        mechanics: j → j+1 with λ_j;     actuator: j → j+1 with (s, w)_{j+1}
//! ```
//! The limit of a sweep over H: the rule of the [reference](crate::cosim), at the run's own micro step.
//! Communication points only say where rows are written; sequence, force return and `mechanics_steps` mean nothing
//! here.
//!
//! **Not real-time**: one solver owns both sides, which is what co-simulation is there to avoid. **Needs** nothing.
//! **Order** 1 in the micro step, none in H: the error does not depend on it. **Known weakness**: the mechanics pays
//! for its own step at every micro step. **Source**: textbook (semi-implicit Euler for the whole system).

use super::entry::SchemeEntry;
use super::extrapolation::Extrapolation;
use crate::iterative::IterativeDriver;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        driver: IterativeDriver::Monolithic,
        // Holds its samples; the driver does not ask for them.
        ..SchemeEntry::new("monolithic", "Ceiling: both sides together at the micro step", |construction| {
            Ok(Extrapolation::boxed(0, construction.ports))
        })
    }
}
