//! `slider-crank`: a motor turns a crank through a shaft; the slider has play in its guide and touches it with four corners, with friction.
//!
//! ```text
//!                 ____                     ═══════════════╤═══  guide
//!   motor ⌇──(crank)  ‾‾‾‾──rod──____      ┌───────┐      │ c
//!   speed ~   shaft                  ‾‾‾‾──┤•slider├      b
//!                                          └───────┘
//!                                          ═══════════════════
//! ```
//! Three velocities, a mass matrix that depends on the angles, four contacts, an interface of one row: the way of the crank pin. Where both corners
//! of a side touch, one of the two tangential rows is redundant.
//!
//! The motor is a rotor (mass m_a at the crank's radius) between a shaft (k, c) and what it turns against: c_b times what it is slower than its
//! nominal speed. At the start all turn at that speed, crank and rod stretched, the slider in the middle of its guide.
//!
//! **Direct feedthrough** of the actuator, through the shaft. **Reference**: monolithic, h, h/2, h/4, semi-implicit.
//!
//! **Source**: Flores, Leine, Glocker 2010 for crank, rod, slider and guide, with a restitution of 0.4 along the normal alone; motor *ours*.

use super::carriage;
use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{BaseMotion, SliderCrank, SliderCrankGeometry, SpringActuator, SpringActuatorParameters};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::{Error, Result};
use rimbench_core::name::names;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: names(&[
            "time_s",
            "crank_angle_rad",
            "crank_rate_rad_s",
            "slider_x_m",
            "slider_y_m",
            "slider_angle_rad",
            "interface_position_m",
            "interface_velocity_m_s",
            "actuator_force_n",
            "force_to_mechanics_n",
            "effective_mass_kg",
            "gap_upper_rear_m",
            "gap_upper_front_m",
            "gap_lower_rear_m",
            "gap_lower_front_m",
            "contact_state_upper_rear",
            "contact_state_upper_front",
            "contact_state_lower_rear",
            "contact_state_lower_front",
            "closed_contacts",
        ]),
        drawing_columns: names(&[
            "rod_angle_rad",
            "rod_rate_rad_s",
            "slider_rate_rad_s",
            "contact_force_upper_rear_n",
            "contact_force_upper_front_n",
            "contact_force_lower_rear_n",
            "contact_force_lower_front_n",
            "friction_force_upper_rear_n",
            "friction_force_upper_front_n",
            "friction_force_lower_rear_n",
            "friction_force_lower_front_n",
        ]),
        interface_columns: vec![carriage::interface()],
        reference: contact_parameters::reference(),
        ..Case::new(
            "slider-crank",
            "Slider-crank whose slider has play in its guide, driven through a shaft (impacts, friction at four corners)",
            CaseDefaults {
                duration_s: 0.1,
                macro_step_s: 5e-4,
                micro_step_s: 5e-6,
                reference_step_s: 2e-6,
                reference_sampling_s: 2e-5,
            },
            build,
        )
    }
}

const OURS: &str = "ours";
const FLORES: &str = "Flores et al. 2010";

fn parameters() -> Vec<Parameter> {
    use Range::{NotNegative, Positive};
    let own = [
        p("crank_length_m", "m", 0.153, Positive, "length l₁ of the crank", FLORES),
        p("rod_length_m", "m", 0.306, Positive, "length l₂ of the connecting rod", FLORES),
        p("slider_half_length_m", "m", 0.05, Positive, "half the length a of the slider", FLORES),
        p("slider_half_height_m", "m", 0.025, Positive, "half the height b of the slider", FLORES),
        p("clearance_m", "m", 1e-3, Positive, "play c above and below the slider", FLORES),
        p("crank_mass_kg", "kg", 0.038, Positive, "mass m₁ of the crank", FLORES),
        p("rod_mass_kg", "kg", 0.038, Positive, "mass m₂ of the rod", FLORES),
        p("slider_mass_kg", "kg", 0.076, Positive, "mass m₃ of the slider", FLORES),
        p("crank_inertia_kg_m2", "kg·m²", 7.4e-5, Positive, "inertia J₁ of the crank about its middle", FLORES),
        p("rod_inertia_kg_m2", "kg·m²", 5.9e-4, Positive, "inertia J₂ of the rod about its middle", FLORES),
        p("slider_inertia_kg_m2", "kg·m²", 2.7e-6, Positive, "inertia J₃ of the slider", FLORES),
        p(
            "speed_rad_s",
            "rad/s",
            150.0,
            NotNegative,
            "speed of crank and motor at the start, and of the motor",
            FLORES,
        ),
        p("rotor_mass_kg", "kg", 1.0, Positive, "mass m_a of the rotor at the crank's radius", OURS),
        p(
            "shaft_stiffness_n_m",
            "N/m",
            1e5,
            NotNegative,
            "stiffness k of the shaft; 0 without damping: no motor",
            OURS,
        ),
        p("shaft_damping_n_s_m", "N·s/m", 20.0, NotNegative, "damping c of the shaft", OURS),
        p("motor_damping_n_s_m", "N·s/m", 50.0, NotNegative, "force c_b of the motor per speed lost", OURS),
        p("gravity_m_s2", "m/s²", 9.81, NotNegative, "gravity", "standard"),
        contact_parameters::stabilisation(),
        contact_parameters::restitution(0.0, "plastic; Flores et al. 2010: 0.4 along the normal alone"),
    ];
    own.into_iter().chain(contact_parameters::friction_of(0.01, FLORES)).collect()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let (lengths, speed) = ([get("crank_length_m"), get("rod_length_m")], get("speed_rad_s"));
    if lengths[1] <= lengths[0] {
        let expected = format!("more than crank_length_m = {}: a shorter rod lets no crank turn", lengths[0]);
        return Err(Error::invalid("rod_length_m", lengths[1], expected));
    }
    let mechanism = SliderCrank::new(SliderCrankGeometry {
        masses: [get("crank_mass_kg"), get("rod_mass_kg"), get("slider_mass_kg")],
        inertias: [get("crank_inertia_kg_m2"), get("rod_inertia_kg_m2"), get("slider_inertia_kg_m2")],
        lengths,
        slider: [get("slider_half_length_m"), get("slider_half_height_m")],
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
        base_stiffness: 0.0,
        base_damping: get("motor_damping_n_s_m"),
        base: BaseMotion { position: 0.0, velocity: pin_speed, amplitude: 0.0, angular_frequency: 0.0, phase: 0.0 },
        start: [0.0, pin_speed],
    })?;
    contact_parameters::coupled(mechanism, motor, parameters, solver)
}
