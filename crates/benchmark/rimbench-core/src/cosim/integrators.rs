//! By which rule each side advances its own state.

use crate::name::by_name;

/// The rule by which the mechanics takes a step of its own.
///
/// ```text
/// semi-implicit  v⁺ from M, f, A at q;  q⁺ = q + h v⁺;  gap law                                  order 1
/// midpoint       v⁺ from M, f, A at q + ½hv;  q⁺ = q + ½h (v + v⁺);  gap law                     order 2 between impacts
/// event-split    midpoint, resting contacts at velocity level, split where a gap closes          order 2 through impacts
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum MechanicsIntegrator {
    /// The rule of the source paper, and of most engines.
    #[default]
    SemiImplicit,
    /// The explicit midpoint rule with the gap law of the whole step.
    Midpoint,
    /// The explicit midpoint rule from event to event.
    EventSplit,
}

/// The rule by which the actuator takes a micro step.
///
/// ```text
/// euler     the state moves by its rate at the start of the micro step; the force of the start acts          order 1
/// midpoint  the state moves by its rate in the middle; the force acts as it is in the middle, and what
///           follows the velocity directly (viscous friction) by the trapezoidal rule                         order 2
/// ```
/// A subsystem that integrates its own state exactly does so under both; what differs then is the force that acts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ActuatorIntegrator {
    /// The explicit rule.
    #[default]
    Euler,
    /// The second-order rule.
    Midpoint,
}

/// A rule of the second order, asked of a subsystem (see
/// [`Capabilities::use_second_order`](super::Capabilities::use_second_order)).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SecondOrder {
    /// A midpoint rule.
    Midpoint,
    /// The midpoint rule from event to event.
    EventSplit,
}

impl MechanicsIntegrator {
    /// Returns what this asks of the mechanics; nothing where it steps as it always did.
    pub fn second_order(self) -> Option<SecondOrder> {
        match self {
            MechanicsIntegrator::SemiImplicit => None,
            MechanicsIntegrator::Midpoint => Some(SecondOrder::Midpoint),
            MechanicsIntegrator::EventSplit => Some(SecondOrder::EventSplit),
        }
    }

    /// All of them, by name.
    pub const ALL: [(&'static str, MechanicsIntegrator); 3] = [
        ("semi-implicit", MechanicsIntegrator::SemiImplicit),
        ("midpoint", MechanicsIntegrator::Midpoint),
        ("event-split", MechanicsIntegrator::EventSplit),
    ];
}

impl ActuatorIntegrator {
    /// All of them, by name.
    pub const ALL: [(&'static str, ActuatorIntegrator); 2] =
        [("euler", ActuatorIntegrator::Euler), ("midpoint", ActuatorIntegrator::Midpoint)];
}

by_name!(MechanicsIntegrator, ALL, "mechanics_integrator");

by_name!(ActuatorIntegrator, ALL, "actuator_integrator");
