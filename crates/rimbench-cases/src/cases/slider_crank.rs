//! `slider-crank`: a motor turns a crank through a shaft; the slider has play in its guide and touches it with four corners, with friction. The
//! motor is a rotor (mass m_a at the crank's radius) between a shaft (k, c) and what it turns against: c_b times what it is slower than its nominal
//! speed. Shown in `docs/cases/slider-crank.md`; crank, rod, slider and guide of Flores, Leine, Glocker 2010, motor *ours*.

use super::prelude::*;

const PARAMETERS: &str = "source: Flores et al. 2010
    crank_length_m | m | 0.153 | positive | length l₁ of the crank
    rod_length_m | m | 0.306 | positive | length l₂ of the connecting rod
    slider_half_length_m | m | 0.05 | positive | half the length a of the slider
    slider_half_height_m | m | 0.025 | positive | half the height b of the slider
    clearance_m | m | 1e-3 | positive | play c above and below the slider
    crank_mass_kg | kg | 0.038 | positive | mass m₁ of the crank
    rod_mass_kg | kg | 0.038 | positive | mass m₂ of the rod
    slider_mass_kg | kg | 0.076 | positive | mass m₃ of the slider
    crank_inertia_kg_m2 | kg·m² | 7.4e-5 | positive | inertia J₁ of the crank about its middle
    rod_inertia_kg_m2 | kg·m² | 5.9e-4 | positive | inertia J₂ of the rod about its middle
    slider_inertia_kg_m2 | kg·m² | 2.7e-6 | positive | inertia J₃ of the slider
    speed_rad_s | rad/s | 150.0 | not negative | speed of crank and motor at the start, and of the motor
    source: ours
    rotor_mass_kg | kg | 1.0 | positive | mass m_a of the rotor at the crank's radius
    shaft_stiffness_n_m | N/m | 1e5 | not negative | stiffness k of the shaft; 0 without damping: no motor
    shaft_damping_n_s_m | N·s/m | 20.0 | not negative | damping c of the shaft
    motor_damping_n_s_m | N·s/m | 50.0 | not negative | force c_b of the motor per speed lost
    gravity_m_s2 | m/s² | 9.81 | not negative | gravity | standard
";
const LAW: &str = "
    restitution = 0.0 | plastic; Flores et al. 2010: 0.4 along the normal alone
    friction = 0.01 | Flores et al. 2010
";

pub(super) fn entry() -> Case {
    Case {
        parameters: table(&[PARAMETERS, STABILISATION, RESTITUTION, WITH_FRICTION, LAW]),
        trace_columns: words(
            "time_s crank_angle_rad crank_rate_rad_s slider_x_m slider_y_m slider_angle_rad \
             interface_position_m interface_velocity_m_s actuator_force_n force_to_mechanics_n \
             effective_mass_kg gap_upper_rear_m gap_upper_front_m gap_lower_rear_m gap_lower_front_m \
             contact_state_upper_rear contact_state_upper_front contact_state_lower_rear \
             contact_state_lower_front closed_contacts",
        ),
        drawing_columns: words(
            "rod_angle_rad rod_rate_rad_s slider_rate_rad_s contact_force_upper_rear_n \
             contact_force_upper_front_n contact_force_lower_rear_n contact_force_lower_front_n \
             friction_force_upper_rear_n friction_force_upper_front_n friction_force_lower_rear_n \
             friction_force_lower_front_n",
        ),
        interface_columns: carriage::interface(),
        reference: reference(),
        ..Case::new(
            "slider-crank",
            "Slider-crank whose slider has play in its guide, driven through a shaft (impacts, friction at four corners)",
            times(0.1, 5e-4, 5e-6, [2e-6, 2e-5]),
            build,
        )
    }
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let (lengths, speed) = (["crank_length_m", "rod_length_m"].map(get), get("speed_rad_s"));
    if lengths[1] <= lengths[0] {
        let expected = format!("more than crank_length_m = {}: a shorter rod lets no crank turn", lengths[0]);
        return Err(Error::invalid("rod_length_m", lengths[1], expected));
    }
    let mechanism = SliderCrank::new(SliderCrankGeometry {
        masses: ["crank_mass_kg", "rod_mass_kg", "slider_mass_kg"].map(get),
        inertias: ["crank_inertia_kg_m2", "rod_inertia_kg_m2", "slider_inertia_kg_m2"].map(get),
        lengths,
        slider: ["slider_half_length_m", "slider_half_height_m"].map(get),
        clearance: get("clearance_m"),
        // So that the slider pin stays on the axis.
        rates: [speed, -speed * lengths[0] / lengths[1], 0.0],
        gravity: get("gravity_m_s2"),
    });
    let pin_speed = lengths[0] * speed;
    let motor = SpringActuator::new(SpringActuatorParameters {
        stiffness: get("shaft_stiffness_n_m"),
        damping: get("shaft_damping_n_s_m"),
        carriage_mass: get("rotor_mass_kg"),
        base_damping: get("motor_damping_n_s_m"),
        base: BaseMotion { velocity: pin_speed, ..BaseMotion::default() },
        start: [0.0, pin_speed],
        ..SpringActuatorParameters::default()
    })?;
    coupled(mechanism, motor, parameters, solver)
}
