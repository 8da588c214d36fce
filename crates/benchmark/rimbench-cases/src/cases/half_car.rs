//! `half-car`: a car on two hydropneumatic struts crosses a washboard; its wheels leave the road. Two interface rows.
//! Shown in `docs/cases/half-car.md`; numbers *ours*, gas and orifice of the size of a small car's.

use super::prelude::*;
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};

parameters! {
    /// A car, its struts and the road.
    pub struct Car from "ours" {
        body_mass_kg: f64 = 500.0, Positive, "mass of the body";
        pitch_inertia_kg_m2: f64 = 600.0, Positive, "inertia of the body about its centre of mass";
        wheel_mass_kg: f64 = 40.0, Positive, "mass of each wheel";
        front_axle_m: f64 = 1.2, Positive, "distance of the front axle from the centre of mass";
        rear_axle_m: f64 = 1.4, Positive, "distance of the rear axle from the centre of mass";
        strut_length_m: f64 = 0.5, Positive, "length of each strut at the start";
        /// Its struts.
        strut: Strut;
        speed_m_s: f64 = 8.0, NotNegative, "travelling speed at the start";
        road_height_m: f64 = 0.05, NotNegative, "washboard, peak to valley";
        wavelength_m: f64 = 0.8, Positive, "washboard, wavelength";
        road_start_m: f64 = 1.0, Finite, "start of the washboard ahead of the front wheel at the start";
        start_height_m: f64 = 0.0, Finite, "height of both wheels above the smooth road at the start";
        gravity_m_s2: f64 = 9.81, Positive, "gravity".from("standard");
        /// The contact law.
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution"]).default("restitution", 0.0)
            .about("restitution", "restitution e of the wheels").source("restitution", "ours");
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: of_contacts(
            &["front_wheel", "rear_wheel"],
            "time_s travel_x_m body_z_m pitch_rad front_wheel_z_m rear_wheel_z_m front_length_m rear_length_m \
             front_velocity_m_s rear_velocity_m_s front_force_n rear_force_n force_to_mechanics_n force_2_to_mechanics_n \
             effective_mass_kg gap_*_m contact_force_*_n closed_contacts",
        ),
        drawing_columns: words("front_gas_pressure_pa rear_gas_pressure_pa"),
        interface_columns: InterfaceColumns::of(&NAMES),
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

impl Car {
    fn road(&self) -> Washboard {
        Washboard::new(self.road_start_m, [self.road_height_m, self.wavelength_m])
    }
}

fn drawing(p: &Car) -> Drawing {
    const WHEEL: f64 = 0.25;
    let [front, rear] = [p.front_axle_m, -p.rear_axle_m];
    let road = p.road();
    let profile = (0..=400).map(|k| -6.0 + 0.075 * f64::from(k)).map(|x| [x, road.at(x - front)[0] - WHEEL]);
    let along = |plus: f64| Channel::Column("travel_x_m", 1.0, plus);
    let rolling = Channel::Column("travel_x_m", -1.0 / WHEEL, 0.0);
    let strut = |x: f64, wheel: &'static str| Shape::Cylinder {
        from: ([x, 0.0], Some("body")),
        to: ([0.0, 0.0], Some(wheel)),
        barrel: 0.45 * p.strut_length_m,
        width: 0.1,
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
            frame("front wheel", along(front), "front_wheel_z_m", rolling),
            frame("rear wheel", along(rear), "rear_wheel_z_m", rolling),
        ],
        shapes: vec![
            ground(&profile.collect::<Vec<_>>()),
            wheel("front wheel", WHEEL),
            wheel("rear wheel", WHEEL),
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
    let model = HalfCar::new(*p)?;
    let [front, rear] = model.equilibrium_forces().map(|force| HydropneumaticStrut::new(p.strut, force));
    assembly.couple(model, ActuatorGroup::new(vec![front?, rear?], &NAMES), &p.contacts)
}

/// Body and wheels. Coordinates: travel, body height and pitch, heights of front and rear wheel.
///
#[doc = include_str!("half_car.md")]
/// # Source
/// Ours.
#[derive(Debug, Clone)]
pub struct HalfCar {
    p: Car,
    road: Washboard,
    mass: [f64; 5],
    sin: f64,
    cos: f64,
}

impl HalfCar {
    /// Places the car level and in equilibrium on its struts, travelling.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if a wheel would start inside the road.
    pub fn new(p: Car) -> Result<Self> {
        let [body, wheel] = [p.body_mass_kg, p.wheel_mass_kg];
        let mass = [body + 2.0 * wheel, body, p.pitch_inertia_kg_m2, wheel, wheel];
        let model = HalfCar { road: p.road(), mass, sin: 0.0, cos: 1.0, p };
        for (index, name) in ["front", "rear"].into_iter().enumerate() {
            let gap = p.start_height_m - model.road.at(model.axle_x(0.0, index))[0];
            if gap < 0.0 {
                return Err(Error::Incompatible(format!(
                    "impossible geometry: the {name} wheel would start at {gap:.6} m, inside the road"
                )));
            }
        }
        Ok(model)
    }

    /// Returns the forces of the struts that carry the body at rest, front and rear, N.
    pub fn equilibrium_forces(&self) -> [f64; 2] {
        let g = &self.p;
        let [front, rear] = [g.front_axle_m, g.rear_axle_m];
        let weight = g.body_mass_kg * g.gravity_m_s2 / (front + rear);
        [weight * rear, weight * front]
    }

    /// x of an axle when the body has travelled `x`; the front axle starts at 0.
    fn axle_x(&self, x: f64, axle: usize) -> f64 {
        let [front, rear] = [self.p.front_axle_m, self.p.rear_axle_m];
        if axle == 0 { x } else { x - front - rear }
    }
}

impl MechanicalModel for HalfCar {
    fn size(&self) -> ModelSize {
        ModelSize {
            velocities: 5,
            unilateral: 2,
            interface: 2,
            switches: 2,
            constant_mass: true,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        let g = &self.p;
        let wheel = g.start_height_m;
        (vec![0.0, wheel + g.strut_length_m, 0.0, wheel, wheel], vec![g.speed_m_s, 0.0, 0.0, 0.0, 0.0])
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        (self.sin, self.cos) = libm::sincos(q[2]);
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.copy_from_slice(&self.mass);
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        let g = self.p.gravity_m_s2;
        force.copy_from_slice(&[0.0, -g * self.mass[1], 0.0, -g * self.mass[3], -g * self.mass[4]]);
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        for axle in 0..2 {
            let [height, slope, curvature] = self.road.at(self.axle_x(q[0], axle));
            rows.jacobian[5 * axle] = -slope;
            rows.jacobian[5 * axle + 3 + axle] = 1.0;
            rows.position[axle] = q[3 + axle] - height;
            rows.convective[axle] = -curvature * v[0] * v[0];
        }
    }

    fn interface(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let [front, rear] = [self.p.front_axle_m, self.p.rear_axle_m];
        for (axle, arm) in [front, -rear].into_iter().enumerate() {
            rows.jacobian[5 * axle..5 * axle + 3].copy_from_slice(&[0.0, 1.0, arm * self.cos]);
            rows.jacobian[5 * axle + 3 + axle] = -1.0;
            rows.position[axle] = q[1] + arm * self.sin - q[3 + axle];
            rows.convective[axle] = -arm * self.sin * v[2] * v[2];
        }
    }

    /// Where the road begins to rise its curvature jumps.
    fn switch_values(&self, q: &[f64], v: &[f64], switches: &mut [[f64; 2]]) {
        for (axle, switch) in switches.iter_mut().enumerate() {
            *switch = [self.axle_x(q[0], axle) - self.p.road_start_m, v[0]];
        }
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.p.gravity_m_s2 * (self.mass[1] * q[1] + self.mass[3] * q[3] + self.mass[4] * q[4])
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(
            &["travel_x_m", "body_z_m", "pitch_rad", "front_wheel_z_m", "rear_wheel_z_m"],
            &["front_wheel", "rear_wheel"],
        )
    }
}
