//! `half-car`: a car on two hydropneumatic struts crosses a washboard; its wheels leave the road. Two interface rows. Shown in
//! `docs/cases/half-car.md`; numbers *ours*, gas and orifice of the size of a small car's.

use super::prelude::*;

const PARAMETERS: &str = "source: ours
    body_mass_kg | kg | 500.0 | positive | mass of the body
    pitch_inertia_kg_m2 | kg·m² | 600.0 | positive | inertia of the body about its centre of mass
    wheel_mass_kg | kg | 40.0 | positive | mass of each wheel
    front_axle_m | m | 1.2 | positive | distance of the front axle from the centre of mass
    rear_axle_m | m | 1.4 | positive | distance of the rear axle from the centre of mass
    strut_length_m | m | 0.5 | positive | length of each strut at the start
    piston_area_m2 | m² | 1e-3 | positive | piston area A of a strut
    gas_volume_m3 | m³ | 2e-4 | positive | gas volume V₀ of a strut at the start
    gas_exponent | - | 1.4 | positive | polytropic exponent of the gas, above 1 | adiabatic, two-atomic gas
    strut_damping_n_s_m | N·s/m | 1500.0 | not negative | damping c of a strut's orifice
    speed_m_s | m/s | 8.0 | not negative | travelling speed at the start
    road_height_m | m | 0.05 | not negative | washboard, peak to valley
    wavelength_m | m | 0.8 | positive | washboard, wavelength
    road_start_m | m | 1.0 | finite | start of the washboard ahead of the front wheel at the start
    start_height_m | m | 0.0 | finite | height of both wheels above the smooth road at the start
    gravity_m_s2 | m/s² | 9.81 | positive | gravity | standard
    stabilisation | - | 0.2 | fraction | fraction γ of a penetration removed per mechanics step
    restitution | - | 0.0 | fraction | restitution e of the wheels
";

pub(super) fn entry() -> Case {
    Case {
        parameters: table(&[PARAMETERS]),
        trace_columns: words(
            "time_s travel_x_m body_z_m pitch_rad front_wheel_z_m rear_wheel_z_m front_length_m rear_length_m \
             front_velocity_m_s rear_velocity_m_s front_force_n rear_force_n force_to_mechanics_n force_2_to_mechanics_n \
             effective_mass_kg gap_front_wheel_m gap_rear_wheel_m contact_force_front_wheel_n \
             contact_force_rear_wheel_n closed_contacts",
        ),
        drawing_columns: words("front_gas_pressure_pa rear_gas_pressure_pa"),
        interface_columns: vec![
            InterfaceColumns::new("front_length_m", "front_velocity_m_s", "front_force_n"),
            InterfaceColumns::new("rear_length_m", "rear_velocity_m_s", "rear_force_n"),
        ],
        reference: reference(),
        ..Case::new(
            "half-car",
            "Half car on two hydropneumatic struts over a washboard, wheels lift off (two interface rows)",
            times(2.0, 5e-3, 1e-4, [5e-5, 1e-4]),
            build,
        )
    }
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

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let model = HalfCar::new(HalfCarGeometry {
        body_mass: get("body_mass_kg"),
        pitch_inertia: get("pitch_inertia_kg_m2"),
        wheel_mass: get("wheel_mass_kg"),
        axles: ["front_axle_m", "rear_axle_m"].map(get),
        strut_length: get("strut_length_m"),
        start_height: get("start_height_m"),
        speed: get("speed_m_s"),
        road_height: get("road_height_m"),
        wavelength: get("wavelength_m"),
        road_start: get("road_start_m"),
        gravity: get("gravity_m_s2"),
    })?;
    let [front, rear] = model.equilibrium_forces().map(|start_force| {
        HydropneumaticStrut::new(StrutParameters {
            piston_area: get("piston_area_m2"),
            gas_volume: get("gas_volume_m3"),
            exponent: get("gas_exponent"),
            damping: get("strut_damping_n_s_m"),
            start_force,
        })
    });
    coupled(model, ActuatorPair::new([front?, rear?], NAMES), parameters, solver)
}
