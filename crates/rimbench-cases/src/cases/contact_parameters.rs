//! The contact law as parameters, and the two sides made with it; shared by the contact cases.

use super::case::{ChooseReference, CoupledSystem};
use super::memory;
use super::parameters::Parameters;
use super::reference_method::ReferenceMethod;
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::contact_law::ContactSpring;
use rimbench_core::cosim::Subsystem;
use rimbench_core::error::{Error, Result};
use rimbench_core::mechanics::{
    ContactLaw, Friction, MANY_CONTACTS, MechanicalModel, NonSmoothMechanics, bytes_needed, solver_room,
};
use std::sync::Arc;

/// The law of all contacts.
pub(super) const STABILISATION: &str =
    "stabilisation | - | 0.2 | fraction | fraction γ of a penetration removed per mechanics step | ours";
pub(super) const RESTITUTION: &str =
    "restitution | - | 0.0 | fraction | restitution e of the mechanics' contacts | plastic";

/// What makes contacts give way, for cases whose reference is not an exact solution with rigid ones.
pub(super) const COMPLIANT: &str = "source: ours
    contact_compliance_m_n | m/N | 0.0 | not negative | compliance 1/k of each contact; 0: rigid
    contact_damping_n_s_m | N·s/m | 0.0 | not negative | damping c of each contact, where it is compliant
";

/// Friction of all contacts, where it may be set and where it always is.
pub(super) const POSSIBLE_FRICTION: &str = "source: ours
    friction | - | 0.0 | not negative | coefficient of friction μ of all contacts; 0: none
    tangential_restitution | - | 0.0 | fraction | restitution along the surface, with friction that along the normal
";
pub(super) const WITH_FRICTION: &str = "source: ours
    friction | - | 0.3 | positive | coefficient of friction μ of all contacts; 0: none
    tangential_restitution | - | 0.0 | fraction | restitution along the surface, with friction that along the normal
";

/// Coefficients of friction at rest and in motion as the parameters say.
pub(super) fn coefficients(parameters: &Parameters) -> [f64; 2] {
    let (in_motion, at_rest) = (declared(parameters, FRICTION), declared(parameters, AT_REST));
    [if at_rest == 0.0 { in_motion } else { at_rest }, in_motion]
}

const FRICTION: &str = "friction";
const AT_REST: &str = "static_friction";
const ALONG: &str = "tangential_restitution";

const COMPLIANCE: &str = "contact_compliance_m_n";
const DAMPING: &str = "contact_damping_n_s_m";

/// Event-driven where contacts are rigid and without friction, else refined.
pub(super) fn reference() -> ChooseReference {
    reference_of(|_| 0)
}

/// The same where parameters say how many contacts there are: those that are kept by the dozen are not stepped from event to event.
pub(super) fn reference_of(contacts: fn(&Parameters) -> usize) -> ChooseReference {
    Arc::new(move |parameters| {
        let refined = declared(parameters, COMPLIANCE) > 0.0
            || declared(parameters, FRICTION) > 0.0
            || contacts(parameters) >= MANY_CONTACTS;
        Ok(if refined { ReferenceMethod::Refined } else { ReferenceMethod::EventDriven })
    })
}

/// A number that not all cases declare; 0 where it is not.
fn declared(parameters: &Parameters, name: &str) -> f64 {
    let known = parameters.iter().any(|(parameter, _)| parameter.name == name);
    if known { parameters.number(name) } else { 0.0 }
}

/// A force-producing actuator and the mechanics that it drives, with contacts as the parameters say.
///
/// # Errors
/// [`Error::Incompatible`] for a restitution, a damping or a friction that the law of the contacts does not have;
/// [`Error::InvalidValue`] for more contacts than memory may hold.
pub(super) fn coupled<M, A>(
    model: M,
    actuator: A,
    parameters: &Parameters,
    solver: &SolverEntry,
) -> Result<CoupledSystem>
where
    M: MechanicalModel + Clone + 'static,
    A: Subsystem + 'static,
{
    let law = law(parameters)?;
    let by_active_sets = solver.goes_by_active_sets();
    memory::must_hold(bytes_needed(&model, law, by_active_sets), model.size(), parameters)?;
    let checked = solver.checked(solver_room(&model, law, by_active_sets));
    let mechanics = NonSmoothMechanics::new(model, law, actuator.ports().facing(), checked);
    let [at_rest, coefficient] = coefficients(parameters);
    let friction = Friction { coefficient, at_rest, restitution: declared(parameters, ALONG) };
    if at_rest < coefficient {
        let expected = format!("0, or at least {FRICTION} = {coefficient}");
        return Err(Error::invalid(AT_REST, at_rest, expected));
    }
    if friction.coefficient > 0.0 {
        return Ok(CoupledSystem::new(mechanics.with_friction(friction)?, actuator));
    }
    if friction.restitution > 0.0 {
        return Err(Error::Incompatible(format!(
            "{ALONG} = {} needs friction: set {FRICTION} above 0",
            friction.restitution
        )));
    }
    Ok(CoupledSystem::new(mechanics, actuator))
}

/// The contact law as the parameters say.
fn law(parameters: &Parameters) -> Result<ContactLaw> {
    let restitution = declared(parameters, "restitution");
    let spring = spring(parameters, restitution)?;
    Ok(ContactLaw { stabilisation: parameters.number("stabilisation"), restitution, spring })
}

fn spring(parameters: &Parameters, restitution: f64) -> Result<Option<ContactSpring>> {
    let (compliance, damping) = (declared(parameters, COMPLIANCE), declared(parameters, DAMPING));
    match compliance > 0.0 {
        true if restitution > 0.0 => Err(Error::Incompatible(format!(
            "restitution = {restitution} does not go with {COMPLIANCE} = {compliance}: a compliant contact rebounds by its own spring; set \
             one of them to 0"
        ))),
        false if damping > 0.0 => Err(Error::Incompatible(format!(
            "{DAMPING} = {damping} needs a compliant contact: set {COMPLIANCE} above 0"
        ))),
        true => Ok(Some(ContactSpring { stiffness: 1.0 / compliance, damping })),
        false => Ok(None),
    }
}
