//! What the list of cases holds about each one.

use super::parameters::{Parameter, Parameters};
use super::reference_method::ReferenceMethod;
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::cosim::{Ports, Quantity, Subsystem};
use rimbench_core::error::Result;

/// Two subsystems that fit each other, and how the case wants them run and recorded.
pub struct CoupledSystem {
    /// The side that may offer an interface model.
    pub mechanics: Box<dyn Subsystem>,
    /// The side that may use it.
    pub actuator: Box<dyn Subsystem>,
    /// Outputs with direct feedthrough are evaluated with the input used last, not with the fresh one.
    pub stale_feedthrough: bool,
    /// Each row of the trace holds the values of the communication point before (a quirk of a published driver).
    pub late_rows: bool,
    /// Columns that neither side knows alone.
    pub derived: Vec<DerivedColumn>,
}

impl CoupledSystem {
    /// Two subsystems that are run and recorded in the usual way.
    pub fn new(mechanics: Box<dyn Subsystem>, actuator: Box<dyn Subsystem>) -> Self {
        CoupledSystem { mechanics, actuator, stale_feedthrough: false, late_rows: false, derived: Vec::new() }
    }
}

/// The ports of the mechanics that meet those of a force-producing actuator.
pub(super) fn facing(actuator: &Ports) -> Ports {
    debug_assert!(actuator.outputs.iter().all(|port| port.quantity == Quantity::Force));
    Ports { inputs: actuator.outputs.clone(), outputs: actuator.inputs.clone(), direct_feedthrough: false }
}

/// A number from some columns of a row.
pub type RowFunction = Box<dyn Fn(&[f64]) -> f64 + Send>;

/// A column computed from others of the same row, for example the energy of the whole system.
pub struct DerivedColumn {
    /// Name with unit.
    pub name: &'static str,
    /// The columns it is computed from.
    pub from: &'static [&'static str],
    /// Its value, given theirs in the same order.
    pub value: RowFunction,
}

/// A state variable of a linear case that can be set and seen: what a spectral radius is probed with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StateVariable {
    /// The parameter that holds its start value.
    pub initial: &'static str,
    /// The column that records it.
    pub column: &'static str,
}

/// Times used unless others are asked for, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaseDefaults {
    /// Simulated time.
    pub duration_s: f64,
    /// Macro step.
    pub macro_step_s: f64,
    /// Longest micro step of the actuator side.
    pub micro_step_s: f64,
    /// Coarsest of the three steps of the monolithic reference.
    pub reference_step_s: f64,
    /// Distance of the stored points of the reference.
    pub reference_sampling_s: f64,
}

/// Which columns hold the coupling variables of one row of the interface, by which accuracy is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InterfaceColumns {
    /// Position along the interface.
    pub position: &'static str,
    /// Velocity along the interface.
    pub velocity: &'static str,
    /// Force across the interface.
    pub force: &'static str,
}

/// A case by name.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Kebab-case name.
    pub name: &'static str,
    /// One line.
    pub about: &'static str,
    /// Everything that can be set.
    pub parameters: &'static [Parameter],
    /// Times.
    pub defaults: CaseDefaults,
    /// Columns of a trace, in order; the first is the time.
    pub trace_columns: &'static [&'static str],
    /// Further columns, not in the trace: for drawings, and what metrics need.
    pub drawing_columns: &'static [&'static str],
    /// What accuracy is judged by: one entry per row of the interface. With several the worst row counts.
    pub interface_columns: &'static [InterfaceColumns],
    /// All state variables, positions first, then their velocities in the same order, if the case is linear for at
    /// least some of its parameters; else none.
    pub linear_state: &'static [StateVariable],
    /// What runs with these parameters are held against.
    pub reference: fn(&Parameters) -> ReferenceMethod,
    /// Builds both sides. The solver serves the complementarity problems of the mechanics.
    pub build: fn(&Parameters, &SolverEntry) -> Result<CoupledSystem>,
}

impl Case {
    /// The parameters at their defaults.
    pub fn default_parameters(&self) -> Parameters {
        Parameters::defaults(self.name, self.parameters)
    }

    /// All columns that a run records: those of the trace, then those of drawings.
    pub fn recorded_columns(&self) -> Vec<String> {
        self.trace_columns.iter().chain(self.drawing_columns).map(|name| (*name).to_owned()).collect()
    }
}
