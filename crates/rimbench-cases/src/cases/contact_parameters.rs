//! The contact law as parameters, and the two sides made with it; shared by the contact cases.

use super::case::CoupledSystem;
use super::parameters::{Parameter, Parameters, Range, number};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::cosim::Subsystem;
use rimbench_core::mechanics::{ContactLaw, MechanicalModel, NonSmoothMechanics};

const OURS: &str = "ours";

pub(super) fn margin(default: f64) -> Parameter {
    number(
        "contact_margin_m",
        "m",
        default,
        Range::NotNegative,
        "a contact with gap ≤ margin counts as closed at t_k",
        OURS,
    )
}

pub(super) fn stabilisation() -> Parameter {
    number("stabilisation", "-", 0.2, Range::Fraction, "fraction γ of a penetration removed per mechanics step", OURS)
}

pub(super) fn restitution(default: f64, source: &'static str) -> Parameter {
    number("restitution", "-", default, Range::Fraction, "restitution e of the mechanics' contacts", source)
}

/// All three, with these defaults; `source` is that of the restitution.
pub(super) fn all(margin_m: f64, e: f64, source: &'static str) -> Vec<Parameter> {
    vec![margin(margin_m), stabilisation(), restitution(e, source)]
}

/// A force-producing actuator and the mechanics that it drives, with contacts as the parameters say.
pub(super) fn coupled<M, A>(model: M, actuator: A, parameters: &Parameters, solver: &SolverEntry) -> CoupledSystem
where
    M: MechanicalModel + Clone + 'static,
    A: Subsystem + 'static,
{
    let checked = solver.checked(model.size().unilateral);
    let mechanics = NonSmoothMechanics::new(model, law(parameters), actuator.ports().facing(), checked);
    CoupledSystem::new(mechanics, actuator)
}

/// The contact law as the parameters say.
fn law(parameters: &Parameters) -> ContactLaw {
    ContactLaw {
        stabilisation: parameters.number("stabilisation"),
        restitution: parameters.number("restitution"),
        contact_margin: parameters.number("contact_margin_m"),
    }
}
