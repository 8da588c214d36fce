//! Mechanics of a half car that brakes: a body on two locked wheels that slide over a level road.

use super::rotation::rotation;
use nalgebra::{Rotation2, Vector2};
use rimbench_core::interface_model::{MassMatrix, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelSize};
use rimbench_core::name::{Name, names};

/// Masses, geometry and start of a [`BrakingCar`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrakingCarGeometry {
    /// kg.
    pub body_mass: f64,
    /// About the body's centre of mass, kg·m².
    pub pitch_inertia: f64,
    /// Of one wheel, kg.
    pub wheel_mass: f64,
    /// m.
    pub wheel_radius: f64,
    /// Distances of front and rear axle from the centre of mass, m.
    pub axles: [f64; 2],
    /// Length of each strut at the start, from the height of the centre of mass to the axle, m.
    pub strut_length: f64,
    /// Speed at the start, m/s.
    pub speed: f64,
    /// m/s².
    pub gravity: f64,
}

/// Body and wheels. Coordinates: body `(x, y, θ)`, nose up, then the centres of front and rear wheel `(x, y)`.
///
/// ```text
/// r = wheel − body,  u = (cos θ, sin θ),  n = (−sin θ, cos θ)
/// joint     r·u = ± a            each wheel moves along its strut, which is square to the body
/// interface s = −r·n             length of the strut
/// contact   g = y_wheel − R      w_t = ẋ_wheel + R θ̇: the wheel is locked to the body and turns with it
/// ```
/// Friction acts on the road, so that braking loads the front wheel; while it goes on and the body does not move any more,
///
/// ```text
/// ẍ = −μ g     N_f (x_f − x_r) = Σ m g (x − x_r) + μ g Σ m y       summed over body and wheels
/// ```
/// # Source
/// Ours; the load transfer of every text on vehicles.
#[derive(Debug, Clone, PartialEq)]
pub struct BrakingCar {
    geometry: BrakingCarGeometry,
    rotation: Rotation2<f64>,
}

const VELOCITIES: usize = 7;

/// Along which direction of the body a row measures the place of a wheel.
#[derive(Clone, Copy)]
enum Along {
    Body,
    Strut,
}

impl BrakingCar {
    /// Places the car level and in equilibrium on its struts, its wheels on the road.
    pub fn new(geometry: BrakingCarGeometry) -> Self {
        BrakingCar { geometry, rotation: Rotation2::identity() }
    }

    /// Returns the forces of the struts that carry the body at rest, front and rear, N.
    pub fn equilibrium_forces(&self) -> [f64; 2] {
        let g = &self.geometry;
        let [front, rear] = g.axles;
        let weight = g.body_mass * g.gravity / (front + rear);
        [weight * rear, weight * front]
    }

    /// Distance of an axle ahead of the centre of mass, m.
    fn arm(&self, wheel: usize) -> f64 {
        let [front, rear] = self.geometry.axles;
        if wheel == 0 { front } else { -rear }
    }

    /// Writes `d/dt (r·d)` for a direction d fixed in the body, with its convective term; returns `r·d`.
    ///
    /// ```text
    /// (r·d)' = ṙ·d + θ̇ r·d_⊥        (r·d)'' = r̈·d + θ̈ r·d_⊥ + 2 θ̇ ṙ·d_⊥ − θ̇² r·d,   d_⊥ = d turned by 90°
    /// ```
    fn place(&self, q: &[f64], v: &[f64], wheel: usize, along: Along, rows: &mut Rows) -> f64 {
        let at = 3 + 2 * wheel;
        let d = match along {
            Along::Body => self.rotation * Vector2::new(1.0, 0.0),
            Along::Strut => self.rotation * Vector2::new(0.0, -1.0),
        };
        let across = Vector2::new(-d.y, d.x);
        let (r, rate) = (Vector2::new(q[at] - q[0], q[at + 1] - q[1]), Vector2::new(v[at] - v[0], v[at + 1] - v[1]));
        let row = &mut rows.jacobian[VELOCITIES * wheel..VELOCITIES * (wheel + 1)];
        row[..3].copy_from_slice(&[-d.x, -d.y, r.dot(&across)]);
        row[at..at + 2].copy_from_slice(&[d.x, d.y]);
        rows.convective[wheel] = 2.0 * v[2] * rate.dot(&across) - v[2] * v[2] * r.dot(&d);
        r.dot(&d)
    }
}

impl MechanicalModel for BrakingCar {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: VELOCITIES, bilateral: 2, unilateral: 2, interface: 2 }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        let g = &self.geometry;
        let radius = g.wheel_radius;
        let q = vec![0.0, radius + g.strut_length, 0.0, self.arm(0), radius, self.arm(1), radius];
        (q, vec![g.speed, 0.0, 0.0, g.speed, 0.0, g.speed, 0.0])
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        self.rotation = rotation(q[2]);
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut MassMatrix) {
        if let MassMatrix::Diagonal(diagonal) = mass {
            let BrakingCarGeometry { body_mass, pitch_inertia, wheel_mass, .. } = self.geometry;
            diagonal[..3].copy_from_slice(&[body_mass, body_mass, pitch_inertia]);
            diagonal[3..].fill(wheel_mass);
        }
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        let BrakingCarGeometry { body_mass, wheel_mass, gravity, .. } = self.geometry;
        let wheel = -wheel_mass * gravity;
        force.copy_from_slice(&[0.0, -body_mass * gravity, 0.0, 0.0, wheel, 0.0, wheel]);
    }

    fn bilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        for wheel in 0..2 {
            rows.position[wheel] = self.place(q, v, wheel, Along::Body, rows) - self.arm(wheel);
        }
    }

    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        for wheel in 0..2 {
            let at = 4 + 2 * wheel;
            rows.jacobian[VELOCITIES * wheel + at] = 1.0;
            rows.position[wheel] = q[at] - self.geometry.wheel_radius;
        }
    }

    fn tangential_rows(&self) -> usize {
        2
    }

    fn tangential(&self, _q: &[f64], _v: &[f64], rows: &mut Rows) {
        for wheel in 0..2 {
            rows.jacobian[VELOCITIES * wheel + 2] = self.geometry.wheel_radius;
            rows.jacobian[VELOCITIES * wheel + 3 + 2 * wheel] = 1.0;
        }
    }

    fn interface(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        for wheel in 0..2 {
            rows.position[wheel] = self.place(q, v, wheel, Along::Strut, rows);
        }
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        let g = &self.geometry;
        g.gravity * (g.body_mass * q[1] + g.wheel_mass * (q[4] + q[6]))
    }

    fn observables(&self) -> Vec<Name> {
        names(&[
            "travel_x_m",
            "body_z_m",
            "pitch_rad",
            "front_wheel_x_m",
            "front_wheel_z_m",
            "rear_wheel_x_m",
            "rear_wheel_z_m",
            "speed_m_s",
        ])
    }

    fn gap_names(&self) -> Vec<Name> {
        names(&["gap_front_wheel_m", "gap_rear_wheel_m"])
    }

    fn contact_force_names(&self) -> Vec<Name> {
        names(&["contact_force_front_wheel_n", "contact_force_rear_wheel_n"])
    }

    fn observe(&self, q: &[f64], v: &[f64], row: &mut [f64]) {
        row[..VELOCITIES].copy_from_slice(q);
        row[VELOCITIES] = v[0];
    }
}
