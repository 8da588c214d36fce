//! Implicit coupling with Aitken's relaxation: each macro step is taken again until both sides agree.
//!
//! ```text
//! u(t) linear from y(t_k) to the guess x for t_{k+1};     G(x): outputs at t_{k+1};     x ← x + ω (G(x) − x)
//! ```
//! Until `|G(x) − x| ≤ 1e-8` of the size of each coupling variable; a run that does not get there within 50 iterations
//! of a macro step ends as `solver-failed` with the reason. The actuator goes first, with the mechanics' motion
//! guessed, and returns its mean force, as the interface models do.
//!
//! **Not real-time**: the number of iterations is not known beforehand, and every one takes the whole macro step again.
//! **Needs** copies of both sides. **Order** 2 in H. **Known weakness**: one relaxation factor for all variables; a
//! force between the two values at the ends of the macro step is not seen. **Source**: Küttler, Wall 2008.

use super::entry::SchemeEntry;
use super::extrapolation::Extrapolation;
use super::requirement::Requirement;
use crate::cosim::{Sequence, Side};
use crate::iterative::{Iteration, IterativeDriver};

/// Largest residual of a coupling variable, relative to its size, at which an iteration ends.
const TOLERANCE: f64 = 1e-8;

/// Iterations after which a run fails. Those that converge need about three where nothing touches.
const MOST_ITERATIONS: u32 = 50;

/// Describes the scheme: a straight line through the last two samples, of which the newer is a guess of what is to
/// come.
pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 2,
        sequence: Sequence::GaussSeidel { first: Side::Actuator },
        needs: vec![Requirement::Copies],
        driver: IterativeDriver::Iterated(Iteration { tolerance: TOLERANCE, most_iterations: MOST_ITERATIONS }),
        ..SchemeEntry::new("iterated-aitken", "Ceiling: fixed-point iteration (Aitken)", |construction| {
            Ok(Extrapolation::boxed(1, construction.ports))
        })
    }
}
