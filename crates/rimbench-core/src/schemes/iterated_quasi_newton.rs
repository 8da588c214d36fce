//! Implicit coupling with the interface quasi-Newton method (IQN-ILS): each macro step is taken again until both sides
//! agree.
//!
//! ```text
//! u(t) linear from y(t_k) to the guess x for t_{k+1};     G(x): outputs at t_{k+1};     x ← x + W c + r,  c = argmin ‖V c + r‖
//! ```
//! The same solution as [`iterated-aitken`](super::iterated_aitken), with the same tolerance and limit, in fewer iterations
//! where several variables cross the interface; columns of `V` and `W` come from the same macro step only.
//!
//! **Not real-time**, as there. **Needs** copies of both sides. **Order** 2 in H. **Known weakness**: a contact that opens
//! or closes between two guesses makes their differences say little. **Source**: Degroote, Bathe, Vierendeels 2009; see
//! [`Acceleration`](crate::ceilings::Acceleration).

use super::entry::SchemeEntry;
use super::iterated;
use super::line_style::{Dash, LineStyle, Marker};
use crate::ceilings::Acceleration;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        line: LineStyle::new([0x8E, 0x8F, 0x93], Dash::Dotted, Marker::OpenCircle),
        ..iterated::entry(
            "iterated-quasi-newton",
            "Ceiling: repeat each macro step to agreement, interface quasi-Newton",
            Acceleration::QuasiNewton,
        )
    }
}
