//! One rigid body in space on feet, pushed by actuators, and a ball on a ledge that it may carry.

use super::ledge::{Ledge, SurfaceContact};
use nalgebra::{Matrix3, Vector2, Vector3};
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};
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

/// A ball on a spherical joint of the body, over a ledge along y and the floor z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LedgeBall {
    /// kg.
    pub mass: f64,
    /// m; it is solid, so that its inertia is 2/5 m r².
    pub radius: f64,
    /// Its joint on the body, from the centre of mass, in the body's axes, m.
    pub pin: Vector3<f64>,
    /// Its profile over x and z.
    pub ledge: Ledge,
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
    /// Its contacts with ledge and floor come after the feet.
    pub ball: Option<LedgeBall>,
}

impl SpatialBodyGeometry {
    /// Describes a cuboid of this mass (kg) and size (m), level and at rest, without feet and pins yet.
    pub fn cuboid(mass: f64, [x, y, z]: [f64; 3], gravity: f64) -> Self {
        SpatialBodyGeometry {
            mass,
            inertia: [y * y + z * z, x * x + z * z, x * x + y * y].map(|square| mass * square / 12.0),
            position: [0.0; 3],
            orientation: [1.0, 0.0, 0.0, 0.0],
            velocity: [0.0; 6],
            gravity,
            feet: Vec::new(),
            pins: Vec::new(),
            ball: None,
        }
    }
}

/// A body with coordinates `q = (x, y, z, quaternion)` and velocities `v = (ẋ, ω)`, ω in body axes, so that M is
/// diagonal and constant.
///
/// ```text
/// M v̇ = (m g, −ω × I ω) + ..           q⁺ = (x + h ẋ, quaternion · exp(h ω))
/// foot  p = x + R r                     rows d·ṗ = [dᵀ, (Rᵀ (R r × d))ᵀ],  Ȧv = d · R (ω × (ω × r)),   d: n, t₁, t₂;   g = n·p
/// pin   s = |p − p₀|,  e = (p − p₀)/s   row of d = e,  Ȧv = e · R (ω × (ω × r)) + (|ṗ|² − (e·ṗ)²)/s
/// ball  p = its centre at the joint     rows d·ṗ: [dᵀ, (−r n × d)ᵀ],  Ȧv = (κ u², −κ u (n·ṗ), −κ r u (n·ω)),   u = t₁·ṗ, t₂ = y
/// ```
/// A ball adds its centre to q, and its velocity and ω in axes of space to v; κ is the curvature of the path of its
/// centre at a corner.
#[derive(Debug, Clone)]
pub struct SpatialBody {
    geometry: SpatialBodyGeometry,
    rotation: Matrix3<f64>,
    /// `R r` of each foot, and `R (ω × (ω × r))`.
    feet: Vec<[Vector3<f64>; 2]>,
    /// Gaps of the ball to ledge and floor with their directions `[n, t₁, t₂]` and curvatures.
    ball_contacts: Option<[(SurfaceContact, [Vector3<f64>; 3]); 2]>,
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
        let feet = (1..=geometry.feet.len()).map(|foot| format!("foot_{foot}").into());
        let contacts = feet.chain(geometry.ball.iter().flat_map(|_| names(&["ball_ledge", "ball_floor"]))).collect();
        let (rotation, feet) = (matrix(geometry.orientation), vec![[Vector3::zeros(); 2]; geometry.feet.len()]);
        Ok(SpatialBody { geometry, rotation, feet, ball_contacts: None, contacts })
    }

    /// Returns its geometry.
    pub fn geometry(&self) -> &SpatialBodyGeometry {
        &self.geometry
    }

    /// Returns the length of an actuator at the start, m.
    pub fn start_length(&self, pin: usize) -> f64 {
        let Pin { fixed, arm } = self.geometry.pins[pin];
        (Vector3::from(self.geometry.position) + self.rotation * arm - fixed).norm()
    }

    /// Writes the row of the velocity of a point along a direction; `arm` is in the axes of space.
    fn set_row(&self, rows: &mut Rows, index: usize, arm: Vector3<f64>, direction: Vector3<f64>) {
        let turning = self.rotation.transpose() * arm.cross(&direction);
        self.set(rows, index, 0, [direction, turning]);
    }

    /// Writes the entries of one body.
    fn set(&self, rows: &mut Rows, index: usize, body: usize, [along, turning]: [Vector3<f64>; 2]) {
        let first = 6 * (self.bodies() * index + body);
        rows.jacobian[first..first + 3].copy_from_slice(along.as_slice());
        rows.jacobian[first + 3..first + 6].copy_from_slice(turning.as_slice());
    }

    fn bodies(&self) -> usize {
        1 + usize::from(self.geometry.ball.is_some())
    }

    fn ball_contacts(ball: &LedgeBall, q: &[f64]) -> [(SurfaceContact, [Vector3<f64>; 3]); 2] {
        let ledge = ball.ledge.contact(Vector2::new(q[7], q[9]), ball.radius);
        let floor = SurfaceContact { gap: q[9] - ball.radius, normal: Vector2::new(0.0, 1.0), curvature: 0.0 };
        [ledge, floor].map(|contact| {
            let normal = contact.normal;
            let directions =
                [Vector3::new(normal.x, 0.0, normal.y), Vector3::new(normal.y, 0.0, -normal.x), Vector3::y()];
            (contact, directions)
        })
    }

    fn set_directions(&self, v: &[f64], rows: &mut Rows, axes: std::ops::Range<usize>) {
        let n = self.contacts.len();
        for (at, axis) in axes.enumerate() {
            for (contact, (foot, [arm, centripetal])) in self.geometry.feet.iter().zip(&self.feet).enumerate() {
                let direction = foot.directions[axis];
                self.set_row(rows, at * n + contact, *arm, direction);
                rows.convective[at * n + contact] = centripetal.dot(&direction);
            }
            let (Some(ball), Some(contacts)) = (&self.geometry.ball, self.ball_contacts) else { continue };
            let (velocity, omega) = (Vector3::from_column_slice(&v[6..9]), Vector3::from_column_slice(&v[9..]));
            for (slot, (contact, directions)) in contacts.into_iter().enumerate() {
                let ([normal, first, _], row) = (directions, at * n + self.geometry.feet.len() + slot);
                let along = velocity.dot(&first);
                let turning = -ball.radius * normal.cross(&directions[axis]);
                self.set(rows, row, 1, [directions[axis], turning]);
                rows.convective[row] = contact.curvature
                    * along
                    * [along, -velocity.dot(&normal), -ball.radius * omega.dot(&normal)][axis];
            }
        }
    }
}

/// Returns the acceleration of a point that the turning alone gives, m/s².
fn centripetal(rotation: &Matrix3<f64>, v: &[f64], arm: Vector3<f64>) -> Vector3<f64> {
    let omega = turning(v);
    rotation * omega.cross(&omega.cross(&arm))
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
        let (bodies, contacts) = (self.bodies(), self.contacts.len());
        ModelSize {
            velocities: 6 * bodies,
            bilateral: 3 * (bodies - 1),
            unilateral: contacts,
            tangential: 2 * contacts,
            interface: self.geometry.pins.len(),
            constant_mass: true,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        let SpatialBodyGeometry { position, orientation, velocity, ball, .. } = &self.geometry;
        let (mut q, mut v) = ([&position[..], orientation].concat(), velocity.to_vec());
        if let Some(ball) = ball {
            let arm = self.rotation * ball.pin;
            q.extend((Vector3::from(*position) + arm).iter());
            v.extend(
                (Vector3::from_column_slice(velocity) + self.rotation * turning(velocity).cross(&ball.pin)).iter(),
            );
            v.extend([0.0; 3]);
        }
        (q, v)
    }

    fn advance_positions(&self, q: &mut [f64], v: &[f64], h: f64) {
        let ball = self.bodies() - 1;
        assert_eq!((q.len(), v.len()), (7 + 3 * ball, 6 + 6 * ball), "a body in space has a quaternion");
        let (body, centre) = q.split_at_mut(7);
        let (position, orientation) = body.split_at_mut(3);
        for (x, v) in position.iter_mut().zip(v).chain(centre.iter_mut().zip(v.iter().skip(6))) {
            *x += h * v;
        }
        let now = [orientation[0], orientation[1], orientation[2], orientation[3]];
        orientation.copy_from_slice(&turned(now, turning(v) * h));
    }

    fn prepare(&mut self, q: &[f64], v: &[f64]) {
        self.rotation = matrix([q[3], q[4], q[5], q[6]]);
        for (foot, known) in self.geometry.feet.iter().zip(&mut self.feet) {
            *known = [self.rotation * foot.arm, centripetal(&self.rotation, v, foot.arm)];
        }
        self.ball_contacts = self.geometry.ball.map(|ball| Self::ball_contacts(&ball, q));
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass[..3].fill(self.geometry.mass);
        mass[3..6].copy_from_slice(&self.geometry.inertia);
        if let Some(ball) = &self.geometry.ball {
            mass[6..9].fill(ball.mass);
            mass[9..].fill(0.4 * ball.mass * ball.radius * ball.radius);
        }
    }

    fn forces(&self, _q: &[f64], v: &[f64], force: &mut [f64]) {
        force[..3].copy_from_slice(&[0.0, 0.0, -self.geometry.mass * self.geometry.gravity]);
        let omega = turning(v);
        let momentum = Vector3::from(self.geometry.inertia).component_mul(&omega);
        force[3..6].copy_from_slice((-omega.cross(&momentum)).as_slice());
        if let Some(ball) = &self.geometry.ball {
            force[6..].copy_from_slice(&[0.0, 0.0, -ball.mass * self.geometry.gravity, 0.0, 0.0, 0.0]);
        }
    }

    fn bilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let Some(ball) = &self.geometry.ball else { return };
        let (arm, turned) = (self.rotation * ball.pin, centripetal(&self.rotation, v, ball.pin));
        for (axis, direction) in [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().enumerate() {
            self.set_row(rows, axis, arm, -direction);
            self.set(rows, axis, 1, [direction, Vector3::zeros()]);
            rows.position[axis] = q[7 + axis] - q[axis] - arm[axis];
            rows.convective[axis] = -turned[axis];
        }
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        self.set_directions(v, rows, 0..1);
        for (contact, (foot, [arm, _])) in self.geometry.feet.iter().zip(&self.feet).enumerate() {
            let point = Vector3::new(q[0], q[1], q[2]) + arm;
            rows.position[contact] = point.dot(&foot.directions[0]);
        }
        if let Some(contacts) = self.ball_contacts {
            let gaps = contacts.map(|(contact, _)| contact.gap);
            rows.position[self.geometry.feet.len()..].copy_from_slice(&gaps);
        }
    }

    fn tangential(&self, _q: &[f64], v: &[f64], rows: &mut Rows) {
        self.set_directions(v, rows, 1..3);
    }

    fn interface(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        for (row, Pin { fixed, arm }) in self.geometry.pins.iter().enumerate() {
            let turned = self.rotation * arm;
            let span = Vector3::new(q[0], q[1], q[2]) + turned - fixed;
            let length = span.norm();
            let along = span / length;
            self.set_row(rows, row, turned, along);
            let velocity = Vector3::new(v[0], v[1], v[2]) + self.rotation * turning(v).cross(arm);
            let rate = velocity.dot(&along);
            let swing = (velocity.norm_squared() - rate * rate) / length;
            rows.convective[row] = centripetal(&self.rotation, v, *arm).dot(&along) + swing;
            rows.position[row] = length;
        }
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        let ball = self.geometry.ball.map_or(0.0, |ball| ball.mass * q[9]);
        self.geometry.gravity * (self.geometry.mass * q[2] + ball)
    }

    fn names(&self) -> ModelNames {
        let all = [
            "body_x_m",
            "body_y_m",
            "body_z_m",
            "yaw_rad",
            "pitch_rad",
            "roll_rad",
            "ball_x_m",
            "ball_y_m",
            "ball_z_m",
        ];
        ModelNames { observables: names(&all[..3 + 3 * self.bodies()]), contacts: self.contacts.clone() }
    }

    /// Writes the centre of mass, and the turns about z, the new y and the new x that give the orientation.
    fn observe(&self, q: &[f64], _v: &[f64], row: &mut [f64]) {
        let r = matrix([q[3], q[4], q[5], q[6]]);
        row[..3].copy_from_slice(&q[..3]);
        row[3] = libm::atan2(r[(1, 0)], r[(0, 0)]);
        row[4] = libm::asin((-r[(2, 0)]).clamp(-1.0, 1.0));
        row[5] = libm::atan2(r[(2, 1)], r[(2, 2)]);
        row[6..].copy_from_slice(&q[7..]);
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
            ball: Some(LedgeBall {
                mass: 0.5,
                radius: 0.2,
                pin: Vector3::new(-0.4, 0.2, -0.1),
                ledge: Ledge::new(-0.2, 0.05, 0.25),
            }),
        }
    }

    /// Rows and convective terms against differences of gaps and lengths along the motion of a body that turns freely,
    /// its ball about the corner of the ledge.
    #[test]
    fn rows_are_the_rates_of_gaps_and_lengths_and_convective_terms_those_of_rows() {
        let mut model = SpatialBody::new(body()).unwrap();
        let (mut q, mut v) = model.initial_state();
        v[6..].copy_from_slice(&[0.3, -0.4, -0.2, 0.6, 0.9, -0.8]);
        model.advance_positions(&mut q, &v, 0.4);
        assert!(SpatialBody::ball_contacts(&model.geometry.ball.unwrap(), &q)[0].0.curvature > 0.0, "{q:?}");
        let mut at = |time: f64| {
            let mut q = q.clone();
            model.advance_positions(&mut q, &v, time);
            model.prepare(&q, &v);
            let mut rows = [3, 6, 1, 3].map(|count| Rows::zeros(count, 12));
            let [normal, tangential, interface, joint] = &mut rows;
            model.unilateral(&q, &v, normal);
            model.tangential(&q, &v, tangential);
            model.interface(&q, &v, interface);
            model.bilateral(&q, &v, joint);
            rows
        };
        let step = 1e-5;
        let [before, now, after] = [-step, 0.0, step].map(&mut at);
        for block in 0..4 {
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
        let alone = SpatialBodyGeometry { ball: None, ..body() };
        let mut model = SpatialBody::new(alone.clone()).unwrap();
        let (mut q, mut v) = model.initial_state();
        let mut momentum = |q: &[f64], v: &[f64]| {
            model.prepare(q, v);
            model.rotation * Vector3::new(0.3 * v[3], 0.5 * v[4], 0.7 * v[5])
        };
        let start = momentum(&q, &v);
        let step = 1e-4;
        let mut model = SpatialBody::new(alone).unwrap();
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
