//! One rigid body in space on feet, pushed by actuators.

use nalgebra::{Matrix3, Vector3};
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelSize};
use rimbench_core::name::{Name, names};

/// How far a quaternion or a tangent may be from what it should be: a few roundings.
const ROUNDING: f64 = 1e-12;

/// Tells whether a number differs from zero by more than rounding, or is none.
fn is_off(number: f64) -> bool {
    number.is_nan() || number.abs() > ROUNDING
}

/// A foot: a point of the body that may touch a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// From the body's centre of mass, in its axes, m.
    pub arm: Vector3<f64>,
    /// Normal of the plane, away from it, and two directions along it: orthonormal.
    pub directions: [Vector3<f64>; 3],
}

impl Foot {
    /// Makes a foot over the plane through the origin with these directions: normal, and two tangents.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if they are not orthonormal.
    pub fn new(arm: [f64; 3], directions: [[f64; 3]; 3]) -> Result<Self> {
        let directions = directions.map(Vector3::from);
        for (i, one) in directions.iter().enumerate() {
            for (j, other) in directions[..=i].iter().enumerate() {
                let (product, wanted) = (one.dot(other), if i == j { 1.0 } else { 0.0 });
                if is_off(product - wanted) {
                    return Err(Error::Incompatible(format!(
                        "normal and tangents of a contact must be orthonormal: directions {j} and {i} have the product {product}, not \
                         {wanted}"
                    )));
                }
            }
        }
        Ok(Foot { arm: arm.into(), directions })
    }

    /// Makes a foot over the floor z = 0, with tangents x and y.
    pub fn over_floor(arm: [f64; 3]) -> Self {
        Foot { arm: arm.into(), directions: [Vector3::z(), Vector3::x(), Vector3::y()] }
    }
}

/// Where an actuator pushes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pin {
    /// Its fixed end, m.
    pub fixed: Vector3<f64>,
    /// Its end on the body, from the centre of mass, in the body's axes, m.
    pub arm: Vector3<f64>,
}

/// Mass, inertia and start of the body, and what touches and pushes it.
#[derive(Debug, Clone, PartialEq)]
pub struct SpatialBodyGeometry {
    /// kg.
    pub mass: f64,
    /// About its own axes, which are principal ones, kg·m².
    pub inertia: [f64; 3],
    /// Centre of mass at the start, m.
    pub position: [f64; 3],
    /// Orientation at the start, a unit quaternion `(w, x, y, z)` that turns body axes into those of space.
    pub orientation: [f64; 4],
    /// Velocity of the centre of mass in space (m/s), and angular velocity in body axes (rad/s), at the start.
    pub velocity: [f64; 6],
    /// m/s², downwards.
    pub gravity: f64,
    /// In the order of the contacts.
    pub feet: Vec<Foot>,
    /// In the order of the interface rows.
    pub pins: Vec<Pin>,
}

/// A body with coordinates `q = (x, y, z, quaternion)` and velocities `v = (ẋ, ω)`, ω in body axes, so that M is diagonal and constant.
///
/// ```text
/// M v̇ = (m g, −ω × I ω) + ..           q⁺ = (x + h ẋ, quaternion · exp(h ω))
/// foot  p = x + R r                     rows d·ṗ = [dᵀ, (Rᵀ (R r × d))ᵀ],  Ȧv = d · R (ω × (ω × r)),   d: n, t₁, t₂;   g = n·p
/// pin   s = |p − p₀|,  e = (p − p₀)/s   row of d = e,  Ȧv = e · R (ω × (ω × r)) + (|ṗ|² − (e·ṗ)²)/s
/// ```
#[derive(Debug, Clone)]
pub struct SpatialBody {
    geometry: SpatialBodyGeometry,
    rotation: Matrix3<f64>,
    contacts: Vec<Name>,
}

impl SpatialBody {
    /// Places the body.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if its orientation is no unit quaternion.
    pub fn new(geometry: SpatialBodyGeometry) -> Result<Self> {
        let length = geometry.orientation.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        if is_off(length - 1.0) {
            let [w, x, y, z] = geometry.orientation;
            return Err(Error::Incompatible(format!(
                "an orientation must be a unit quaternion: ({w}, {x}, {y}, {z}) has the length {length}"
            )));
        }
        let contacts = (1..=geometry.feet.len()).map(|foot| format!("foot_{foot}").into()).collect();
        let rotation = matrix(geometry.orientation);
        Ok(SpatialBody { geometry, rotation, contacts })
    }

    /// Returns the length of an actuator at the start, m.
    pub fn start_length(&self, pin: usize) -> f64 {
        let Pin { fixed, arm } = self.geometry.pins[pin];
        (Vector3::from(self.geometry.position) + self.rotation * arm - fixed).norm()
    }

    /// Writes the row of the velocity of a point along a direction.
    fn set_row(&self, rows: &mut Rows, index: usize, arm: Vector3<f64>, direction: Vector3<f64>) {
        let turning = self.rotation.transpose() * (self.rotation * arm).cross(&direction);
        rows.jacobian[6 * index..6 * index + 3].copy_from_slice(direction.as_slice());
        rows.jacobian[6 * index + 3..6 * index + 6].copy_from_slice(turning.as_slice());
    }

    /// Returns the acceleration of a point that the turning alone gives, m/s².
    fn centripetal(&self, v: &[f64], arm: Vector3<f64>) -> Vector3<f64> {
        let omega = turning(v);
        self.rotation * omega.cross(&omega.cross(&arm))
    }

    fn set_tangents(&self, v: &[f64], rows: &mut Rows, axes: std::ops::Range<usize>) {
        let n = self.geometry.feet.len();
        for (at, axis) in axes.enumerate() {
            for (contact, foot) in self.geometry.feet.iter().enumerate() {
                let direction = foot.directions[axis];
                self.set_row(rows, at * n + contact, foot.arm, direction);
                rows.convective[at * n + contact] = self.centripetal(v, foot.arm).dot(&direction);
            }
        }
    }
}

fn turning(v: &[f64]) -> Vector3<f64> {
    Vector3::new(v[3], v[4], v[5])
}

/// Returns the rotation of a unit quaternion.
fn matrix([w, x, y, z]: [f64; 4]) -> Matrix3<f64> {
    Matrix3::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )
}

/// Returns `q · exp(t)`, t being a turn in body axes, rad; of length 1.
fn turned([w, x, y, z]: [f64; 4], turn: Vector3<f64>) -> [f64; 4] {
    let angle = turn.norm();
    // The first terms of the series where the quotient loses digits.
    let ratio = if angle > 1e-8 { libm::sin(0.5 * angle) / angle } else { 0.5 - angle * angle / 48.0 };
    let (c, [a, b, d]) = (libm::cos(0.5 * angle), [turn.x * ratio, turn.y * ratio, turn.z * ratio]);
    let product = [
        w * c - x * a - y * b - z * d,
        w * a + x * c + y * d - z * b,
        w * b - x * d + y * c + z * a,
        w * d + x * b - y * a + z * c,
    ];
    let length = product.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
    product.map(|entry| entry / length)
}

impl MechanicalModel for SpatialBody {
    fn size(&self) -> ModelSize {
        let SpatialBodyGeometry { feet, pins, .. } = &self.geometry;
        ModelSize {
            velocities: 6,
            unilateral: feet.len(),
            tangential: 2 * feet.len(),
            interface: pins.len(),
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        let SpatialBodyGeometry { position, orientation, velocity, .. } = &self.geometry;
        ([&position[..], orientation].concat(), velocity.to_vec())
    }

    fn advance_positions(&self, q: &mut [f64], v: &[f64], h: f64) {
        assert_eq!((q.len(), v.len()), (7, 6), "a body in space has a quaternion");
        let (position, orientation) = q.split_at_mut(3);
        for (x, v) in position.iter_mut().zip(v) {
            *x += h * v;
        }
        let now = [orientation[0], orientation[1], orientation[2], orientation[3]];
        orientation.copy_from_slice(&turned(now, turning(v) * h));
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        self.rotation = matrix([q[3], q[4], q[5], q[6]]);
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass[..3].fill(self.geometry.mass);
        mass[3..].copy_from_slice(&self.geometry.inertia);
    }

    fn forces(&self, _q: &[f64], v: &[f64], force: &mut [f64]) {
        force[..3].copy_from_slice(&[0.0, 0.0, -self.geometry.mass * self.geometry.gravity]);
        let omega = turning(v);
        let momentum = Vector3::from(self.geometry.inertia).component_mul(&omega);
        force[3..].copy_from_slice((-omega.cross(&momentum)).as_slice());
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        self.set_tangents(v, rows, 0..1);
        for (contact, foot) in self.geometry.feet.iter().enumerate() {
            let point = Vector3::new(q[0], q[1], q[2]) + self.rotation * foot.arm;
            rows.position[contact] = point.dot(&foot.directions[0]);
        }
    }

    fn tangential(&self, _q: &[f64], v: &[f64], rows: &mut Rows) {
        self.set_tangents(v, rows, 1..3);
    }

    fn interface(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        for (row, Pin { fixed, arm }) in self.geometry.pins.iter().enumerate() {
            let span = Vector3::new(q[0], q[1], q[2]) + self.rotation * arm - fixed;
            let length = span.norm();
            let along = span / length;
            self.set_row(rows, row, *arm, along);
            let velocity = Vector3::new(v[0], v[1], v[2]) + self.rotation * turning(v).cross(arm);
            let rate = velocity.dot(&along);
            let swing = (velocity.norm_squared() - rate * rate) / length;
            rows.convective[row] = self.centripetal(v, *arm).dot(&along) + swing;
            rows.position[row] = length;
        }
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.geometry.mass * self.geometry.gravity * q[2]
    }

    fn observables(&self) -> Vec<Name> {
        names(&["body_x_m", "body_y_m", "body_z_m", "yaw_rad", "pitch_rad", "roll_rad"])
    }

    fn contact_names(&self) -> Vec<Name> {
        self.contacts.clone()
    }

    /// Writes the centre of mass, and the turns about z, the new y and the new x that give the orientation.
    fn observe(&self, q: &[f64], _v: &[f64], row: &mut [f64]) {
        let r = matrix([q[3], q[4], q[5], q[6]]);
        row[..3].copy_from_slice(&q[..3]);
        row[3] = libm::atan2(r[(1, 0)], r[(0, 0)]);
        row[4] = libm::asin((-r[(2, 0)]).clamp(-1.0, 1.0));
        row[5] = libm::atan2(r[(2, 1)], r[(2, 2)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body() -> SpatialBodyGeometry {
        SpatialBodyGeometry {
            mass: 2.0,
            inertia: [0.3, 0.5, 0.7],
            position: [0.1, -0.2, 0.4],
            orientation: [1.0, 0.0, 0.0, 0.0],
            velocity: [0.3, -0.1, 0.2, 0.7, -1.1, 0.5],
            gravity: 0.0,
            feet: vec![Foot::over_floor([0.3, -0.2, -0.4])],
            pins: vec![Pin { fixed: Vector3::new(-2.0, 0.3, 0.1), arm: Vector3::new(-0.3, 0.1, 0.2) }],
        }
    }

    /// Rows and convective terms against differences of gaps and lengths along the motion of a body that turns freely.
    #[test]
    fn rows_are_the_rates_of_gaps_and_lengths_and_convective_terms_those_of_rows() {
        let mut model = SpatialBody::new(body()).unwrap();
        let (mut q, v) = model.initial_state();
        model.advance_positions(&mut q, &v, 0.4);
        let mut at = |time: f64| {
            let mut q = q.clone();
            model.advance_positions(&mut q, &v, time);
            model.prepare(&q, &v);
            let mut rows = [Rows::zeros(1, 6), Rows::zeros(2, 6), Rows::zeros(1, 6)];
            let [normal, tangential, interface] = &mut rows;
            model.unilateral(&q, &v, normal);
            model.tangential(&q, &v, tangential);
            model.interface(&q, &v, interface);
            rows
        };
        let step = 1e-5;
        let [before, now, after] = [-step, 0.0, step].map(&mut at);
        for block in 0..3 {
            for row in 0..now[block].len() {
                let rate = |of: &dyn Fn(&Rows) -> f64| (of(&after[block]) - of(&before[block])) / (2.0 * step);
                if block != 1 {
                    let slope = rate(&|rows| rows.position[row]);
                    assert!((slope - now[block].velocity(row, &v)).abs() < 1e-8, "{block}, {row}");
                }
                let slope = rate(&|rows| rows.velocity(row, &v));
                assert!((slope - now[block].convective[row]).abs() < 1e-8, "{block}, {row}");
            }
        }
    }

    #[test]
    fn a_free_body_keeps_its_angular_momentum_and_its_quaternion_its_length() {
        let mut model = SpatialBody::new(body()).unwrap();
        let (mut q, mut v) = model.initial_state();
        let mut momentum = |q: &[f64], v: &[f64]| {
            model.prepare(q, v);
            model.rotation * Vector3::new(0.3 * v[3], 0.5 * v[4], 0.7 * v[5])
        };
        let start = momentum(&q, &v);
        let step = 1e-4;
        let mut model = SpatialBody::new(body()).unwrap();
        for _ in 0..10_000 {
            let mut force = [0.0; 6];
            model.prepare(&q, &v);
            model.forces(&q, &v, &mut force);
            for (v, (f, m)) in v[3..].iter_mut().zip(force[3..].iter().zip([0.3, 0.5, 0.7])) {
                *v += step * f / m;
            }
            model.advance_positions(&mut q, &v, step);
        }
        assert!((momentum(&q, &v) - start).norm() < 1e-4 * start.norm(), "first order");
        assert!((q[3..].iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn an_orientation_that_is_no_unit_and_tangents_that_are_not_orthonormal_are_refused() {
        let wrong = SpatialBody::new(SpatialBodyGeometry { orientation: [1.0, 0.1, 0.0, 0.0], ..body() });
        assert!(wrong.unwrap_err().to_string().contains("unit quaternion"));
        let nan = SpatialBody::new(SpatialBodyGeometry { orientation: [f64::NAN; 4], ..body() });
        assert!(nan.is_err());
        for tangent in [[1.0, 0.0, 0.1], [2.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0], [0.0, 1.0, 0.0]] {
            let wrong = Foot::new([0.0; 3], [[0.0, 0.0, 1.0], tangent, [0.0, 1.0, 0.0]]);
            assert!(wrong.unwrap_err().to_string().contains("orthonormal"), "{tangent:?}");
        }
    }
}
