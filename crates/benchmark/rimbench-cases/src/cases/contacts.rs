//! The contact law as parameters, and the two sides made with it; shared by the contact cases.

use super::case::{Assembly, ChooseReference, CoupledSystem};
use super::memory;
use super::reference_method::ReferenceMethod;
use crate::parameter::{ParameterSet, parameters};
use rimbench_core::contact_law::ContactSpring;
use rimbench_core::cosim::Subsystem;
use rimbench_core::error::{Error, Result};
use rimbench_core::mechanics::{
    ContactLaw, Friction, MechanicalModel, NonSmoothMechanics, bytes_needed, solver_memory,
};
use std::sync::Arc;

parameters! {
    /// The law of all contacts. A case declares those of it that may be set; the others keep these defaults.
    pub struct Contacts from "ours" {
        stabilisation: f64 = 0.2, Fraction, "fraction γ of a penetration removed per mechanics step".study(0.05..0.5);
        restitution: f64 = 0.0, Fraction, "restitution e of the mechanics' contacts".study(0.0..0.8).from("plastic");
        contact_compliance_m_n: f64 = 0.0, NotNegative, "compliance 1/k of each contact; 0: rigid";
        contact_damping_n_s_m: f64 = 0.0, NotNegative, "damping c of each contact, where it is compliant";
        friction: f64 = 0.0, NotNegative, "coefficient of friction μ of all contacts; 0: none".study(0.1..0.6);
        static_friction: f64 = 0.0, NotNegative, "coefficient of friction μ_s of a contact that sticks; 0: that of contacts that slide";
        tangential_restitution: f64 = 0.0, Fraction, "restitution along the surface, at most that along the normal".study(0.0..0.5);
    }
}

impl Contacts {
    /// Coefficients of friction at rest and in motion.
    pub(super) fn coefficients(&self) -> [f64; 2] {
        [if self.static_friction == 0.0 { self.friction } else { self.static_friction }, self.friction]
    }

    fn law(&self) -> Result<ContactLaw> {
        Ok(ContactLaw { stabilisation: self.stabilisation, restitution: self.restitution, spring: self.spring()? })
    }

    fn spring(&self) -> Result<Option<ContactSpring>> {
        let Contacts { restitution, contact_compliance_m_n: compliance, contact_damping_n_s_m: damping, .. } = *self;
        match compliance > 0.0 {
            true if restitution > 0.0 => Err(Error::Incompatible(format!(
                "restitution = {restitution} does not go with contact_compliance_m_n = {compliance}: a compliant contact rebounds by its \
                 own spring; set one of them to 0"
            ))),
            false if damping > 0.0 => Err(Error::Incompatible(format!(
                "contact_damping_n_s_m = {damping} needs a compliant contact: set contact_compliance_m_n above 0"
            ))),
            true => Ok(Some(ContactSpring { stiffness: 1.0 / compliance, damping })),
            false => Ok(None),
        }
    }
}

/// Contacts from which on a reference does not step from event to event: so many close that its steps would be all
/// events.
const BY_THE_DOZEN: usize = 48;

/// Event-driven where contacts are rigid and without friction, else refined.
pub(super) fn reference() -> ChooseReference {
    reference_of(|(): &()| 0)
}

/// Refined also where there are contacts by the dozen, which are not stepped from event to event.
pub(super) fn reference_of<P: ParameterSet>(count: fn(&P) -> usize) -> ChooseReference {
    Arc::new(move |parameters| {
        let contacts = Contacts::read(parameters);
        let refined = contacts.contact_compliance_m_n > 0.0
            || contacts.friction > 0.0
            || count(&P::read(parameters)) >= BY_THE_DOZEN;
        Ok(if refined { ReferenceMethod::Refined } else { ReferenceMethod::EventDriven })
    })
}

impl Assembly<'_> {
    /// Couples a force-producing actuator with the mechanics that it drives, whose contacts follow this law.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for a restitution, a damping or a friction that the law of the contacts does not have;
    /// [`Error::InvalidValue`] for more contacts than memory may hold.
    pub fn couple<M, A>(&self, model: M, actuator: A, contacts: &Contacts) -> Result<CoupledSystem>
    where
        M: MechanicalModel + Clone + 'static,
        A: Subsystem + 'static,
    {
        let law = contacts.law()?;
        let by_active_sets = self.solver.goes_by_active_sets();
        memory::must_hold(bytes_needed(&model, law, by_active_sets), model.size(), self.parameters)?;
        let checked = self.solver.checked(solver_memory(&model, law, by_active_sets));
        let mechanics = NonSmoothMechanics::new(model, law, actuator.ports().facing(), checked);
        let [at_rest, coefficient] = contacts.coefficients();
        if at_rest < coefficient {
            return Err(Error::invalid("static_friction", at_rest, format!("0, or at least friction = {coefficient}")));
        }
        let restitution = contacts.tangential_restitution;
        if coefficient > 0.0 {
            let mechanics = mechanics.with_friction(Friction { coefficient, at_rest, restitution }, self.solver)?;
            return Ok(CoupledSystem::new(mechanics, actuator));
        }
        if restitution > 0.0 {
            return Err(Error::Incompatible(format!(
                "tangential_restitution = {restitution} needs friction: set friction above 0"
            )));
        }
        Ok(CoupledSystem::new(mechanics, actuator))
    }
}
