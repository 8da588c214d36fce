//! `woodpecker`: a bird on a spring pecks its way down a pole; its sleeve jams on the pole and lets go, hop by hop. The spring is the actuator, its
//! length measured on a lever r, so that `k = c/r²`. Shown in `docs/cases/woodpecker.md`; after Glocker 1995 and Leine, Glocker, van Campen 2001,
//! where only the beak rebounds, and only along the normal; lever and restitution *ours*.

use super::prelude::*;

const PARAMETERS: &str = "source: Glocker 1995
    sleeve_mass_kg | kg | 3e-4 | positive | mass m_M of the sleeve
    bird_mass_kg | kg | 4.5e-3 | positive | mass m_S of the bird
    sleeve_inertia_kg_m2 | kg·m² | 5e-9 | positive | inertia J_M of the sleeve
    bird_inertia_kg_m2 | kg·m² | 7e-7 | positive | inertia J_S of the bird about its centre of mass
    pole_radius_m | m | 2.5e-3 | positive | radius r_O of the pole
    sleeve_radius_m | m | 3.1e-3 | positive | inner radius r_M of the sleeve, above that of the pole
    sleeve_half_height_m | m | 5.8e-3 | positive | half the height h_M of the sleeve
    spring_distance_m | m | 1e-2 | positive | l_M from the middle of the sleeve to the spring
    bird_distance_m | m | 1.5e-2 | positive | l_G from the spring to the bird's centre of mass
    beak_height_m | m | 2e-2 | positive | h_S of the beak above the bird's centre of mass
    beak_length_m | m | 2.01e-2 | positive | l_S of the beak before the bird's centre of mass
    spring_stiffness_nm_rad | N·m/rad | 5.6e-3 | positive | torsional stiffness c of the spring
    spring_lever_m | m | 1e-2 | positive | lever r that length and force of the spring are measured on | ours
    bird_angle_rad | rad | -0.2788 | finite | angle φ_S of the bird at the start
    sleeve_velocity_m_s | m/s | -0.3411 | finite | velocity of the sleeve at the start
    bird_rate_rad_s | rad/s | -7.4583 | finite | angular velocity of the bird at the start
    gravity_m_s2 | m/s² | 9.81 | not negative | gravity | standard
";
const LAW: &str = "
    restitution = 0.5 | Glocker 1995 for the beak; for all contacts ours
    friction = 0.3 | Glocker 1995
    tangential_restitution = 0.5
";

pub(super) fn entry() -> Case {
    Case {
        parameters: table(&[PARAMETERS, STABILISATION, RESTITUTION, WITH_FRICTION, LAW]),
        trace_columns: words(
            "time_s sleeve_y_m sleeve_angle_rad bird_angle_rad interface_position_m interface_velocity_m_s \
             actuator_force_n force_to_mechanics_n effective_mass_kg gap_beak_m gap_lower_edge_m \
             gap_upper_edge_m contact_force_beak_n contact_force_lower_edge_n contact_force_upper_edge_n \
             friction_force_beak_n friction_force_lower_edge_n friction_force_upper_edge_n contact_state_beak \
             contact_state_lower_edge contact_state_upper_edge closed_contacts",
        ),
        interface_columns: carriage::interface(),
        constant_mechanics: true,
        reference: reference(),
        ..Case::new(
            "woodpecker",
            "Woodpecker toy: a bird on a spring descends a pole in hops, its sleeve jams and lets go (impacts, stick, slip)",
            times(0.3, 5e-4, 1e-5, [1e-5, 5e-5]),
            build,
        )
    }
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let lever = get("spring_lever_m");
    let toy = Woodpecker::new(WoodpeckerGeometry {
        masses: ["sleeve_mass_kg", "bird_mass_kg"].map(get),
        inertias: ["sleeve_inertia_kg_m2", "bird_inertia_kg_m2"].map(get),
        pole_radius: get("pole_radius_m"),
        sleeve_radius: get("sleeve_radius_m"),
        sleeve_half_height: get("sleeve_half_height_m"),
        spring_distance: get("spring_distance_m"),
        bird_distance: get("bird_distance_m"),
        beak_height: get("beak_height_m"),
        beak_length: get("beak_length_m"),
        lever,
        bird_angle: get("bird_angle_rad"),
        velocities: ["sleeve_velocity_m_s", "bird_rate_rad_s"].map(get),
        gravity: get("gravity_m_s2"),
    })?;
    let spring = SpringActuator::new(SpringActuatorParameters {
        stiffness: get("spring_stiffness_nm_rad") / (lever * lever),
        ..SpringActuatorParameters::default()
    })?;
    coupled(toy, spring, parameters, solver)
}
