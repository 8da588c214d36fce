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

parameters! {
    /// A carriage on springs between what it pushes and a base that moves.
    pub(super) struct Carriage from "ours" {
        spring_stiffness_n_m: f64 = 0.0, NotNegative, "stiffness k between carriage and interface; 0 with no damping uncouples the two sides";
        spring_damping_n_s_m: f64 = 0.0, NotNegative, "damping c between carriage and interface";
        carriage_mass_kg: f64 = 0.0, NotNegative, "mass m_a of the carriage; 0 fixes it to the base";
        base_stiffness_n_m: f64 = 0.0, NotNegative, "stiffness k_b between base and carriage";
        base_damping_n_s_m: f64 = 0.0, NotNegative, "damping c_b between base and carriage";
        base_position_m: f64 = 0.0, Finite, "middle x₀ of the motion of the base";
        base_amplitude_m: f64 = 0.0, NotNegative, "amplitude A of the motion of the base";
        base_frequency_hz: f64 = 0.0, NotNegative, "frequency ω/2π of the motion of the base";
        base_phase_rad: f64 = 0.0, Finite, "phase φ of the motion of the base";
        carriage_position_m: f64 = 0.0, Finite, "position of the carriage at the start";
        carriage_velocity_m_s: f64 = 0.0, Finite, "velocity of the carriage at the start";
    }
}

impl Carriage {
    /// The numbers of the actuator.
    pub(super) fn spring_actuator(&self) -> SpringActuatorParameters {
        SpringActuatorParameters {
            stiffness: self.spring_stiffness_n_m,
            damping: self.spring_damping_n_s_m,
            carriage_mass: self.carriage_mass_kg,
            base_stiffness: self.base_stiffness_n_m,
            base_damping: self.base_damping_n_s_m,
            base: BaseMotion {
                position: self.base_position_m,
                velocity: 0.0,
                amplitude: self.base_amplitude_m,
                angular_frequency: TAU * self.base_frequency_hz,
                phase: self.base_phase_rad,
            },
            start: [self.carriage_position_m, self.carriage_velocity_m_s],
        }
    }

    /// The actuator.
    pub(super) fn actuator(&self) -> Result<SpringActuator> {
        SpringActuator::new(self.spring_actuator())
    }
}
