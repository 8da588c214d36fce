//! The spring actuator as parameters, shared by the cases that have one.

use super::case::InterfaceColumns;
use super::parameters::{Parameter, Parameters, Range, number};
use crate::models::{BaseMotion, SpringActuator, SpringActuatorParameters};
use rimbench_core::error::Result;
use rimbench_core::name::{Name, names};
use std::f64::consts::TAU;

const OURS: &str = "ours";

/// The interface of a carriage and what it pushes.
pub(super) fn interface() -> InterfaceColumns {
    InterfaceColumns::new("interface_position_m", "interface_velocity_m_s", "actuator_force_n")
}

/// The columns of a trace: time, the interface of the carriage, and those of the case's own.
pub(super) fn trace_columns(own: &[&'static str]) -> Vec<Name> {
    const SHARED: [&str; 5] =
        ["time_s", "interface_position_m", "interface_velocity_m_s", "actuator_force_n", "force_to_mechanics_n"];
    names(&[&SHARED, own].concat())
}

pub(super) fn stiffness(default: f64) -> Parameter {
    let about = "stiffness k between carriage and interface; 0 with no damping uncouples the two sides";
    number("spring_stiffness_n_m", "N/m", default, Range::NotNegative, about, OURS)
}

pub(super) fn damping(default: f64) -> Parameter {
    let about = "damping c between carriage and interface";
    number("spring_damping_n_s_m", "N·s/m", default, Range::NotNegative, about, OURS)
}

pub(super) fn mass(default: f64) -> Parameter {
    let about = "mass m_a of the carriage; 0 fixes it to the base";
    number("carriage_mass_kg", "kg", default, Range::NotNegative, about, OURS)
}

pub(super) fn base_stiffness(default: f64) -> Parameter {
    number("base_stiffness_n_m", "N/m", default, Range::NotNegative, "stiffness k_b between base and carriage", OURS)
}

pub(super) fn base_damping(default: f64) -> Parameter {
    number("base_damping_n_s_m", "N·s/m", default, Range::NotNegative, "damping c_b between base and carriage", OURS)
}

pub(super) fn base_position(default: f64) -> Parameter {
    number("base_position_m", "m", default, Range::Finite, "middle x₀ of the motion of the base", OURS)
}

pub(super) fn base_amplitude(default: f64) -> Parameter {
    number("base_amplitude_m", "m", default, Range::NotNegative, "amplitude A of the motion of the base", OURS)
}

pub(super) fn base_frequency(default: f64) -> Parameter {
    number("base_frequency_hz", "Hz", default, Range::NotNegative, "frequency ω/2π of the motion of the base", OURS)
}

pub(super) fn base_phase(default: f64) -> Parameter {
    number("base_phase_rad", "rad", default, Range::Finite, "phase φ of the motion of the base", OURS)
}

pub(super) fn start_position(default: f64) -> Parameter {
    number("carriage_position_m", "m", default, Range::Finite, "position of the carriage at the start", OURS)
}

pub(super) fn start_velocity(default: f64) -> Parameter {
    number("carriage_velocity_m_s", "m/s", default, Range::Finite, "velocity of the carriage at the start", OURS)
}

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
        start: [get("carriage_position_m"), get("carriage_velocity_m_s")],
    }
}

/// The actuator as the parameters say.
pub(super) fn actuator(parameters: &Parameters) -> Result<SpringActuator> {
    SpringActuator::new(of(parameters))
}
