//! The coupling variables of a subsystem, by name.

use super::side::PerSide;
use crate::error::{Error, Result};
use crate::name::Name;

/// The quantity of a coupling variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Position along the interface, m.
    Position,
    /// Velocity along the interface, m/s.
    Velocity,
    /// Force along the interface, N.
    Force,
    /// Fluid pressure, Pa.
    Pressure,
}

impl Quantity {
    /// Returns the magnitude below which a coupling variable counts as zero, so that the round-off of a system at rest
    /// is nothing: m, m/s, N, Pa. Ours.
    pub fn negligible(self) -> f64 {
        match self {
            Quantity::Position | Quantity::Velocity => 1e-6,
            Quantity::Force => 1e-3,
            Quantity::Pressure => 1.0,
        }
    }
}

/// One coupling variable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// Name with unit, as it appears in data.
    pub name: Name,
    /// Its quantity.
    pub quantity: Quantity,
}

impl Port {
    /// Names a coupling variable.
    pub fn new(name: impl Into<Name>, quantity: Quantity) -> Self {
        Port { name: name.into(), quantity }
    }
}

/// The coupling variables of a subsystem. For an interface of dimension m, positions come first, then velocities.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ports {
    /// Inputs, in the order of the other side's outputs.
    pub inputs: Vec<Port>,
    /// Outputs.
    pub outputs: Vec<Port>,
    /// True if the outputs depend directly on the inputs.
    pub direct_feedthrough: bool,
}

impl Ports {
    /// Turns them round: the ports of a subsystem that fits this one, without direct feedthrough.
    pub fn facing(&self) -> Ports {
        Ports { inputs: self.outputs.clone(), outputs: self.inputs.clone(), direct_feedthrough: false }
    }
}

/// Checks that two subsystems fit: each output of one is the input of the other, by name and order.
///
/// # Errors
/// [`Error::Incompatible`] naming the ports that do not meet.
pub fn check_coupling(ports: PerSide<&Ports>) -> Result<()> {
    let PerSide { mechanics, actuator } = ports;
    for (from, outputs, to, inputs) in [
        ("mechanics", &mechanics.outputs, "actuator", &actuator.inputs),
        ("actuator", &actuator.outputs, "mechanics", &mechanics.inputs),
    ] {
        if outputs != inputs {
            let names = |ports: &[Port]| ports.iter().map(|port| &*port.name).collect::<Vec<_>>().join(", ");
            return Err(Error::Incompatible(format!(
                "the {from} side offers [{}] but the {to} side wants [{}]",
                names(outputs),
                names(inputs)
            )));
        }
    }
    if mechanics.direct_feedthrough && actuator.direct_feedthrough {
        return Err(Error::Incompatible(
            "both sides have direct feedthrough: an algebraic loop without iteration".into(),
        ));
    }
    Ok(())
}
