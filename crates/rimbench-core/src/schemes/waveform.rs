//! Waveform iteration on the micro grid: each macro step is covered again and again until what both sides exchanged at every micro
//! step stays.
//!
//! ```text
//! λ_j⁰ = λ_k;    mechanics with λ_j^{i−1} → (s, w)_{j+1}^i;    actuator with (s, w)_{j+1}^i → λ_{j+1}^i
//! ```
//! Until no coupling variable changes by more than 1e-10 of its size at any micro step. What it converges to is the
//! [monolithic stepper](super::monolithic) at the micro step, for every H: the ceiling of all coupling schemes, reached through
//! two subsystems. Sequence, force return and `mechanics_steps` mean nothing here.
//!
//! **Not real-time**: every pass takes the whole macro step again. **Needs** copies of both sides. **Order** 1 in the micro step,
//! none in H. **Known weakness**: the number of passes grows with H. **Source**: textbook (waveform relaxation).

use super::entry::SchemeEntry;
use super::extrapolation::Extrapolation;
use super::requirement::Requirement;
use crate::iterative::{IterativeDriver, Waveform};

/// Largest change of a coupling variable, relative to its size, at which the iteration ends.
const TOLERANCE: f64 = 1e-10;

/// Passes after which a run fails.
const MOST_ITERATIONS: u32 = 200;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        needs: vec![Requirement::Copies],
        driver: IterativeDriver::Waveform(Waveform { tolerance: TOLERANCE, most_iterations: MOST_ITERATIONS }),
        // Holds its samples; the driver does not ask for them.
        ..SchemeEntry::new("waveform", "Ceiling: waveform iteration over micro steps", |construction| {
            Ok(Extrapolation::boxed(0, construction.ports))
        })
    }
}
