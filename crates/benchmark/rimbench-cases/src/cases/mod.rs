//! The cases: what is simulated, with every number a named parameter. Listed in [`standard_cases`].
//!
//! A file holds a family: cases that differ in numbers and in what moves them; pages on them are in `docs/cases`. To
//! add one: declare its parameters ([`parameters!`](crate::parameters)) and write a function that describes it, in the
//! file of its family or one of its own, and add it to the list.

mod beam_on_stops;
mod beginning;
mod carriage;
mod case;
mod contacts;
mod cradle;
mod cranes;
mod discs;
mod drawing;
mod elastic_bar;
mod event_driven;
mod excavator_arm;
mod gripper;
mod half_car;
mod hardware_contact;
mod hydraulic_crane;
mod hydraulic_crane_reference;
mod hydraulics;
mod jumps;
mod lift_table;
mod mass_between_stops;
mod memory;
mod opening;
mod outside;
mod problem;
mod random_body;
mod recorder;
mod reference_method;
mod rocking_block;
mod slider_crank;
mod stops;
mod towed_block;
mod tripod;
mod two_masses;
mod wedge_box_space;
mod wedge_boxes;
mod woodpecker;

pub use beginning::{Beginning, NoBeginning, apart_in_words, beginning};
pub use case::{
    Assembly, BuildCase, Case, CaseDefaults, ChooseReference, CoupledSystem, DerivedColumn, InterfaceColumns,
    MOST_MULTIPLES, MOST_SMALL_STEPS, MOST_STEPS, PossibleSteps, Purpose, RowFunction, Scale, StateVariable,
};
pub use contacts::Contacts;
pub use discs::wall_forces;
pub use drawing::{Channel, DrawCase, Drawing, Fill, Form, Frame, Point, Shape, Solid, camera, offered_steps_ms};
pub use gripper::{Clamp, Gripper};
pub use half_car::{Car, HalfCar};
pub use jumps::JumpWatch;
pub use opening::{
    Doubts, Fault, Remedy, Tried, WHAT_REMAINS, check_step_of_model, doubts_of, first_outputs, model_against_outputs,
};
pub use outside::BuildSide;
pub use problem::problem_text;
pub use recorder::{AUDIT_COLUMNS, LAMBDA_COLUMN, Recorder, coordinate_column};
pub use reference_method::{ExactSolution, OwnIntegrator, ReferenceMethod};
pub use slider_crank::{Crank, SliderCrank};
pub use wedge_boxes::wedge_box_geometry;

/// What most cases are written with.
mod prelude {
    pub(super) use super::carriage;
    pub(super) use super::case::{
        Assembly, Case, CaseDefaults, CoupledSystem, DerivedColumn, InterfaceColumns, of_contacts, times, trace_of,
    };
    pub(super) use super::contacts::{Contacts, reference};
    pub(super) use super::drawing::{
        Channel, Drawing, Fill, Form, Frame, LIMITED_BY_ITS_STEP, Shape, Solid, body_in_space, disc, drawn, frame,
        ground, machine_in_space, points, prism, rectangle, upward, wall, wheel, within,
    };
    pub(super) use super::hydraulics::{self, Ramp};
    pub(super) use super::reference_method::{ExactSolution, ReferenceMethod};
    pub(super) use crate::models::*;
    pub(super) use crate::parameter::{ParameterSet, Parameters, choices, named, parameters};
    pub(super) use rimbench_core::error::{Error, Result};
    pub(super) use rimbench_core::name::{Name, words};
    pub(super) use std::sync::Arc;
}

/// Describes every built-in case, each with its scale, which a test compares with its reference, and the macro step at
/// which a page first shows it, the first of [`offered_steps_ms`] at which the hold fails or, where it never does, its
/// error first exceeds a tenth of the peak. One step shorter it is better, so that the slider shows how long a step may
/// be. `crane-set-down` and `hardware-contact` are shown with the first-order hold: no step on their sliders changes
/// what becomes of the zero-order hold.
pub fn standard_cases() -> Vec<Case> {
    vec![
        wedge_boxes::wedge_box().scaled(3.2, 0.28, 990.0).shown_at(2.0),
        hydraulic_crane::entry().scaled(0.6, 0.033, 11e3).shown_at(40.0),
        two_masses::linear_oscillator().scaled(4.2, 120.0, 1200.0).shown_at(4.0),
        two_masses::quarter_car().scaled(0.14, 4.5, 5300.0).shown_at(25.0),
        two_masses::precice_oscillator().scaled(0.77, 13.0, 160.0).shown_at(15.0),
        cranes::set_down().scaled(0.52, 0.02, 10e3).shown_at(25.0),
        half_car::entry().scaled(0.54, 1.6, 5100.0).shown_at(3.0),
        gripper::entry().scaled(0.64, 0.061, 2900.0).shown_at(1.0),
        lift_table::entry().scaled(0.84, 0.12, 22e3).shown_at(0.6),
        excavator_arm::entry().scaled(1.2, 0.07, 17e3).shown_at(1.5),
        discs::row().scaled(1.6, 0.12, 10e3).shown_at(2.5),
        discs::pile().scaled(1.5, 0.11, 10e3).shown_at(4.0),
        discs::packed_box().scaled(1.5, 0.064, 3100.0).shown_at(6.0),
        random_body::entry().scaled(1.2e-3, 0.2, 76.0).shown_at(2.5),
        stops::bouncing_ball().scaled(1.0, 4.2, 2.9).shown_at(20.0),
        elastic_bar::entry().scaled(1.0, 0.16, 85.0).shown_at(0.01),
        stops::impact_oscillator().scaled(0.28, 3.4, 27.0).shown_at(12.5),
        cradle::entry().scaled(0.1, 0.52, 0.2).shown_at(15.0),
        stops::slider().scaled(0.1, 2.3, 55.0).shown_at(40.0),
        mass_between_stops::entry().scaled(0.86, 0.28, 21e3).shown_at(1.5),
        hardware_contact::entry().scaled(0.07, 0.1, 230.0).shown_at(10.0),
        rocking_block::entry().scaled(1.9, 0.1, 4100.0).shown_at(1.25),
        beam_on_stops::entry().scaled(0.044, 0.46, 84.0).shown_at(6.0),
        wedge_boxes::n_wedge_box().scaled(3.2, 0.28, 990.0).shown_at(2.0),
        wedge_boxes::two_ledges().scaled(3.3, 0.28, 1100.0).shown_at(2.5),
        wedge_boxes::reversal().scaled(2.7, 0.28, 1100.0).shown_at(2.0),
        wedge_boxes::with_friction().scaled(2.6, 0.28, 1800.0).shown_at(2.0),
        towed_block::entry().scaled(0.35, 0.24, 5.3).shown_at(25.0),
        rocking_block::with_friction().scaled(1.8, 0.4, 39.0).shown_at(1.5),
        cranes::drag().scaled(0.53, 8.5e-3, 8600.0).shown_at(50.0),
        slider_crank::entry().scaled(2.3, 24.0, 340.0).shown_at(0.5),
        woodpecker::entry().scaled(4.2e-3, 0.18, 0.24).shown_at(6.0),
        tripod::entry().scaled(1.8, 0.3, 1600.0).shown_at(2.0),
        tripod::four_legs().scaled(1.8, 0.3, 1600.0).shown_at(2.0),
        wedge_box_space::entry().scaled(3.2, 0.28, 1800.0).shown_at(1.5),
    ]
}
