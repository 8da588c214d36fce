//! Zero-order hold: each input keeps the value received at the last communication point.
//!
//! ```text
//! u(t) = y(t_k),   t_k ≤ t < t_{k+1}
//! ```
//! **Needs** nothing but samples. **Order** 1 in H. **Known weakness**: the input lags by H/2 on average, which feeds
//! energy into oscillations; with Jacobi exchange no undamped oscillator has a stable macro step at all.
//! **Source**: textbook; the reference of Raoofian, Kövecses, Teichmann is this scheme at H = 0.2 ms.

use super::entry::SchemeEntry;
use super::extrapolation::Extrapolation;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry::new("zero-order-hold", "Hold the last sample", |construction| {
        Ok(Extrapolation::boxed(0, construction.ports))
    })
}
