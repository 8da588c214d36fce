//! The contact law of the model's micro steps, from that of the mechanics. Eq. 4 has no gap term.

use crate::interface_model::ReducedInterfaceModel;
use rimbench_contact::affine_step::StepContactLaw;
use rimbench_contact::contact_law::GapRates;

/// The gap term t in the complementarity condition of a micro step, `0 ≤ w_u⁺ + t ⟂ P_u ≥ 0`; see [`GapRates`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GapTerm {
    /// `t = 0`, as in Eq. 4.
    None,
    /// The gaps of `t_k` over the mechanics' step, `t = g/h` where open.
    Frozen,
    /// The gaps of the model, `g⁺ = g + δ w_u⁺`, over the micro step, `t = g/δ` where open.
    Tracked,
}

impl GapTerm {
    /// Returns the contact law over micro steps of length `micro_step` (s).
    pub(super) fn law(self, model: &ReducedInterfaceModel, micro_step: f64) -> StepContactLaw {
        let time = self.opening_time(model, micro_step);
        StepContactLaw {
            rates: match (self, model.spring) {
                (GapTerm::None, _) => GapRates::default(),
                (_, None) => GapRates::new(time, model.mechanics_step, model.stabilisation),
                (_, Some(spring)) => spring.gap_rates(time),
            },
            gap_step: if self == GapTerm::Tracked { micro_step } else { 0.0 },
            restitution: if model.spring.is_none() { model.restitution } else { 0.0 },
            closing_time: time,
        }
    }

    /// Returns the time within which an open contact may use up its gap, s.
    pub(super) fn opening_time(self, model: &ReducedInterfaceModel, micro_step: f64) -> f64 {
        if self == GapTerm::Frozen { model.mechanics_step } else { micro_step }
    }
}
