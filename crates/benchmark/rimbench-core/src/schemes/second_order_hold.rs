//! Second-order hold: each input goes on along the parabola through the last three samples.
//!
//! ```text
//! u(t) = Σ_j y(t_{k−j}) L_j(t),   j = 0, 1, 2
//! ```
//! **Needs** three samples; uses a lower degree until it has them. **Order** 3 in H. **Known weakness**: the smallest
//! stable macro step of the three, and the largest overshoot after a change of contact.
//! **Source**: textbook (quadratic extrapolation in the explicit co-simulation literature).

use super::entry::SchemeEntry;
use super::extrapolation::Extrapolation;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 3,
        samples: 3,
        ..SchemeEntry::new(
            "second-order-hold",
            "Extrapolate quadratically from the last three samples",
            |construction| Ok(Extrapolation::boxed(2, construction.ports)),
        )
    }
}
