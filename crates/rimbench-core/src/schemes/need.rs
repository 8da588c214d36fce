//! What a scheme asks of the subsystems, and whether they have it to offer.

use crate::cosim::{OutputRates, Port, Quantity, Subsystem};

/// Something a scheme cannot do without.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// Forces to the mechanics, and the positions and velocities of the same interface back.
    ForceDisplacement,
    /// A reduced interface model of the mechanics.
    InterfaceModel,
    /// An interface of at most so many rows.
    Rows(usize),
    /// Directional derivatives of the actuator's outputs.
    OutputRates,
    /// The force that the scheme hands to the mechanics must be used: force return `held`. Refused before any run.
    HeldReturn,
    /// Both subsystems can be copied, so that a step can be taken again.
    Copies,
}

impl Need {
    /// Why two subsystems do not offer this, if they do not.
    pub fn unmet(self, mechanics: &dyn Subsystem, actuator: &dyn Subsystem) -> Option<String> {
        let (met, reason) = match self {
            Need::ForceDisplacement => (
                is_force_displacement(mechanics, actuator),
                "a force-displacement coupling is needed: forces to the mechanics, their positions and velocities back",
            ),
            Need::InterfaceModel => {
                (mechanics.empty_interface_model().is_some(), "the mechanics offers no reduced interface model")
            }
            Need::Rows(most) if actuator.ports().outputs.len() > most => {
                return Some(format!("the interface has more than {most} rows"));
            }
            Need::Rows(_) | Need::HeldReturn => return None,
            Need::OutputRates => {
                let ports = actuator.ports();
                let mut rates = OutputRates::zeros(ports.outputs.len(), ports.inputs.len());
                let offered = actuator.output_rates(0.0, &vec![0.0; ports.inputs.len()], &mut rates);
                (offered, "the actuator offers no directional derivatives of its outputs")
            }
            Need::Copies => (
                mechanics.try_clone().is_some() && actuator.try_clone().is_some(),
                "a subsystem cannot be copied, and so no step can be taken again",
            ),
        };
        (!met).then(|| reason.to_owned())
    }
}

fn is_force_displacement(mechanics: &dyn Subsystem, actuator: &dyn Subsystem) -> bool {
    let count = |ports: &[Port], quantity| ports.iter().filter(|port| port.quantity == quantity).count();
    let (inputs, outputs) = (&actuator.ports().inputs, &actuator.ports().outputs);
    let forces = count(outputs, Quantity::Force);
    forces > 0
        && forces == outputs.len()
        && count(inputs, Quantity::Position) == forces
        && count(inputs, Quantity::Velocity) == forces
        && inputs.len() == 2 * forces
        && mechanics.ports().outputs == *inputs
}
