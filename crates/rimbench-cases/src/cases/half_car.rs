//! `half-car`: a car on two hydropneumatic struts crosses a washboard; its wheels leave the road. Two interfaces.
//!
//! ```text
//!            ┌──────────────┬──────────────┐  body: z, θ
//!            └──┬───────────┴───────────┬──┘
//!            s_r ⌇ F_r                F_f ⌇ s_f      F > 0 extends
//!               ○ z_r                    ○ z_f  wheels            travels →
//!   ────────────────────────────────────────────╱╲╱╲╱╲╱╲╱╲  washboard
//! ```
//! Five velocities (travel, body heave and pitch, two wheels), two contacts, an interface of two rows: both struts are one
//! subsystem that sees two lengths and two rates and gives two forces. The rows are coupled through the body: pushing in front moves
//! the rear.
//!
//! **Manoeuvre.** In equilibrium on a smooth road, then the washboard: the road falls away from the wheels faster than weight and
//! struts can follow, and they fly from crest to crest. The road does not move (the car does), so the energy audit closes.
//!
//! **Direct feedthrough** of the struts, through their orifices. **Reference**: monolithic, h, h/2, h/4.
//!
//! **Source**: *ours*; gas and orifice of the size of a small car's.

use super::case::{Case, CaseDefaults, CoupledSystem, InterfaceColumns};
use super::contact_parameters;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{ActuatorNames, ActuatorPair, HalfCar, HalfCarGeometry, HydropneumaticStrut, StrutParameters};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::{Name, names};

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: trace_columns(
            &["time_s", "travel_x_m", "body_z_m", "pitch_rad", "front_wheel_z_m", "rear_wheel_z_m"],
            &["closed_contacts"],
        ),
        drawing_columns: names(&["front_gas_pressure_pa", "rear_gas_pressure_pa"]),
        interface_columns: interfaces(),
        reference: contact_parameters::reference(),
        ..Case::new(
            "half-car",
            "Half car on two hydropneumatic struts over a washboard, wheels lift off (two interface rows)",
            DEFAULTS,
            build,
        )
    }
}

/// How long a car is looked at, and by which steps.
pub(super) const DEFAULTS: CaseDefaults = CaseDefaults {
    duration_s: 2.0,
    macro_step_s: 5e-3,
    micro_step_s: 1e-4,
    reference_step_s: 5e-5,
    reference_sampling_s: 1e-4,
};

/// The columns of a trace: those of the body, struts and wheels, and what a case has besides.
pub(super) fn trace_columns(body: &[&'static str], besides: &[&'static str]) -> Vec<Name> {
    const STRUTS_AND_WHEELS: [&str; 13] = [
        "front_length_m",
        "rear_length_m",
        "front_velocity_m_s",
        "rear_velocity_m_s",
        "front_force_n",
        "rear_force_n",
        "force_to_mechanics_n",
        "force_2_to_mechanics_n",
        "effective_mass_kg",
        "gap_front_wheel_m",
        "gap_rear_wheel_m",
        "contact_force_front_wheel_n",
        "contact_force_rear_wheel_n",
    ];
    names(&[body, &STRUTS_AND_WHEELS, besides].concat())
}

/// The interface of two struts.
pub(super) fn interfaces() -> Vec<InterfaceColumns> {
    vec![
        InterfaceColumns::new("front_length_m", "front_velocity_m_s", "front_force_n"),
        InterfaceColumns::new("rear_length_m", "rear_velocity_m_s", "rear_force_n"),
    ]
}

const NAMES: [ActuatorNames; 2] = [
    ActuatorNames {
        position: "front_length_m",
        velocity: "front_velocity_m_s",
        force: "front_force_n",
        observables: &["front_gas_pressure_pa"],
    },
    ActuatorNames {
        position: "rear_length_m",
        velocity: "rear_velocity_m_s",
        force: "rear_force_n",
        observables: &["rear_gas_pressure_pa"],
    },
];

const OURS: &str = "ours";

fn parameters() -> Vec<Parameter> {
    use Range::{Finite, Fraction, NotNegative, Positive};
    let body = [
        p("body_mass_kg", "kg", 500.0, Positive, "mass of the body", OURS),
        p("pitch_inertia_kg_m2", "kg·m²", 600.0, Positive, "inertia of the body about its centre of mass", OURS),
        p("wheel_mass_kg", "kg", 40.0, Positive, "mass of each wheel", OURS),
        p("front_axle_m", "m", 1.2, Positive, "distance of the front axle from the centre of mass", OURS),
        p("rear_axle_m", "m", 1.4, Positive, "distance of the rear axle from the centre of mass", OURS),
        p("strut_length_m", "m", 0.5, Positive, "length of each strut at the start", OURS),
    ];
    let own = [
        p("speed_m_s", "m/s", 8.0, NotNegative, "travelling speed at the start", OURS),
        p("road_height_m", "m", 0.05, NotNegative, "washboard, peak to valley", OURS),
        p("wavelength_m", "m", 0.8, Positive, "washboard, wavelength", OURS),
        p("road_start_m", "m", 1.0, Finite, "start of the washboard ahead of the front wheel at the start", OURS),
        p("start_height_m", "m", 0.0, Finite, "height of both wheels above the smooth road at the start", OURS),
        p("gravity_m_s2", "m/s²", 9.81, Positive, "gravity", "standard"),
        contact_parameters::stabilisation(),
        p("restitution", "-", 0.0, Fraction, "restitution e of the wheels", OURS),
    ];
    [&body[..], &strut_parameters(1500.0), &own].concat()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let model = HalfCar::new(HalfCarGeometry {
        body_mass: get("body_mass_kg"),
        pitch_inertia: get("pitch_inertia_kg_m2"),
        wheel_mass: get("wheel_mass_kg"),
        axles: [get("front_axle_m"), get("rear_axle_m")],
        strut_length: get("strut_length_m"),
        start_height: get("start_height_m"),
        speed: get("speed_m_s"),
        road_height: get("road_height_m"),
        wavelength: get("wavelength_m"),
        road_start: get("road_start_m"),
        gravity: get("gravity_m_s2"),
    })?;
    let struts = struts(parameters, model.equilibrium_forces())?;
    contact_parameters::coupled(model, struts, parameters, solver)
}

/// The numbers of a strut, with this damping, N·s/m.
pub(super) fn strut_parameters(damping: f64) -> [Parameter; 4] {
    use Range::{NotNegative, Positive};
    [
        p("piston_area_m2", "m²", 1e-3, Positive, "piston area A of a strut", OURS),
        p("gas_volume_m3", "m³", 2e-4, Positive, "gas volume V₀ of a strut at the start", OURS),
        p("gas_exponent", "-", 1.4, Positive, "polytropic exponent of the gas, above 1", "adiabatic, two-atomic gas"),
        p("strut_damping_n_s_m", "N·s/m", damping, NotNegative, "damping c of a strut's orifice", OURS),
    ]
}

/// Front and rear strut as the parameters say, with these forces (N) at the start.
pub(super) fn struts(parameters: &Parameters, start_forces: [f64; 2]) -> Result<ActuatorPair<HydropneumaticStrut>> {
    let get = |name: &str| parameters.number(name);
    let [front, rear] = start_forces.map(|start_force| {
        HydropneumaticStrut::new(StrutParameters {
            piston_area: get("piston_area_m2"),
            gas_volume: get("gas_volume_m3"),
            exponent: get("gas_exponent"),
            damping: get("strut_damping_n_s_m"),
            start_force,
        })
    });
    Ok(ActuatorPair::new([front?, rear?], NAMES))
}
