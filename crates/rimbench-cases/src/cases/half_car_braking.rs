//! `half-car-braking`: a car on two hydropneumatic struts brakes with locked wheels, dives, stops, and rocks back. Two interfaces, friction.
//!
//! ```text
//!            ┌──────────────┬──────────────┐  body: x, y, θ
//!            └──┬───────────┴───────────┬──┘
//!            s_r ⌇ F_r                F_f ⌇ s_f      F > 0 extends; struts square to the body
//!               ◙                        ◙   wheels, locked      travels →
//!   ═════════════════════════════════════════════ level road  μ
//! ```
//! Seven velocities, two joint rows, two contacts, an interface of two rows. Braking acts on the road and the mass is above it, so the front
//! wheel takes load from the rear one; while the body has come to rest on its struts,
//!
//! ```text
//! ẍ = −μ g        N_f (x_f − x_r) = Σ m g (x − x_r) + μ g Σ m y
//! ```
//! **Manoeuvre.** From equilibrium at full speed the wheels lock: the nose dives. When the car stops, both wheels stick, and the body swings back with
//! what the struts have stored, on wheels that hold or slip. At the stop the friction force goes from its full size to whatever holds.
//!
//! **Direct feedthrough** of the struts, through their orifices. **Reference**: monolithic, h, h/2, h/4, semi-implicit.
//!
//! **Source**: *ours*; gas and orifice of the size of a car's.

use super::case::{Case, CoupledSystem};
use super::contact_parameters;
use super::half_car;
use super::parameters::{Parameter, Parameters, Range, number as p};
use crate::models::{BrakingCar, BrakingCarGeometry};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: half_car::trace_columns(
            &["time_s", "travel_x_m", "speed_m_s", "body_z_m", "pitch_rad"],
            &[
                "friction_force_front_wheel_n",
                "friction_force_rear_wheel_n",
                "contact_state_front_wheel",
                "contact_state_rear_wheel",
                "closed_contacts",
            ],
        ),
        drawing_columns: names(&[
            "front_wheel_x_m",
            "front_wheel_z_m",
            "rear_wheel_x_m",
            "rear_wheel_z_m",
            "front_gas_pressure_pa",
            "rear_gas_pressure_pa",
        ]),
        interface_columns: half_car::interfaces(),
        reference: contact_parameters::reference(),
        ..Case::new(
            "half-car-braking",
            "Half car on two hydropneumatic struts brakes with locked wheels to a stop (two interface rows, friction)",
            half_car::DEFAULTS,
            build,
        )
    }
}

const OURS: &str = "ours";

fn parameters() -> Vec<Parameter> {
    use Range::{NotNegative, Positive};
    let body = [
        p("body_mass_kg", "kg", 1120.0, Positive, "mass of the body", OURS),
        p("pitch_inertia_kg_m2", "kg·m²", 1800.0, Positive, "inertia of the body about its centre of mass", OURS),
        p("wheel_mass_kg", "kg", 40.0, Positive, "mass of each wheel", OURS),
        p("wheel_radius_m", "m", 0.3, Positive, "radius R of the wheels", OURS),
        p("front_axle_m", "m", 1.2, Positive, "distance of the front axle from the centre of mass", OURS),
        p("rear_axle_m", "m", 1.4, Positive, "distance of the rear axle from the centre of mass", OURS),
        p("strut_length_m", "m", 0.25, Positive, "height of the centre of mass above the axles at the start", OURS),
    ];
    let own = [
        p("speed_m_s", "m/s", 8.0, NotNegative, "speed at the start", OURS),
        p("gravity_m_s2", "m/s²", 9.81, Positive, "gravity", "standard"),
        contact_parameters::stabilisation(),
        contact_parameters::restitution(0.0, "plastic"),
    ];
    [&body[..], &half_car::strut_parameters(3000.0), &own, &contact_parameters::friction(0.8)].concat()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let model = BrakingCar::new(BrakingCarGeometry {
        body_mass: get("body_mass_kg"),
        pitch_inertia: get("pitch_inertia_kg_m2"),
        wheel_mass: get("wheel_mass_kg"),
        wheel_radius: get("wheel_radius_m"),
        axles: [get("front_axle_m"), get("rear_axle_m")],
        strut_length: get("strut_length_m"),
        speed: get("speed_m_s"),
        gravity: get("gravity_m_s2"),
    });
    let struts = half_car::struts(parameters, model.equilibrium_forces())?;
    contact_parameters::coupled(model, struts, parameters, solver)
}
