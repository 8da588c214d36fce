//! The effective mass of the model (source paper, Fig. 2).

use crate::interface_model::{Condensation, ContactModes, ReducedInterfaceModel, condense_in_modes};

/// The effective mass `m_eff = (H_ii − H_ic H_cc⁺ H_ci)⁻¹`, c being the contacts that carried impulse.
#[derive(Clone)]
pub(super) struct EffectiveMass {
    /// Where contacts are bilateral: the effective mass at the communication point, kg.
    pub(super) bilateral: f64,
    /// Contacts that carried impulse in the first micro step since the communication point; until it is solved, in the
    /// last one before.
    strongly_active: Vec<usize>,
    /// The model with those contacts bilateral.
    condensation: Condensation,
}

impl EffectiveMass {
    /// Reserves room for models of the size of `empty`.
    pub(super) fn new(empty: &ReducedInterfaceModel) -> Self {
        EffectiveMass {
            bilateral: f64::NAN,
            strongly_active: Vec::with_capacity(empty.contacts()),
            condensation: Condensation::of(empty),
        }
    }

    /// Records which contacts of `set` carry impulse.
    pub(super) fn record(&mut self, set: &[usize], impulses: &[f64]) {
        let active = set.iter().zip(impulses).filter(|(_, impulse)| **impulse > 0.0);
        self.strongly_active.clear();
        self.strongly_active.extend(active.map(|(&contact, _)| contact));
    }

    /// Returns the effective mass (kg) of `model` with the recorded contacts bilateral, sticking or slipping as `modes`
    /// says.
    pub(super) fn of_strongly_active(&mut self, model: &ReducedInterfaceModel, modes: ContactModes<'_>) -> f64 {
        condense_in_modes(model, modes, &self.strongly_active, &mut self.condensation);
        self.condensation.effective_mass
    }

    /// Returns the mobility of the interface (1/kg, row-major) of `model` with the recorded contacts bilateral; none
    /// where there are none.
    pub(super) fn loaded_mobility(&mut self, model: &ReducedInterfaceModel, modes: ContactModes<'_>) -> Option<&[f64]> {
        if self.strongly_active.is_empty() {
            return None;
        }
        self.of_strongly_active(model, modes);
        Some(&self.condensation.h)
    }
}
