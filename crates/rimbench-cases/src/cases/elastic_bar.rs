//! `elastic-bar`: an elastic bar falls on a rigid floor and leaves again after a wave has run up and down.
//!
//! ```text
//!      base ▒▒
//!        ≷ k_b
//!      [m_a] carriage
//!        ≷ k, c                    F > 0 pushes the top up
//!      ┌───┐ node N, top
//!      │   │                       N elements of length L/N, lumped masses
//!      │   │ v = −0.1 m/s
//!      └───┘ node 0
//!   ═══════════ floor, gap g at the start
//! ```
//! N + 1 velocities, one contact. Wave theory without the actuator (c = √(E/ρ)): impact at g/|v| = 5e-4 s; the floor pushes with
//! ρ c S |v| = 1270.83 N for 2L/c = 3.8545e-4 s; the bar then leaves as a rigid body with −v. A lumped bar rings, so the *mean*
//! force over the contact is the quantity to compare; the contact of node 0 is plastic, which loses half the kinetic energy of that node,
//! a fraction that falls with 1/N.
//!
//! The mechanics' own step is stable below the time in which a wave crosses an element, L/(N c) = 9.6 µs at the defaults; steps of the
//! second order are stable beyond.
//!
//! **Direct feedthrough** of the actuator, through its spring. **Reference**: monolithic, h, h/2, h/4.
//!
//! **Source**: the impacting bar of the computational contact literature (e.g. Doyen, Ern, Piperno 2011); the numbers are those of
//! the published benchmark; the actuator is *ours*.

use super::carriage;
use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{LineContact, LineDescription, LineMass, LineMasses, LineSpring};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: carriage::trace_columns(&[
            "carriage_position_m",
            "effective_mass_kg",
            "bottom_x_m",
            "bottom_velocity_m_s",
            "gap_floor_m",
            "contact_force_floor_n",
            "closed_contacts",
        ]),
        drawing_columns: names(&["carriage_velocity_m_s"]),
        interface_columns: vec![carriage::interface()],
        reference: contact_parameters::reference(),
        ..Case::new(
            "elastic-bar",
            "Elastic bar of N elements that falls on a rigid floor under a carriage on springs (wave theory)",
            CaseDefaults {
                duration_s: 1.2e-3,
                macro_step_s: 5e-6,
                micro_step_s: 5e-7,
                reference_step_s: 5e-7,
                reference_sampling_s: 1e-6,
            },
            build,
        )
    }
}

const OURS: &str = "ours";
const BENCHMARK: &str = "impacting-bar benchmark";

fn parameters() -> Vec<Parameter> {
    use Range::{Finite, NotNegative, Positive, Whole};
    vec![
        p("elements", "-", 20.0, Whole(1, MOST_ELEMENTS), "number of elements N", OURS),
        p("length_m", "m", 1.0, Positive, "length L", BENCHMARK),
        p("section_m2", "m²", 3.14e-4, Positive, "cross-section S", BENCHMARK),
        p("youngs_modulus_pa", "Pa", 210e9, Positive, "Young's modulus E", BENCHMARK),
        p("density_kg_m3", "kg/m³", 7800.0, Positive, "density ρ", BENCHMARK),
        p("start_gap_m", "m", 5e-5, NotNegative, "gap between bar and floor at the start", BENCHMARK),
        p("start_velocity_m_s", "m/s", -0.1, Finite, "velocity of the bar at the start, upwards", BENCHMARK),
        carriage::stiffness(1e6),
        carriage::damping(0.0),
        carriage::mass(0.5),
        carriage::base_stiffness(1e5),
        carriage::base_damping(0.0),
        carriage::base_position(1.00005),
        carriage::base_amplitude(0.0),
        carriage::base_frequency(0.0),
        carriage::base_phase(0.0),
        carriage::start_position(1.00005),
        carriage::start_velocity(-0.1),
        contact_parameters::restitution(0.0, "plastic node"),
        contact_parameters::stabilisation(),
    ]
}

/// Most elements that make sense here: the step shrinks with them.
const MOST_ELEMENTS: u32 = 500;

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let count = parameters.whole("elements");
    let n = count as usize;
    let element = get("length_m") / f64::from(count);
    let element_mass = get("density_kg_m3") * get("section_m2") * element;
    let node = |index: usize| LineMass {
        mass: if index == 0 || index == n { 0.5 * element_mass } else { element_mass },
        stiffness: 0.0,
        damping: 0.0,
        anchor: 0.0,
        load: 0.0,
        start: [get("start_gap_m") + index as f64 * element, get("start_velocity_m_s")],
    };
    let spring = |index: usize| LineSpring {
        between: [index, index + 1],
        stiffness: get("youngs_modulus_pa") * get("section_m2") / element,
        length: element,
    };
    let model = LineMasses::new(LineDescription {
        masses: (0..=n).map(node).collect(),
        springs: (0..n).map(spring).collect(),
        joints: Vec::new(),
        contacts: vec![LineContact { below: None, above: Some(0), distance: 0.0 }],
        driven: n,
        state_names: names(&["bottom_x_m", "bottom_velocity_m_s"]),
        gap_names: names(&["gap_floor_m"]),
        contact_force_names: names(&["contact_force_floor_n"]),
    })?;
    contact_parameters::coupled(model, carriage::actuator(parameters)?, parameters, solver)
}
