//! `woodpecker`: a bird on a spring pecks its way down a pole. Its sleeve jams on the pole and lets go, hop by hop.
//!
//! ```text
//!        │ │
//!      ┌─┤ ├─┐                       the sleeve hangs askew and jams while its edge presses
//!      │ │ │ ├──⌇──(bird)            enough; the bird swings, turns the sleeve level, it falls,
//!      └─┤ ├─┘   spring  ▷ beak      jams the other way up, the beak pecks the pole, and back
//!        │ │
//! ```
//! Three velocities, three contacts, of which the sleeve's two edges never touch at once, an interface of one row: the spring is the actuator, its
//! length measured on a lever r, so that `k = c/r²`.
//!
//! At rest the weight hangs on one edge, and holds from a coefficient on that the levers give:
//!
//! ```text
//! μ ≥ h_M (m_M + m_S) / (m_S (l_M + l_G) − r_M (m_M + m_S)) = 0.28519
//! ```
//! **Direct feedthrough** of the actuator, through its spring. **Reference**: monolithic, h, h/2, h/4, semi-implicit.
//!
//! **Source**: Glocker 1995; Leine, Glocker, van Campen 2001; there only the beak rebounds, and only along the normal. Lever and restitution *ours*.

use super::carriage;
use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{BaseMotion, SpringActuator, SpringActuatorParameters, Woodpecker, WoodpeckerGeometry};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: names(&[
            "time_s",
            "sleeve_y_m",
            "sleeve_angle_rad",
            "bird_angle_rad",
            "interface_position_m",
            "interface_velocity_m_s",
            "actuator_force_n",
            "force_to_mechanics_n",
            "effective_mass_kg",
            "gap_beak_m",
            "gap_lower_edge_m",
            "gap_upper_edge_m",
            "contact_force_beak_n",
            "contact_force_lower_edge_n",
            "contact_force_upper_edge_n",
            "friction_force_beak_n",
            "friction_force_lower_edge_n",
            "friction_force_upper_edge_n",
            "contact_state_beak",
            "contact_state_lower_edge",
            "contact_state_upper_edge",
            "closed_contacts",
        ]),
        interface_columns: vec![carriage::interface()],
        constant_mechanics: true,
        reference: contact_parameters::reference(),
        ..Case::new(
            "woodpecker",
            "Woodpecker toy: a bird on a spring descends a pole in hops, its sleeve jams and lets go (impacts, stick, slip)",
            CaseDefaults {
                duration_s: 0.3,
                macro_step_s: 5e-4,
                micro_step_s: 1e-5,
                reference_step_s: 1e-5,
                reference_sampling_s: 5e-5,
            },
            build,
        )
    }
}

const OURS: &str = "ours";
const GLOCKER: &str = "Glocker 1995";

fn parameters() -> Vec<Parameter> {
    use Range::{Finite, NotNegative, Positive};
    let own = [
        p("sleeve_mass_kg", "kg", 3e-4, Positive, "mass m_M of the sleeve", GLOCKER),
        p("bird_mass_kg", "kg", 4.5e-3, Positive, "mass m_S of the bird", GLOCKER),
        p("sleeve_inertia_kg_m2", "kg·m²", 5e-9, Positive, "inertia J_M of the sleeve", GLOCKER),
        p("bird_inertia_kg_m2", "kg·m²", 7e-7, Positive, "inertia J_S of the bird about its centre of mass", GLOCKER),
        p("pole_radius_m", "m", 2.5e-3, Positive, "radius r_O of the pole", GLOCKER),
        p("sleeve_radius_m", "m", 3.1e-3, Positive, "inner radius r_M of the sleeve, above that of the pole", GLOCKER),
        p("sleeve_half_height_m", "m", 5.8e-3, Positive, "half the height h_M of the sleeve", GLOCKER),
        p("spring_distance_m", "m", 1e-2, Positive, "l_M from the middle of the sleeve to the spring", GLOCKER),
        p("bird_distance_m", "m", 1.5e-2, Positive, "l_G from the spring to the bird's centre of mass", GLOCKER),
        p("beak_height_m", "m", 2e-2, Positive, "h_S of the beak above the bird's centre of mass", GLOCKER),
        p("beak_length_m", "m", 2.01e-2, Positive, "l_S of the beak before the bird's centre of mass", GLOCKER),
        p("spring_stiffness_nm_rad", "N·m/rad", 5.6e-3, Positive, "torsional stiffness c of the spring", GLOCKER),
        p("spring_lever_m", "m", 1e-2, Positive, "lever r that length and force of the spring are measured on", OURS),
        p("bird_angle_rad", "rad", -0.2788, Finite, "angle φ_S of the bird at the start", GLOCKER),
        p("sleeve_velocity_m_s", "m/s", -0.3411, Finite, "velocity of the sleeve at the start", GLOCKER),
        p("bird_rate_rad_s", "rad/s", -7.4583, Finite, "angular velocity of the bird at the start", GLOCKER),
        p("gravity_m_s2", "m/s²", 9.81, NotNegative, "gravity", "standard"),
        contact_parameters::stabilisation(),
        contact_parameters::restitution(0.5, "Glocker 1995 for the beak; for all contacts ours"),
    ];
    own.into_iter().chain(contact_parameters::rebounding_friction(0.3, 0.5, GLOCKER)).collect()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let lever = get("spring_lever_m");
    let toy = Woodpecker::new(WoodpeckerGeometry {
        masses: [get("sleeve_mass_kg"), get("bird_mass_kg")],
        inertias: [get("sleeve_inertia_kg_m2"), get("bird_inertia_kg_m2")],
        pole_radius: get("pole_radius_m"),
        sleeve_radius: get("sleeve_radius_m"),
        sleeve_half_height: get("sleeve_half_height_m"),
        spring_distance: get("spring_distance_m"),
        bird_distance: get("bird_distance_m"),
        beak_height: get("beak_height_m"),
        beak_length: get("beak_length_m"),
        lever,
        bird_angle: get("bird_angle_rad"),
        velocities: [get("sleeve_velocity_m_s"), get("bird_rate_rad_s")],
        gravity: get("gravity_m_s2"),
    })?;
    let spring = SpringActuator::new(SpringActuatorParameters {
        stiffness: get("spring_stiffness_nm_rad") / (lever * lever),
        damping: 0.0,
        carriage_mass: 0.0,
        base_stiffness: 0.0,
        base_damping: 0.0,
        base: BaseMotion { position: 0.0, velocity: 0.0, amplitude: 0.0, angular_frequency: 0.0, phase: 0.0 },
        start: [0.0; 2],
    })?;
    contact_parameters::coupled(toy, spring, parameters, solver)
}
