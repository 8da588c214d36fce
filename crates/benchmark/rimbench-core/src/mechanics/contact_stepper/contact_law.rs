//! The contact law of the mechanics.

use crate::interface_model::ReducedInterfaceModel;
use rimbench_contact::contact_law::ContactSpring;

/// The contact law of the mechanics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLaw {
    /// Fraction γ ∈ [0, 1] of a penetration (or joint error) removed per step.
    pub stabilisation: f64,
    /// Restitution e ∈ [0, 1] of a contact that is hit and whose rebound lasts: `w⁺ + e w⁻ ≥ 0`, see
    /// [`Rebounds`](rimbench_contact::contact_law::Rebounds).
    pub restitution: f64,
    /// Spring and damper of compliant contacts; none for rigid ones. With a spring, γ acts on joints only, and e has no
    /// effect.
    pub spring: Option<ContactSpring>,
}

impl ContactLaw {
    /// Tells whether contacts rebound.
    pub(in crate::mechanics) fn rebounds(&self) -> bool {
        self.restitution > 0.0 && self.spring.is_none()
    }

    /// Writes restitution and spring to an interface model.
    pub(super) fn apply_to(&self, model: &mut ReducedInterfaceModel) {
        model.restitution = self.restitution;
        model.spring = self.spring;
        if self.rebounds() {
            model.discretisation_approach = vec![0.0; model.contacts()];
        }
    }
}
