//! Pressure–displacement coupling: the cylinder puts out its pressures, the mechanics makes the force itself.
//!
//! The force then follows the mechanics' own velocity, so the coupling has no direct feedthrough.

use super::hydraulic_cylinder::{Cylinder, HydraulicCylinder};
use rimbench_core::cosim::{Capabilities, Port, Ports, Quantity, Subsystem, SubsystemCounters, subsystem_methods};
use rimbench_core::error::Failure;
use rimbench_core::name::Name;

fn pressures() -> Vec<Port> {
    ["pressure_1_pa", "pressure_2_pa"].map(|name| Port::new(name, Quantity::Pressure)).to_vec()
}

/// A cylinder whose outputs are its pressures: length and velocity in, `p₁, p₂` out.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureOutput {
    cylinder: HydraulicCylinder,
    ports: Ports,
}

impl PressureOutput {
    /// Turns a cylinder from force to pressure output.
    pub fn new(cylinder: HydraulicCylinder) -> Self {
        let inputs = cylinder.ports().inputs.clone();
        PressureOutput { cylinder, ports: Ports { inputs, outputs: pressures(), direct_feedthrough: false } }
    }
}

impl Subsystem for PressureOutput {
    subsystem_methods!(ports capabilities clone);

    fn outputs(&mut self, _u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        y.copy_from_slice(&self.cylinder.pressures());
        Ok(())
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.cylinder.step(t, u, h)
    }

    fn counters(&self) -> SubsystemCounters {
        self.cylinder.counters()
    }
}

/// Only what the cylinder shows: it is the force that it knows rates of. Its account books the work of a force that the
/// mechanics makes here, and friction at a velocity that it has not.
impl Capabilities for PressureOutput {
    fn observables(&mut self) -> &[Name] {
        self.cylinder.observables()
    }

    fn observe(&mut self, h: f64, row: &mut [f64]) {
        self.cylinder.observe(h, row);
    }
}

/// Mechanics that takes pressures in and makes the actuator force from them, anew in each of its own steps.
///
/// ```text
/// F = (p₂ − p₁) A − c ṡ       ṡ at the start of the step
/// ```
/// It offers no reduced interface model: the interface is not a force and its displacement.
#[derive(Clone)]
pub struct PressureDrivenMechanics<M> {
    mechanics: M,
    cylinder: Cylinder,
    ports: Ports,
    /// Length and velocity.
    y: [f64; 2],
}

impl<M: Subsystem> PressureDrivenMechanics<M> {
    /// Wraps mechanics with one force in, one length and one velocity out.
    pub fn new(mechanics: M, cylinder: Cylinder) -> Self {
        debug_assert_eq!((mechanics.ports().inputs.len(), mechanics.ports().outputs.len()), (1, 2));
        let outputs = mechanics.ports().outputs.clone();
        let ports = Ports { inputs: pressures(), outputs, direct_feedthrough: false };
        PressureDrivenMechanics { mechanics, cylinder, ports, y: [0.0; 2] }
    }
}

impl<M: Subsystem + Clone + 'static> Subsystem for PressureDrivenMechanics<M> {
    subsystem_methods!(ports capabilities clone);

    fn outputs(&mut self, _u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        // The force does not enter the outputs of the mechanics inside.
        self.mechanics.outputs(&[0.0], y)
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.mechanics.outputs(&[0.0], &mut self.y)?;
        self.mechanics.step(t, &[self.cylinder.force([u[0], u[1]], self.y[1])], h)
    }

    fn counters(&self) -> SubsystemCounters {
        self.mechanics.counters()
    }
}

impl<M: Subsystem> Capabilities for PressureDrivenMechanics<M> {
    fn observables(&mut self) -> &[Name] {
        self.mechanics.capabilities().observables()
    }

    fn observe(&mut self, h: f64, row: &mut [f64]) {
        self.mechanics.capabilities().observe(h, row);
    }

    fn interface_work(&mut self) -> Option<f64> {
        self.mechanics.capabilities().interface_work()
    }

    fn energy_identity_residual(&mut self) -> Option<f64> {
        self.mechanics.capabilities().energy_identity_residual()
    }
}
