//! `half-car`: a car on two hydropneumatic struts crosses a washboard; its wheels leave the road. Two interface rows. Shown in
//! `docs/cases/half-car.md`; numbers *ours*, gas and orifice of the size of a small car's.

use super::prelude::*;

parameters! {
    /// A car, its struts and the road.
    struct Car from "ours" {
        body_mass_kg: f64 = 500.0, Positive, "mass of the body";
        pitch_inertia_kg_m2: f64 = 600.0, Positive, "inertia of the body about its centre of mass";
        wheel_mass_kg: f64 = 40.0, Positive, "mass of each wheel";
        front_axle_m: f64 = 1.2, Positive, "distance of the front axle from the centre of mass";
        rear_axle_m: f64 = 1.4, Positive, "distance of the rear axle from the centre of mass";
        strut_length_m: f64 = 0.5, Positive, "length of each strut at the start";
        piston_area_m2: f64 = 1e-3, Positive, "piston area A of a strut";
        gas_volume_m3: f64 = 2e-4, Positive, "gas volume V₀ of a strut at the start";
        gas_exponent: f64 = 1.4, Positive, "polytropic exponent of the gas, above 1" from "adiabatic, two-atomic gas";
        strut_damping_n_s_m: f64 = 1500.0, NotNegative, "damping c of a strut's orifice";
        speed_m_s: f64 = 8.0, NotNegative, "travelling speed at the start";
        road_height_m: f64 = 0.05, NotNegative, "washboard, peak to valley";
        wavelength_m: f64 = 0.8, Positive, "washboard, wavelength";
        road_start_m: f64 = 1.0, Finite, "start of the washboard ahead of the front wheel at the start";
        start_height_m: f64 = 0.0, Finite, "height of both wheels above the smooth road at the start";
        gravity_m_s2: f64 = 9.81, Positive, "gravity" from "standard";
        contacts: Contacts only { stabilisation; restitution = 0.0, "restitution e of the wheels" from "ours" };
    }
}

pub(super) fn entry() -> Case {
    Case {
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
        drawing: drawn(|p: &Car| Some(drawing(p))),
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

fn drawing(p: &Car) -> Drawing {
    const WHEEL: f64 = 0.25;
    let [front, rear] = [p.front_axle_m, -p.rear_axle_m];
    let road = |x: f64| {
        let along = (x - front - p.road_start_m) / p.wavelength_m;
        let wave =
            if along > 0.0 { 0.5 * p.road_height_m * (1.0 - libm::cos(std::f64::consts::TAU * along)) } else { 0.0 };
        [x, wave - WHEEL]
    };
    let profile: Vec<[f64; 2]> = (0..=400).map(|k| road(-6.0 + 0.075 * f64::from(k))).collect();
    let along = |plus: f64| Channel::Column("travel_x_m", 1.0, plus);
    let rolling = Channel::Column("travel_x_m", -1.0 / WHEEL, 0.0);
    let wheel = |name, x, height: &'static str| Frame { name, parent: None, pose: [along(x), height.into(), rolling] };
    let strut = |x: f64, wheel: &'static str| Shape::Cylinder {
        from: ([x, 0.0], Some("body")),
        to: ([0.0, 0.0], Some(wheel)),
        barrel: 0.45 * p.strut_length_m,
        width: 0.1,
    };
    let disc = |name: &'static str| Shape::Disc {
        at: ([0.0, 0.0], Some(name)),
        radius: WHEEL,
        spoke: true,
        fill: Fill::Metal,
    };
    let body = [
        [rear - 0.5, -0.08],
        [front + 0.55, -0.08],
        [front + 0.6, 0.12],
        [front - 0.2, 0.2],
        [front - 0.6, 0.5],
        [rear + 0.6, 0.52],
        [rear + 0.1, 0.2],
        [rear - 0.5, 0.16],
    ];
    Drawing {
        view: [[-2.3, 2.3], [-0.45, 1.25]],
        follow: Some("travel_x_m"),
        frames: vec![
            frame("body", "travel_x_m", "body_z_m", "pitch_rad"),
            wheel("front wheel", front, "front_wheel_z_m"),
            wheel("rear wheel", rear, "rear_wheel_z_m"),
        ],
        shapes: vec![
            ground(&profile),
            disc("front wheel"),
            disc("rear wheel"),
            strut(front, "front wheel"),
            strut(rear, "rear wheel"),
            Shape::Polygon(points("body", body), Fill::Scheme),
        ],
        title: [
            "Half car",
            "A car on two hydropneumatic struts crosses a washboard; its wheels fly from crest to crest.",
        ],
        force: "front strut's force",
        in_kilonewtons: true,
        ..Drawing::default()
    }
}

fn build(p: &Car, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let model = HalfCar::new(HalfCarGeometry {
        body_mass: p.body_mass_kg,
        pitch_inertia: p.pitch_inertia_kg_m2,
        wheel_mass: p.wheel_mass_kg,
        axles: [p.front_axle_m, p.rear_axle_m],
        strut_length: p.strut_length_m,
        start_height: p.start_height_m,
        speed: p.speed_m_s,
        road_height: p.road_height_m,
        wavelength: p.wavelength_m,
        road_start: p.road_start_m,
        gravity: p.gravity_m_s2,
    })?;
    let [front, rear] = model.equilibrium_forces().map(|start_force| {
        HydropneumaticStrut::new(StrutParameters {
            piston_area: p.piston_area_m2,
            gas_volume: p.gas_volume_m3,
            exponent: p.gas_exponent,
            damping: p.strut_damping_n_s_m,
            start_force,
        })
    });
    assembly.couple(model, ActuatorGroup::new(vec![front?, rear?], &NAMES), &p.contacts)
}
