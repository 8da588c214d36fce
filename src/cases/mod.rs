//! The cases: what is simulated, with every number a named parameter. Listed in [`CASES`].
//!
//! To add one: write a file with an `ENTRY`, and add it to the list.

mod case;
mod fluid;
mod hydraulic_crane;
mod hydraulic_crane_reference;
mod linear_oscillator;
mod parameters;
mod precice_oscillator;
mod quarter_car;
mod recorder;
mod reference_method;
mod registry;
mod two_masses;
mod wedge_box;

pub use case::{Case, CaseDefaults, CoupledSystem, DerivedColumn, InterfaceColumns, RowFunction, StateVariable};
pub use parameters::{Parameter, Parameters, Range, Value};
pub use recorder::Recorder;
pub use reference_method::{ExactSolution, ReferenceMethod};
pub use registry::{all_cases, case_by_name, register};

/// Every built-in case.
pub const CASES: &[Case] = &[
    wedge_box::ENTRY,
    hydraulic_crane::ENTRY,
    linear_oscillator::ENTRY,
    quarter_car::ENTRY,
    precice_oscillator::ENTRY,
];
