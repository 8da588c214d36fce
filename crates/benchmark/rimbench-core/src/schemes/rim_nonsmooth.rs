//! `rim-nonsmooth`: the reduced interface model with contacts closed at `t_k` as complementarity conditions.
//!
//! ```text
//! 0 ≤ w_c⁺ ⟂ P_c ≥ 0      in each micro step, c by contact detection: by default what the mechanics' last step found closed
//! ```
//! **Needs** an interface model of the mechanics. **Order** 2 in H while contacts stay as they are (see
//! `rim-smooth`). **Known weakness**: a contact
//! that closes within the macro step is not in the set, unless the law of the mechanics is asked for; with a margin
//! contacts count as closed before they are, and the error levels off at what the margin allows. **Source**: Raoofian,
//! Kövecses, Teichmann, Eq. 4.

use super::entry::SchemeEntry;
use super::reduced_interface::{Contacts, ReducedInterface};

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        ..ReducedInterface::entry(
            "rim-nonsmooth",
            "Non-smooth model: closed contacts may open (the paper's proposal)",
            Contacts::Unilateral,
        )
    }
}
