//! First-order hold: each input goes on along the straight line through the last two samples.
//!
//! ```text
//! u(t) = y(t_k) + (t − t_k) (y(t_k) − y(t_{k−1})) / (t_k − t_{k−1})
//! ```
//! **Needs** two samples; holds until it has them. **Order** 2 in H. **Known weakness**: overshoots after every kink,
//! and contact makes kinks; amplifies what oscillates near the exchange frequency.
//! **Source**: textbook (linear extrapolation in the explicit co-simulation literature).

use super::entry::SchemeEntry;
use super::extrapolation::Extrapolation;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 2,
        samples: 2,
        ..SchemeEntry::new("first-order-hold", "Extrapolate linearly from the last two samples", |construction| {
            Ok(Extrapolation::boxed(1, construction.ports))
        })
    }
}
