//! The cases: what is simulated, with every number a named parameter. Listed in [`CASES`].
//!
//! To add one: write a file with an `ENTRY`, and add it to the list.

mod beam_on_stops;
mod bouncing_ball;
mod carriage;
mod case;
mod contact_parameters;
mod cradle;
mod crane_set_down;
mod cylinder;
mod disc_pile;
mod disc_row;
mod driven_mass;
mod elastic_bar;
mod event_driven;
mod fluid;
mod gripper;
mod half_car;
mod hydraulic_crane;
mod hydraulic_crane_reference;
mod hydraulics;
mod impact_oscillator;
mod linear_oscillator;
mod loader;
mod n_wedge_box;
mod parameters;
mod precice_oscillator;
mod quarter_car;
mod recorder;
mod reference_method;
mod registry;
mod rocking_block;
mod slider_between_stops;
mod two_masses;
mod wedge_box;
mod wedge_box_two_ledges;

pub use case::{Case, CaseDefaults, CoupledSystem, DerivedColumn, InterfaceColumns, RowFunction, StateVariable};
pub use parameters::{Parameter, Parameters, Range, Value};
pub use recorder::Recorder;
pub use reference_method::{ExactSolution, ReferenceMethod};
pub use registry::{all_cases, case_by_name, register};
pub use wedge_box::wedge_box_geometry;

/// Every built-in case.
pub const CASES: &[Case] = &[
    wedge_box::ENTRY,
    hydraulic_crane::ENTRY,
    linear_oscillator::ENTRY,
    quarter_car::ENTRY,
    precice_oscillator::ENTRY,
    crane_set_down::ENTRY,
    half_car::ENTRY,
    gripper::ENTRY,
    disc_row::ENTRY,
    disc_pile::ENTRY,
    bouncing_ball::ENTRY,
    elastic_bar::ENTRY,
    impact_oscillator::ENTRY,
    cradle::ENTRY,
    slider_between_stops::ENTRY,
    rocking_block::ENTRY,
    beam_on_stops::ENTRY,
    n_wedge_box::ENTRY,
    wedge_box_two_ledges::ENTRY,
];
