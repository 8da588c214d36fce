//! `slider-between-stops`: a slider with play between two stops, pushed to and fro by a carriage on springs.
//!
//! ```text
//!   base ▒▒──k_b,c_b──[m_a]──k,c──( m )
//!   A sin(ωt + φ)      carriage   │ x → │
//!                                −d     +d   stops, restitution e
//! ```
//! One velocity, two contacts of which at most one is closed. The carriage runs further than the stops allow, so that the slider
//! is caught, bounces, is pressed against the stop, and let go.
//!
//! **Direct feedthrough** of the actuator, through its spring and damper. **Reference**: exact, from impact to impact by matrix
//! exponentials, rest on a stop included.
//!
//! **Source**: the spring-driven slider of the impact literature (play between stops); numbers *ours*.

use super::carriage;
use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::driven_mass::{self, StopNames};
use super::event_driven::{DrivenMass, Stop};
use super::parameters::{Parameter, Parameters, Range, number as p};
use super::reference_method::{ExactSolution, ReferenceMethod};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;
use std::sync::Arc;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: carriage::trace_columns(&[
            "carriage_position_m",
            "carriage_velocity_m_s",
            "effective_mass_kg",
            "gap_lower_stop_m",
            "gap_upper_stop_m",
            "closed_contacts",
        ]),
        interface_columns: vec![carriage::interface()],
        reference: Arc::new(|parameters| exact(parameters).map(ReferenceMethod::Exact)),
        constant_mechanics: true,
        ..Case::new(
            "slider-between-stops",
            "Slider between two stops, driven by a carriage on springs (exact between impacts)",
            CaseDefaults {
                duration_s: 3.0,
                macro_step_s: 5e-3,
                micro_step_s: 5e-4,
                reference_step_s: 1e-4,
                reference_sampling_s: 2e-4,
            },
            build,
        )
    }
}

const OURS: &str = "ours";

fn parameters() -> Vec<Parameter> {
    vec![
        p("mass_kg", "kg", 2.0, Range::Positive, "mass m of the slider", OURS),
        p("damping_n_s_m", "N·s/m", 0.0, Range::NotNegative, "damping between slider and ground", OURS),
        p("clearance_m", "m", 0.1, Range::NotNegative, "distance d of either stop from x = 0", OURS),
        p("start_position_m", "m", 0.0, Range::Finite, "position of the slider at the start", OURS),
        p("start_velocity_m_s", "m/s", 0.0, Range::Finite, "velocity of the slider at the start", OURS),
        carriage::stiffness(500.0),
        carriage::damping(5.0),
        carriage::mass(0.5),
        carriage::base_stiffness(1000.0),
        carriage::base_damping(20.0),
        carriage::base_position(0.0),
        carriage::base_amplitude(0.25),
        carriage::base_frequency(1.0),
        carriage::base_phase(0.0),
        carriage::start_position(0.0),
        carriage::start_velocity(0.0),
        contact_parameters::restitution(0.5, OURS),
        contact_parameters::stabilisation(),
    ]
}

fn slider(parameters: &Parameters) -> Result<DrivenMass> {
    let get = |name: &str| parameters.number(name);
    let clearance = get("clearance_m");
    let slider = DrivenMass {
        mass: get("mass_kg"),
        stiffness: 0.0,
        damping: get("damping_n_s_m"),
        load: 0.0,
        start: [get("start_position_m"), get("start_velocity_m_s")],
        stops: vec![Stop { side: 1.0, position: -clearance }, Stop { side: -1.0, position: clearance }],
        restitution: get("restitution"),
        actuator: carriage::of(parameters),
    };
    driven_mass::check_start(&slider, "start_position_m")?;
    Ok(slider)
}

fn exact(parameters: &Parameters) -> Result<ExactSolution> {
    Ok(driven_mass::solution(slider(parameters)?))
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let names = StopNames {
        gaps: names(&["gap_lower_stop_m", "gap_upper_stop_m"]),
        forces: names(&["contact_force_lower_stop_n", "contact_force_upper_stop_n"]),
    };
    driven_mass::system(slider(parameters)?, &names, parameters, solver)
}
