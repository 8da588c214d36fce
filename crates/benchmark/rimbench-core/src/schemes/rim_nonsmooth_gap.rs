//! `rim-nonsmooth-gap`: the reduced interface model with all contacts and their gaps.
//!
//! ```text
//! 0 ≤ w_u⁺ + max(g, 0)/δ + γ min(g, 0)/h ⟂ P_u ≥ 0      g⁺ = g + δ w_u⁺
//! ```
//! A contact may close and open at any micro step, so no contact is detected and none missed. A penetration decays as
//! in the mechanics: by the fraction γ per mechanics step h, not within one micro step. **Needs** an interface model of
//! the mechanics. **Order** 2 in H while contacts stay as they are (see `rim-smooth`), about 1 across contact events.
//! **Known weakness**: normals are those of `t_k`; the complementarity problems carry all contacts, open ones too.
//! **Source**: ours, after Raoofian, Kövecses, Teichmann.

use super::entry::SchemeEntry;
use super::reduced_interface::{Contacts, ReducedInterface};
use crate::cosim::{Share, StarPlan};

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        has_mechanics_law: true,
        ..ReducedInterface::entry(
            "rim-nonsmooth-gap",
            "Gap tracking: all contacts open and close",
            Contacts::UnilateralWithGaps,
        )
    }
}

/// The same with a bond for each actuator, whose models have equal shares of the mechanics.
pub(super) fn split_entry() -> SchemeEntry {
    let entry =
        ReducedInterface::entry("rim-split", "Split models: one for each actuator", Contacts::UnilateralWithGaps);
    SchemeEntry { bonds: Some(StarPlan { share: Share::Equal, ..StarPlan::default() }), ..entry }
}
