//! The cases: what is simulated, with every number a named parameter. Listed in [`CASES`].
//!
//! To add one: write a file with an `ENTRY`, and add it to the list.

mod case;
mod parameters;
mod recorder;
mod wedge_box;

pub use case::{Case, CaseDefaults, CoupledSystem, InterfaceColumns, case_by_name};
pub use parameters::{Parameter, Parameters, Range, Value};
pub use recorder::Recorder;

/// Every case.
pub const CASES: &[Case] = &[wedge_box::ENTRY];
