//! Mechanics of a half car: a body on two wheels that may leave the road.

use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::{MassMatrix, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelSize};
use rimbench_core::name::{Name, names};

/// Masses, geometry, road and start of a [`HalfCar`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfCarGeometry {
    /// kg.
    pub body_mass: f64,
    /// About the body's centre of mass, kg·m².
    pub pitch_inertia: f64,
    /// Of one wheel, kg.
    pub wheel_mass: f64,
    /// Distances of front and rear axle from the centre of mass, m.
    pub axles: [f64; 2],
    /// Length of each strut at the start, m.
    pub strut_length: f64,
    /// Height of both wheels above the road at the start, m.
    pub start_height: f64,
    /// Travelling speed at the start, m/s.
    pub speed: f64,
    /// Peak to valley of the washboard, m.
    pub road_height: f64,
    /// Its wavelength, m.
    pub wavelength: f64,
    /// Where it begins, ahead of the front axle at the start, m.
    pub road_start: f64,
    /// m/s².
    pub gravity: f64,
}

/// Body and wheels. Coordinates: travel x, body height z and pitch θ (nose up), heights of front and rear wheel.
///
/// ```text
/// s_f = z + a_f sin θ − z_f            s_r = z − a_r sin θ − z_r                lengths of the struts, the interface
/// g_f = z_f − r(x + a_f)               g_r = z_r − r(x − a_r)                   A_f = [−r', 0, 0, 1, 0]
/// r(x) = ½ h (1 − cos 2π(x − x₀)/ℓ) for x > x₀, else 0                          path of the centre of a rolling wheel
/// ```
/// The wheels are rigid and roll without friction or spin; gaps are vertical, so contact forces are vertical components. The road
/// does not move: the car does, and what it climbs it loses in speed.
/// # Source
/// Ours.
#[derive(Debug, Clone, PartialEq)]
pub struct HalfCar {
    geometry: HalfCarGeometry,
    mass: [f64; 5],
    sin: f64,
    cos: f64,
}

impl HalfCar {
    /// Places the car level and in equilibrium on its struts, travelling.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if a wheel would start inside the road.
    pub fn new(geometry: HalfCarGeometry) -> Result<Self> {
        let g = &geometry;
        let mass = [g.body_mass + 2.0 * g.wheel_mass, g.body_mass, g.pitch_inertia, g.wheel_mass, g.wheel_mass];
        let model = HalfCar { mass, sin: 0.0, cos: 1.0, geometry };
        for (index, name) in ["front", "rear"].into_iter().enumerate() {
            let gap = g.start_height - model.road(model.axle_x(0.0, index))[0];
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
        let g = &self.geometry;
        let [front, rear] = g.axles;
        let weight = g.body_mass * g.gravity / (front + rear);
        [weight * rear, weight * front]
    }

    /// x of an axle when the body has travelled `x`; the front axle starts at 0.
    fn axle_x(&self, x: f64, axle: usize) -> f64 {
        let [front, rear] = self.geometry.axles;
        if axle == 0 { x } else { x - front - rear }
    }

    /// `r, r', r''` of the road.
    fn road(&self, x: f64) -> [f64; 3] {
        let g = &self.geometry;
        let along = x - g.road_start;
        if along <= 0.0 {
            return [0.0; 3];
        }
        let k = std::f64::consts::TAU / g.wavelength;
        let (sin, cos) = libm::sincos(k * along);
        let half = 0.5 * g.road_height;
        [half * (1.0 - cos), half * k * sin, half * k * k * cos]
    }
}

impl MechanicalModel for HalfCar {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: 5, bilateral: 0, unilateral: 2, interface: 2 }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        let g = &self.geometry;
        let wheel = g.start_height;
        (vec![0.0, wheel + g.strut_length, 0.0, wheel, wheel], vec![g.speed, 0.0, 0.0, 0.0, 0.0])
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        (self.sin, self.cos) = libm::sincos(q[2]);
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut MassMatrix) {
        if let MassMatrix::Diagonal(diagonal) = mass {
            diagonal.copy_from_slice(&self.mass);
        }
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        let g = self.geometry.gravity;
        force.copy_from_slice(&[0.0, -g * self.mass[1], 0.0, -g * self.mass[3], -g * self.mass[4]]);
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        for axle in 0..2 {
            let [height, slope, curvature] = self.road(self.axle_x(q[0], axle));
            rows.jacobian[5 * axle] = -slope;
            rows.jacobian[5 * axle + 3 + axle] = 1.0;
            rows.position[axle] = q[3 + axle] - height;
            rows.convective[axle] = -curvature * v[0] * v[0];
        }
    }

    fn interface(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let [front, rear] = self.geometry.axles;
        for (axle, arm) in [front, -rear].into_iter().enumerate() {
            rows.jacobian[5 * axle..5 * axle + 3].copy_from_slice(&[0.0, 1.0, arm * self.cos]);
            rows.jacobian[5 * axle + 3 + axle] = -1.0;
            rows.position[axle] = q[1] + arm * self.sin - q[3 + axle];
            rows.convective[axle] = -arm * self.sin * v[2] * v[2];
        }
    }

    /// Where the road begins to rise its curvature jumps.
    fn switches(&self) -> usize {
        2
    }

    fn switch_values(&self, q: &[f64], v: &[f64], switches: &mut [[f64; 2]]) {
        for (axle, switch) in switches.iter_mut().enumerate() {
            *switch = [self.axle_x(q[0], axle) - self.geometry.road_start, v[0]];
        }
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.geometry.gravity * (self.mass[1] * q[1] + self.mass[3] * q[3] + self.mass[4] * q[4])
    }

    fn observables(&self) -> Vec<Name> {
        names(&["travel_x_m", "body_z_m", "pitch_rad", "front_wheel_z_m", "rear_wheel_z_m"])
    }

    fn contact_names(&self) -> Vec<Name> {
        names(&["front_wheel", "rear_wheel"])
    }

    fn observe(&self, q: &[f64], _v: &[f64], row: &mut [f64]) {
        row.copy_from_slice(q);
    }
}
