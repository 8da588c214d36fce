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
//! [`Acceleration`](crate::cosim::Acceleration).

use super::entry::{Family, SchemeEntry};
use super::implicit::Implicit;
use super::need::Need;
use crate::cosim::{Acceleration, Sequence, Side};

pub(super) const ENTRY: SchemeEntry = SchemeEntry {
    name: "iterated-quasi-newton",
    about: "Ceiling: repeat each macro step to agreement, interface quasi-Newton",
    family: Family::Ceiling,
    order: 2,
    samples: 1,
    sequence: Sequence::GaussSeidel { first: Side::Actuator },
    needs: &[Need::Copies],
    gain: None,
    build: |mechanics, actuator, _options| Implicit::boxed(Acceleration::QuasiNewton, mechanics, actuator),
};
