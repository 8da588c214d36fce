//! The spring actuator as parameters, shared by the cases that have one.

use super::prelude::*;
use std::f64::consts::TAU;

/// The interface of a carriage and what it pushes.
pub(super) fn interface() -> Vec<InterfaceColumns> {
    vec![InterfaceColumns::new("interface_position_m", "interface_velocity_m_s", "actuator_force_n")]
}

/// The columns of a trace: time, the interface of the carriage, and those of the case's own.
pub(super) fn trace_columns(own: &'static str) -> Vec<Name> {
    let shared = "time_s interface_position_m interface_velocity_m_s actuator_force_n force_to_mechanics_n";
    [words(shared), words(own)].concat()
}

pub(super) const CARRIAGE: &str = "source: ours
    spring_stiffness_n_m | N/m | 0.0 | not negative | stiffness k between carriage and interface; 0 with no damping uncouples the two sides
    spring_damping_n_s_m | N·s/m | 0.0 | not negative | damping c between carriage and interface
    carriage_mass_kg | kg | 0.0 | not negative | mass m_a of the carriage; 0 fixes it to the base
    base_stiffness_n_m | N/m | 0.0 | not negative | stiffness k_b between base and carriage
    base_damping_n_s_m | N·s/m | 0.0 | not negative | damping c_b between base and carriage
    base_position_m | m | 0.0 | finite | middle x₀ of the motion of the base
    base_amplitude_m | m | 0.0 | not negative | amplitude A of the motion of the base
    base_frequency_hz | Hz | 0.0 | not negative | frequency ω/2π of the motion of the base
    base_phase_rad | rad | 0.0 | finite | phase φ of the motion of the base
    carriage_position_m | m | 0.0 | finite | position of the carriage at the start
    carriage_velocity_m_s | m/s | 0.0 | finite | velocity of the carriage at the start
";

/// The numbers of the actuator.
pub(super) fn of(parameters: &Parameters) -> SpringActuatorParameters {
    let get = |name: &str| parameters.number(name);
    SpringActuatorParameters {
        stiffness: get("spring_stiffness_n_m"),
        damping: get("spring_damping_n_s_m"),
        carriage_mass: get("carriage_mass_kg"),
        base_stiffness: get("base_stiffness_n_m"),
        base_damping: get("base_damping_n_s_m"),
        base: BaseMotion {
            position: get("base_position_m"),
            velocity: 0.0,
            amplitude: get("base_amplitude_m"),
            angular_frequency: TAU * get("base_frequency_hz"),
            phase: get("base_phase_rad"),
        },
        start: ["carriage_position_m", "carriage_velocity_m_s"].map(get),
    }
}

/// The actuator as the parameters say.
pub(super) fn actuator(parameters: &Parameters) -> Result<SpringActuator> {
    SpringActuator::new(of(parameters))
}
