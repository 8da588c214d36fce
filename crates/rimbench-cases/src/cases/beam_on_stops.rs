//! `beam-on-stops`: a flexible beam that a shaken spring presses against two stops.
//!
//! ```text
//!             base  x_b(t)
//!               ≷ k_b,c_b
//!             [m_a] carriage
//!               ≷ k, c                     F > 0 pulls the beam up
//!   ▒├──────────●──────────────────┤       clamped (or pinned at both ends), N modes
//!              ▲ stop 2           ▲ stop 1      clearances below the straight beam
//! ```
//! N velocities (modal coordinates), two contacts. The beam is slender (Euler–Bernoulli), undamped modes would be those of the textbook.
//! The base goes down and up, x_b = x₀ + A sin(ωt + φ); pressed down, the beam lands on one stop, wraps itself around it, and on the
//! other, and its modes ring.
//!
//! The mechanics' own step is stable below 2/ω_N, 5.5 ms at the defaults (N = 4, ω₄ = 362 rad/s); steps of the second order are stable
//! beyond.
//!
//! **Direct feedthrough** of the actuator, through its spring and damper. **Reference**: monolithic, h, h/2, h/4. The beam itself is
//! checked against textbook frequencies and closed-form deflections.
//!
//! **Source**: modes from Blevins; numbers *ours*.

use super::carriage;
use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{BeamGeometry, BeamStop, BeamSupport, MOST_MODES, ModalBeam};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;
use std::f64::consts::FRAC_PI_2;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: carriage::trace_columns(&[
            "carriage_position_m",
            "end_deflection_m",
            "effective_mass_kg",
            "gap_stop_1_m",
            "gap_stop_2_m",
            "closed_contacts",
            "rank_h_uu",
        ]),
        drawing_columns: names(&["carriage_velocity_m_s", "contact_force_stop_1_n", "contact_force_stop_2_n"]),
        interface_columns: vec![carriage::interface()],
        reference: contact_parameters::reference(),
        ..Case::new(
            "beam-on-stops",
            "Bending beam in N modes, pressed against two stops by a carriage on springs",
            CaseDefaults {
                duration_s: 3.0,
                macro_step_s: 2e-3,
                micro_step_s: 2e-4,
                reference_step_s: 5e-5,
                reference_sampling_s: 2e-4,
            },
            build,
        )
    }
}

const OURS: &str = "ours";

fn parameters() -> Vec<Parameter> {
    use Range::{NotNegative, Positive, Whole};
    vec![
        Parameter::choice("beam_support", ["clamped", "pinned"], "clamped at one end, or pinned at both", OURS),
        p("modes", "-", 4.0, Whole(1, MOST_MODES as u32), "number of modes N", OURS),
        p("length_m", "m", 2.0, Positive, "length L", OURS),
        p("width_m", "m", 0.04, Positive, "width of the section", OURS),
        p("thickness_m", "m", 0.008, Positive, "thickness of the section", OURS),
        p("youngs_modulus_pa", "Pa", 210e9, Positive, "Young's modulus E", "steel"),
        p("density_kg_m3", "kg/m³", 7800.0, Positive, "density ρ", "steel"),
        p("damping_ratio", "-", 0.01, NotNegative, "damping ratio ζ of all modes", OURS),
        p("actuator_position_m", "m", 1.2, NotNegative, "where the actuator holds the beam, from the left end", OURS),
        p("stop_1_position_m", "m", 2.0, NotNegative, "where stop 1 is, from the left end", OURS),
        p("stop_1_clearance_m", "m", 0.05, NotNegative, "distance of stop 1 below the straight beam", OURS),
        p("stop_2_position_m", "m", 0.8, NotNegative, "where stop 2 is, from the left end", OURS),
        p("stop_2_clearance_m", "m", 0.03, NotNegative, "distance of stop 2 below the straight beam", OURS),
        carriage::stiffness(2000.0),
        carriage::damping(2.0),
        carriage::mass(0.5),
        carriage::base_stiffness(4000.0),
        carriage::base_damping(10.0),
        carriage::base_position(-0.05),
        carriage::base_amplitude(0.05),
        carriage::base_frequency(1.0),
        carriage::base_phase(FRAC_PI_2),
        carriage::start_position(0.0),
        carriage::start_velocity(0.0),
        contact_parameters::stabilisation(),
        contact_parameters::restitution(0.0, "plastic"),
    ]
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let modes = parameters.whole("modes");
    let (width, thickness) = (get("width_m"), get("thickness_m"));
    let stop = |position: &str, clearance: &str| BeamStop { position: get(position), clearance: get(clearance) };
    let model = ModalBeam::new(BeamGeometry {
        support: match parameters.choice("beam_support") {
            "pinned" => BeamSupport::Pinned,
            _ => BeamSupport::Clamped,
        },
        length: get("length_m"),
        bending_stiffness: get("youngs_modulus_pa") * width * thickness.powi(3) / 12.0,
        mass_per_length: get("density_kg_m3") * width * thickness,
        damping_ratio: get("damping_ratio"),
        modes: modes as usize,
        stops: [stop("stop_1_position_m", "stop_1_clearance_m"), stop("stop_2_position_m", "stop_2_clearance_m")],
        actuator_position: get("actuator_position_m"),
    })?;
    contact_parameters::coupled(model, carriage::actuator(parameters)?, parameters, solver)
}
