//! `rim-nonsmooth-gap`: the reduced interface model with all contacts and their gaps.
//!
//! ```text
//! 0 ≤ w_u⁺ + max(g, 0)/δ + γ min(g, 0)/h ⟂ P_u ≥ 0      g⁺ = g + δ w_u⁺
//! ```
//! A contact may close and open at any micro step, so no contact margin is involved. A penetration decays as in the
//! mechanics: by the fraction γ per mechanics step h, not within one micro step.
//! **Needs** an interface model of the mechanics. **Order** 2 in H while contacts stay as they are (see
//! `rim-smooth`), about 1 across contact events. **Known weakness**: normals are
//! those of `t_k`; the complementarity problems carry all contacts, open ones too.
//! **Source**: ours, after Raoofian, Kövecses, Teichmann.

use super::entry::{Family, SchemeEntry};
use super::need::Need;
use super::reduced_interface::{Contacts, ReducedInterface};
use crate::cosim::{Sequence, Side};

pub(super) const ENTRY: SchemeEntry = SchemeEntry {
    name: "rim-nonsmooth-gap",
    about: "Reduced interface model; all contacts with their gaps, closing and opening at any micro step",
    family: Family::Model,
    order: 2,
    samples: 1,
    sequence: Sequence::GaussSeidel { first: Side::Actuator },
    needs: &[Need::ForceDisplacement, Need::InterfaceModel],
    gain: None,
    build: |mechanics, actuator, options| {
        ReducedInterface::boxed(Contacts::UnilateralWithGaps, mechanics, actuator, options)
    },
};
