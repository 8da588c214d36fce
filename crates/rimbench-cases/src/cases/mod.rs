//! The cases: what is simulated, with every number a named parameter. Listed in [`standard_cases`].
//!
//! To add one: write a file with a function `entry`, and add it to the list.

mod beam_on_stops;
mod bouncing_ball;
mod carriage;
mod case;
mod contact_parameters;
mod cradle;
mod crane_drag;
mod crane_heap;
mod crane_set_down;
mod cylinder;
mod disc_pile;
mod disc_row;
mod driven_mass;
mod elastic_bar;
mod event_driven;
mod falling_chain;
mod fluid;
mod gripper;
mod gripper_friction;
mod half_car;
mod half_car_braking;
mod hydraulic_crane;
mod hydraulic_crane_reference;
mod hydraulics;
mod impact_oscillator;
mod linear_oscillator;
mod loader;
mod memory;
mod n_wedge_box;
mod outside;
mod packed_box;
mod parameters;
mod precice_oscillator;
mod quarter_car;
mod recorder;
mod reference_method;
mod rocking_block;
mod rocking_block_friction;
mod slider_between_stops;
mod slider_crank;
mod towed_block;
mod two_masses;
mod wedge_box;
mod wedge_box_friction;
mod wedge_box_reversal;
mod wedge_box_two_ledges;
mod woodpecker;

pub use case::{
    BuildCase, Case, CaseDefaults, ChooseReference, CoupledSystem, DerivedColumn, InterfaceColumns, RowFunction,
    StateVariable,
};
pub use falling_chain::Chain;
pub use outside::BuildSide;
pub use packed_box::wall_forces;
pub use parameters::{Parameter, Parameters, Range, Value};
pub use recorder::Recorder;
pub use reference_method::{ExactSolution, OwnIntegrator, ReferenceMethod};
pub use wedge_box::wedge_box_geometry;

/// Describes every built-in case.
pub fn standard_cases() -> Vec<Case> {
    vec![
        wedge_box::entry(),
        hydraulic_crane::entry(),
        linear_oscillator::entry(),
        quarter_car::entry(),
        precice_oscillator::entry(),
        crane_set_down::entry(),
        half_car::entry(),
        gripper::entry(),
        disc_row::entry(),
        disc_pile::entry(),
        packed_box::entry(),
        falling_chain::entry(),
        crane_heap::entry(),
        bouncing_ball::entry(),
        elastic_bar::entry(),
        impact_oscillator::entry(),
        cradle::entry(),
        slider_between_stops::entry(),
        rocking_block::entry(),
        beam_on_stops::entry(),
        n_wedge_box::entry(),
        wedge_box_two_ledges::entry(),
        wedge_box_reversal::entry(),
        wedge_box_friction::entry(),
        towed_block::entry(),
        half_car_braking::entry(),
        gripper_friction::entry(),
        rocking_block_friction::entry(),
        crane_drag::entry(),
        slider_crank::entry(),
        woodpecker::entry(),
    ]
}
