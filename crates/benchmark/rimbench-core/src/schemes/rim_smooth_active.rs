//! `rim-smooth-active`: the smooth reduced interface model with only those contacts bilateral that carry impulse.
//!
//! ```text
//! 0 ≤ w_c⁺ ⟂ P_c ≥ 0 once at t_k      active = {α : P_α > 0}      m_eff = (H_ii − H_iA H_AA⁺ H_Ai)⁻¹
//! ```
//! c by contact detection, by default what the mechanics' last step found closed. One complementarity problem per macro
//! step instead of one per micro step. Active contacts of a solution without redundancy cannot lock what moves, so the
//! spike of `rim-smooth` goes. **Needs** an interface model of the mechanics. **Order** 2 in H while contacts stay as
//! they are (see `rim-smooth`). **Known weakness**: the choice of `t_k` stands for the whole macro step: a contact that
//! should open pulls, and one that should close lets through, until the next communication point. A bounce cannot be
//! bilateral: no restitution. **Source**: in the spirit of Peiret, González, Kövecses, Teichmann, Kelly 2020 (one
//! contact mode per macro step); the details are ours.

use super::entry::SchemeEntry;
use super::reduced_interface::{Contacts, ReducedInterface};

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        ..ReducedInterface::entry(
            "rim-smooth-active",
            "Smooth model: loaded contacts are bilateral",
            Contacts::BilateralActive,
        )
    }
}
