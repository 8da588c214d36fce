//! `cradle`: three equal balls in a row, two of them touching, on pendulums. Moreau's law decides who moves on.
//!
//! ```text
//!   base ▒▒──[m_a]──(1)→   (2)(3)        each ball on a pendulum of frequency √(g/l), rest positions 0, D, 2D
//!             k,c    x₁     x₂ x₃        two contacts, restitution e
//! ```
//! Three velocities, two contacts. The first ball is released to the left and hits the resting pair in the middle of its swing.
//! Moreau's law puts Newton's restitution on all closed contacts at once, `0 ≤ w⁺ + e w⁻ ⟂ P ≥ 0`; for e = 1 the velocities
//! (v, 0, 0) become (−1/3, 2/3, 2/3) v, not the (0, 0, 1) v of the toy on the desk, which needs impacts one after the other. Half
//! a swing later all three meet again in the middle and the law returns (v, 0, 0) → period 2. Energy is kept.
//!
//! **Direct feedthrough** of the actuator, through its spring. **Reference**: monolithic, h, h/2, h/4. The impact law holds with
//! the actuator too, because its force is finite and has no impulse. The law is discontinuous in its data: who of the three meets
//! first decides. With the actuator the balls meet out of step, and from the fourth meeting (2.1 s) on a finer step finds another
//! order, so that there is no reference; the case ends before.
//!
//! **Source**: Moreau 1988, Glocker 2001 (Newton's cradle and generalised impact laws); numbers *ours*.

use super::carriage;
use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{LineContact, LineDescription, LineMass, LineMasses};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::{Error, Result};
use rimbench_core::name::names;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: carriage::trace_columns(&[
            "carriage_position_m",
            "ball_2_x_m",
            "ball_3_x_m",
            "ball_2_velocity_m_s",
            "ball_3_velocity_m_s",
            "effective_mass_kg",
            "gap_1_2_m",
            "gap_2_3_m",
            "closed_contacts",
            "rank_h_uu",
        ]),
        drawing_columns: names(&["carriage_velocity_m_s", "contact_force_1_2_n", "contact_force_2_3_n"]),
        interface_columns: vec![carriage::interface()],
        constant_mechanics: true,
        ..Case::new(
            "cradle",
            "Three balls on pendulums under Moreau's impact law, the first held by a carriage on springs",
            CaseDefaults {
                duration_s: 1.8,
                macro_step_s: 5e-3,
                micro_step_s: 5e-4,
                reference_step_s: 1e-5,
                reference_sampling_s: 2e-4,
            },
            build,
        )
    }
}

const OURS: &str = "ours";

fn parameters() -> Vec<Parameter> {
    vec![
        p("ball_mass_kg", "kg", 1.0, Range::Positive, "mass of each ball", OURS),
        p("ball_diameter_m", "m", 0.1, Range::Positive, "diameter D", OURS),
        p("pendulum_frequency_rad_s", "rad/s", 5.0, Range::NotNegative, "√(g/l) of each pendulum; small angles", OURS),
        p(
            "start_position_m",
            "m",
            -0.1,
            Range::Finite,
            "position of the first ball at the start; it touches at 0",
            OURS,
        ),
        carriage::stiffness(2.0),
        carriage::damping(0.0),
        carriage::mass(0.2),
        carriage::base_stiffness(4.0),
        carriage::base_damping(0.0),
        carriage::base_position(0.0),
        carriage::base_amplitude(0.0),
        carriage::base_frequency(0.0),
        carriage::base_phase(0.0),
        carriage::start_position(0.0),
        carriage::start_velocity(0.0),
        contact_parameters::restitution(1.0, "Moreau 1988"),
        contact_parameters::stabilisation(),
    ]
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let (diameter, start) = (get("ball_diameter_m"), get("start_position_m"));
    if start > 0.0 {
        let expected = format!("at most 0 m, where ball 1 touches ball 2; it would start {start} m inside");
        return Err(Error::invalid("start_position_m", start, expected));
    }
    let ball = |index: usize| LineMass {
        mass: get("ball_mass_kg"),
        stiffness: get("ball_mass_kg") * get("pendulum_frequency_rad_s").powi(2),
        damping: 0.0,
        anchor: index as f64 * diameter,
        load: 0.0,
        start: [if index == 0 { start } else { index as f64 * diameter }, 0.0],
    };
    let contact = |below: usize| LineContact { below: Some(below), above: Some(below + 1), distance: diameter };
    let model = LineMasses::new(LineDescription {
        masses: (0..3).map(ball).collect(),
        springs: Vec::new(),
        joints: Vec::new(),
        contacts: vec![contact(0), contact(1)],
        driven: 0,
        state_names: names(&[
            "ball_1_x_m",
            "ball_2_x_m",
            "ball_3_x_m",
            "ball_1_velocity_m_s",
            "ball_2_velocity_m_s",
            "ball_3_velocity_m_s",
        ]),
        gap_names: names(&["gap_1_2_m", "gap_2_3_m"]),
        contact_force_names: names(&["contact_force_1_2_n", "contact_force_2_3_n"]),
    })?;
    contact_parameters::coupled(model, carriage::actuator(parameters)?, parameters, solver)
}
