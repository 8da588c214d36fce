//! Zero-order hold: each input keeps the value received at the last communication point.
//!
//! ```text
//! u(t) = y(t_k),   t_k ≤ t < t_{k+1}
//! ```
//! **Needs** nothing but samples. **Order** 1 in H. **Known weakness**: the input lags by H/2 on average, which feeds
//! energy into oscillations; with Jacobi exchange no undamped oscillator has a stable macro step at all.
//! **Source**: textbook; the reference of Raoofian, Kövecses, Teichmann is this scheme at H = 0.2 ms.

use super::entry::{Family, SchemeEntry};
use super::extrapolation::Extrapolation;
use crate::cosim::Sequence;

pub(super) const ENTRY: SchemeEntry = SchemeEntry {
    name: "zero-order-hold",
    about: "Hold the last sample",
    family: Family::Signal,
    order: 1,
    samples: 1,
    sequence: Sequence::Jacobi,
    needs: &[],
    gain: None,
    build: |mechanics, actuator, _options| Extrapolation::boxed(0, mechanics, actuator),
};
