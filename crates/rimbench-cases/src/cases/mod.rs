//! The cases: what is simulated, with every number a named parameter. Listed in [`standard_cases`].
//!
//! A file holds a family: cases that differ in numbers and in what moves them; pages on them are in `docs/cases`. To add one: declare
//! its parameters ([`parameters!`](crate::parameters)) and write a function that describes it, in the file of its family or one of its
//! own, and add it to the list.

mod beam_on_stops;
mod carriage;
mod case;
mod contacts;
mod cradle;
mod cranes;
mod declaration;
mod discs;
mod drawing;
mod elastic_bar;
mod event_driven;
mod falling_chain;
mod gripper;
mod half_car;
mod hydraulic_crane;
mod hydraulic_crane_reference;
mod hydraulics;
mod lift_table;
mod memory;
mod opening;
mod outside;
mod parameters;
mod random_body;
mod recorder;
mod reference_method;
mod rocking_block;
mod scales;
mod slider_crank;
mod stops;
mod towed_block;
mod tripod;
mod two_masses;
mod values;
mod wedge_box_space;
mod wedge_boxes;
mod woodpecker;

pub use case::{
    Assembly, BuildCase, Case, CaseDefaults, ChooseReference, CoupledSystem, DerivedColumn, InterfaceColumns,
    PossibleSteps, Purpose, RowFunction, Scale, StateVariable,
};
pub use contacts::Contacts;
pub use declaration::{ParameterSet, choices, named, parameters};
#[doc(hidden)]
pub use declaration::{changed, with_changes};
pub use discs::wall_forces;
pub use drawing::{
    Channel, DrawCase, Drawing, Fill, Form, Frame, Point, Shape, Solid, camera, offered_steps_ms, shown_step_ms,
};
pub use falling_chain::Chain;
pub use gripper::{Clamp, Gripper};
pub use half_car::{Car, HalfCar};
pub use opening::{Doubts, WHAT_REMAINS, doubts_of, first_outputs};
pub use outside::BuildSide;
pub use parameters::{Parameter, Parameters};
pub use recorder::{AUDIT_COLUMNS, Recorder};
pub use reference_method::{ExactSolution, OwnIntegrator, ReferenceMethod};
pub use slider_crank::{Crank, SliderCrank};
pub use values::{Range, Setting, Value, unit_of, without_unit};
pub use wedge_boxes::wedge_box_geometry;

/// What most cases are written with.
mod prelude {
    pub(super) use super::carriage;
    pub(super) use super::case::{Assembly, Case, CaseDefaults, CoupledSystem, DerivedColumn, InterfaceColumns, times};
    pub(super) use super::contacts::{Contacts, reference};
    pub(super) use super::declaration::{ParameterSet, choices, named, parameters};
    pub(super) use super::drawing::{
        Channel, Drawing, Fill, Form, Frame, Shape, Solid, body_in_space, disc, drawn, frame, ground, machine_in_space,
        points, prism, rectangle, upward, wall, wheel, within,
    };
    pub(super) use super::hydraulics::{self, Ramp};
    pub(super) use super::parameters::Parameters;
    pub(super) use super::reference_method::{ExactSolution, ReferenceMethod};
    pub(super) use crate::models::*;
    pub(super) use rimbench_core::error::{Error, Result};
    pub(super) use rimbench_core::name::{Name, words};
    pub(super) use std::sync::Arc;
}

/// Describes every built-in case.
pub fn standard_cases() -> Vec<Case> {
    let cases = [
        wedge_boxes::wedge_box(),
        hydraulic_crane::entry(),
        two_masses::linear_oscillator(),
        two_masses::quarter_car(),
        two_masses::precice_oscillator(),
        cranes::set_down(),
        half_car::entry(),
        gripper::entry(),
        lift_table::entry(),
        discs::row(),
        discs::pile(),
        discs::packed_box(),
        falling_chain::entry(),
        cranes::heap(),
        random_body::entry(),
        stops::bouncing_ball(),
        elastic_bar::entry(),
        stops::impact_oscillator(),
        cradle::entry(),
        stops::slider(),
        rocking_block::entry(),
        beam_on_stops::entry(),
        wedge_boxes::n_wedge_box(),
        wedge_boxes::two_ledges(),
        wedge_boxes::reversal(),
        wedge_boxes::with_friction(),
        towed_block::entry(),
        rocking_block::with_friction(),
        cranes::drag(),
        slider_crank::entry(),
        woodpecker::entry(),
        tripod::entry(),
        tripod::four_legs(),
        wedge_box_space::entry(),
    ];
    cases.into_iter().map(|case| Case { scale: scales::scale_of(&case.name), ..case }).collect()
}
