//! One side of a co-simulation.

use super::energy_account::EnergyAccount;
use super::output_rates::OutputRates;
use crate::complementarity::SolverCounters;
use crate::error::{Error, Failure, Result};
use crate::interface_model::ReducedInterfaceModel;

/// The two sides. The actuator side is the one that can use a reduced interface model, the mechanics side the one
/// that can offer it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Offers the interface model.
    Mechanics,
    /// Uses it.
    Actuator,
}

impl Side {
    /// The other side.
    pub fn other(self) -> Side {
        match self {
            Side::Mechanics => Side::Actuator,
            Side::Actuator => Side::Mechanics,
        }
    }
}

/// What a coupling variable measures.
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
    /// Magnitude below which a coupling variable counts as zero, so that the round-off of a system at rest is nothing: m,
    /// m/s, N, Pa. Ours.
    pub fn negligible(self) -> f64 {
        match self {
            Quantity::Position | Quantity::Velocity => 1e-6,
            Quantity::Force => 1e-3,
            Quantity::Pressure => 1.0,
        }
    }
}

/// One coupling variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Port {
    /// Name with unit, as it appears in data.
    pub name: &'static str,
    /// What it measures.
    pub quantity: Quantity,
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

/// Exact work counters of a subsystem.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SubsystemCounters {
    /// Micro steps taken.
    pub micro_steps: u64,
    /// Eliminations Eq. 3 → Eq. 4.
    pub eliminations: u64,
    /// Complementarity solves.
    pub solver: SolverCounters,
}

impl SubsystemCounters {
    /// Adds other counts.
    pub fn add(&mut self, other: &SubsystemCounters) {
        self.micro_steps += other.micro_steps;
        self.eliminations += other.eliminations;
        self.solver.add(&other.solver);
    }

    /// The counts on top of `earlier` ones of the same subsystem.
    pub fn since(&self, earlier: &SubsystemCounters) -> Self {
        SubsystemCounters {
            micro_steps: self.micro_steps - earlier.micro_steps,
            eliminations: self.eliminations - earlier.eliminations,
            solver: self.solver.since(&earlier.solver),
        }
    }
}

/// One side of a co-simulation, with its own solver.
///
/// The macro loop calls, at each communication point, [`outputs`](Self::outputs), then, if the scheme wants one,
/// [`interface_model`](Self::interface_model); then for each micro step `outputs` and [`step`](Self::step). There is no
/// way back: non-iterative coupling is a property of this trait. What iterates, or tries a step, works on copies.
pub trait Subsystem: Send {
    /// Names the coupling variables.
    fn ports(&self) -> &Ports;

    /// Writes the outputs `y` of the present state; `u` matters only with direct feedthrough.
    fn outputs(&self, u: &[f64], y: &mut [f64]);

    /// Advances from `t` by one micro step `h` (s) with the input held.
    ///
    /// # Errors
    /// A [`Failure`] that ends the run and becomes its outcome.
    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure>;

    /// Fills `model` with the subsystem reduced to its interface, for its own step `h`. False: it has none to offer.
    ///
    /// # Errors
    /// [`Failure::Singular`] if the constraints do not allow the reduction.
    fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        let _ = (h, model);
        Ok(false)
    }

    /// An empty interface model of the right size, or nothing if the subsystem has none to offer.
    fn empty_interface_model(&self) -> Option<ReducedInterfaceModel> {
        None
    }

    /// Writes how the outputs move at time `t` with input `u`. False: the subsystem has no directional derivatives to offer.
    fn output_rates(&self, t: f64, u: &[f64], rates: &mut OutputRates) -> bool {
        let _ = (t, u, rates);
        false
    }

    /// A copy in the present state, counters included, or nothing if the subsystem cannot be copied.
    fn try_clone(&self) -> Option<Box<dyn Subsystem>> {
        None
    }

    /// Names of the quantities that can be observed at a communication point, with units.
    fn observables(&self) -> &[&'static str] {
        &[]
    }

    /// Writes the observables of the present state; `h` is the subsystem's own step.
    fn observe(&mut self, h: f64, row: &mut [f64]) {
        let _ = (h, row);
    }

    /// Work received through the interface since the start, J, as the subsystem's own discretisation counts it.
    fn interface_work(&self) -> Option<f64> {
        None
    }

    /// Largest violation of the subsystem's own discrete energy identity in one step, J.
    fn energy_identity_residual(&self) -> Option<f64> {
        None
    }

    /// Energy account since the start, if the subsystem keeps one.
    fn energy_account(&self) -> Option<EnergyAccount> {
        None
    }

    /// Exact work counters.
    fn counters(&self) -> SubsystemCounters;
}

/// Checks that two subsystems fit: each output of one is the input of the other, by name and order.
///
/// # Errors
/// [`Error::Incompatible`] naming the ports that do not meet.
pub fn check_coupling(mechanics: &Ports, actuator: &Ports) -> Result<()> {
    let pairs = [("mechanics", mechanics, "actuator", actuator), ("actuator", actuator, "mechanics", mechanics)];
    for (from, output_side, to, input_side) in pairs {
        if output_side.outputs != input_side.inputs {
            let names = |ports: &[Port]| ports.iter().map(|port| port.name).collect::<Vec<_>>().join(", ");
            return Err(Error::Incompatible(format!(
                "the {from} side offers [{}] but the {to} side wants [{}]",
                names(&output_side.outputs),
                names(&input_side.inputs)
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
