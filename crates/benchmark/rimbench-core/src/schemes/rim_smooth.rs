//! `rim-smooth`: the reduced interface model with every contact closed at `t_k` bilateral for the whole macro step.
//!
//! ```text
//! m_eff = (H_ii − H_ic H_cc⁺ H_ci)⁻¹      w_i(t_k) ← w_i − H_ic H_cc⁺ w_c      c = {touch at t_k}, or {g ≤ ε}
//! ```
//! **Needs** an interface model of the mechanics. **Order** 2 in H (force return `mean`), of the coupling alone: a
//! mechanics of first order that takes one step per macro step brings the whole to 1. **Known weakness**: where the
//! closed contacts lock the interface, `1/m_eff → 0`, and the actuator builds up pressure against a wall that is not
//! there. With what the mechanics found closed, the default, or a margin below some 30 µm, contacts that lock rarely
//! meet on the wedge box, and the failure goes; it is a failure of this model *with* a margin. Dependent contacts are
//! left out. **Source**: Peiret, González, Kövecses,
//! Teichmann 2018; the smooth RIM of Raoofian, Kövecses, Teichmann.

use super::entry::SchemeEntry;
use super::reduced_interface::{Contacts, ReducedInterface};

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        ..ReducedInterface::entry("rim-smooth", "Smooth model: closed contacts are bilateral", Contacts::Bilateral)
    }
}
