//! Mechanics of a box on any number of supports, with discs on ledges beside it: the wedge box, multiplied. With tangential
//! rows for friction where it stands on a level floor without discs.

use super::ledge::Ledge;
use super::rotation::rotation;
use super::washboard::Washboard;
use nalgebra::{Rotation2, Vector2};
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::{MassMatrix, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelSize};
use rimbench_core::name::{Name, names};

/// A disc on a revolute joint of the box, with its own ledge: discs roll on tracks of their own, beside that of the supports.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LedgeDisc {
    /// kg.
    pub mass: f64,
    /// m.
    pub radius: f64,
    /// Joint, box frame, m.
    pub pin: [f64; 2],
    /// Height of its ledge above the floor, m.
    pub ledge_height: f64,
    /// Distance of the ledge's corner ahead of the disc's centre at the start, m.
    pub ledge_lead: f64,
    /// Fall over run of its ramp.
    pub ramp_slope: f64,
}

/// Geometry and masses. Points of the box are in its frame, whose origin is the centre of mass.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SupportedBoxGeometry {
    /// kg.
    pub box_mass: f64,
    /// About the centre of mass, kg·m².
    pub box_inertia: f64,
    /// Tips of the supports, m: the rightmost, the leftmost, then the others.
    pub supports: Vec<[f64; 2]>,
    /// At most two discs.
    pub discs: Vec<LedgeDisc>,
    /// Height of the waves of the floor under the supports, m, and their length, m, where there are any.
    pub washboard: [f64; 2],
    /// Distance of the first wave ahead of the rightmost support at the start, m.
    pub washboard_lead: f64,
    /// Angle at the start where there is no disc to fix it, rad.
    pub start_angle: f64,
    /// Where the actuator holds the box, box frame, m.
    pub attachment: [f64; 2],
    /// x of the actuator's fixed end, m; its y is the attachment's height at the start.
    pub ground_pin_x: f64,
    /// m/s².
    pub gravity: f64,
}

/// Velocities: box `(ẋ, ẏ, ω)`, then each disc `(ẋ, ẏ, ω)`. Contacts: right and left support, then ledge and floor of each disc,
/// then the other supports.
///
/// ```text
/// support    g = y_tip − f(x_tip),  ġ = (−f', 1)·v_tip      vertical distance from the floor y = f(x)
/// ```
/// The gap of a support is vertical, and so is its force: on a slope both are off from the normal ones by a factor that the
/// product, the work, does not see.
#[derive(Debug, Clone, PartialEq)]
pub struct SupportedBox {
    geometry: SupportedBoxGeometry,
    start: Vec<f64>,
    ledges: Vec<Ledge>,
    floor: Washboard,
    ground_pin: Vector2<f64>,
    /// Turns box points into the world frame at the present angle.
    rotation: Rotation2<f64>,
}

/// The first contacts: the supports that have a name.
const NAMED_SUPPORTS: usize = 2;
/// Positions of up to a metre are rounded to this, m.
const ROUND_OFF: f64 = 1e-9;

impl SupportedBox {
    /// Places the box at rest.
    ///
    /// ```text
    /// no disc      at its start angle, on its lowest support
    /// one disc     on one support, the disc on its ledge
    /// two discs    both discs on their ledges, the supports above the floor
    /// ```
    /// # Errors
    /// [`Error::Incompatible`] if no angle satisfies this, if a support or a disc would start inside the ground, or if the
    /// actuator would start with no length.
    pub fn new(geometry: SupportedBoxGeometry) -> Result<Self> {
        debug_assert!(geometry.supports.len() >= NAMED_SUPPORTS && geometry.discs.len() <= 2);
        let g = &geometry;
        let (angle, height) = start_pose(g)?;
        let rotation = rotation(angle);
        let centre = Vector2::new(0.0, height);
        let place = |point: [f64; 2]| centre + rotation * Vector2::from(point);
        let mut start = vec![centre.x, centre.y, angle];
        let mut ledges = Vec::new();
        for disc in &g.discs {
            let position = place(disc.pin);
            start.extend([position.x, position.y, 0.0]);
            ledges.push(Ledge::new(position.x + disc.ledge_lead, disc.ledge_height, disc.ramp_slope));
        }
        let attachment = place(g.attachment);
        let floor = Washboard::new(place(g.supports[0]).x + g.washboard_lead, g.washboard);
        let model = SupportedBox {
            ground_pin: Vector2::new(g.ground_pin_x, attachment.y),
            ledges,
            floor,
            rotation,
            start,
            geometry,
        };
        model.check_start()?;
        Ok(model)
    }

    /// Returns the actuator length at the start, m.
    pub fn start_length(&self) -> f64 {
        let centre = Vector2::new(self.start[0], self.start[1]);
        (centre + rotation(self.start[2]) * Vector2::from(self.geometry.attachment) - self.ground_pin).norm()
    }

    fn check_start(&self) -> Result<()> {
        let size = self.size();
        let mut rows = Rows::zeros(size.unilateral, size.velocities);
        self.unilateral(&self.start, &vec![0.0; size.velocities], &mut rows);
        for (contact, gap) in rows.position.iter().enumerate() {
            if *gap < -ROUND_OFF {
                let name = self.gap_names().get(contact).cloned().unwrap_or("the gap of another support".into());
                return Err(Error::Incompatible(format!(
                    "impossible geometry: {name} would start at {gap:.6} m, inside the ground"
                )));
            }
        }
        if self.start_length() < 1e-6 {
            return Err(Error::Incompatible("impossible geometry: the actuator would start with no length".into()));
        }
        Ok(())
    }

    fn arm(&self, point: [f64; 2]) -> Vector2<f64> {
        self.rotation * Vector2::from(point)
    }

    /// Row in which the contact of a support stands.
    fn support_row(&self, support: usize) -> usize {
        if support < NAMED_SUPPORTS { support } else { support + 2 * self.geometry.discs.len() }
    }
}

/// Angle of the box and height of its centre at the start.
fn start_pose(g: &SupportedBoxGeometry) -> Result<(f64, f64)> {
    let rest = |disc: &LedgeDisc| disc.ledge_height + disc.radius;
    match g.discs.as_slice() {
        [] => {
            let lowest = |low: f64, tip: &[f64; 2]| low.min(turned_height(*tip, g.start_angle));
            Ok((g.start_angle, -g.supports.iter().fold(f64::INFINITY, lowest)))
        }
        [disc] => {
            // The support that carries the box is the one with which no other is inside the floor.
            let mut nearest: Option<(f64, f64, f64)> = None;
            for tip in &g.supports {
                let angle = level_angle(*tip, disc.pin, rest(disc))?;
                let height = -turned_height(*tip, angle);
                let clear =
                    g.supports.iter().map(|tip| height + turned_height(*tip, angle)).fold(f64::INFINITY, f64::min);
                if nearest.is_none_or(|(_, _, best)| clear > best) {
                    nearest = Some((angle, height, clear));
                }
            }
            let (angle, height, _) = nearest.unwrap_or_default();
            Ok((angle, height))
        }
        [first, second, ..] => {
            let angle = level_angle(first.pin, second.pin, rest(second) - rest(first))?;
            Ok((angle, rest(first) - turned_height(first.pin, angle)))
        }
    }
}

/// Height of a point of the box above its centre, m.
fn turned_height(point: [f64; 2], angle: f64) -> f64 {
    point[0] * libm::sin(angle) + point[1] * libm::cos(angle)
}

/// The angle, of the two closest to level, at which `to` is `rise` (m) above `from`.
fn level_angle(from: [f64; 2], to: [f64; 2], rise: f64) -> Result<f64> {
    let across = Vector2::from(to) - Vector2::from(from);
    let reach = across.norm();
    if rise.abs() > reach {
        return Err(Error::Incompatible(format!(
            "impossible geometry: two points of the box are {reach:.4} m apart, but at the start one would have to be \
             {rise:.4} m above the other"
        )));
    }
    // across.x sin θ + across.y cos θ = rise.
    let (sum, offset) = (libm::asin(rise / reach), libm::atan2(across.y, across.x));
    let wrap = |angle: f64| libm::atan2(libm::sin(angle), libm::cos(angle));
    let (first, second) = (wrap(sum - offset), wrap(std::f64::consts::PI - sum - offset));
    Ok(if first.abs() < second.abs() { first } else { second })
}

impl MechanicalModel for SupportedBox {
    fn size(&self) -> ModelSize {
        let discs = self.geometry.discs.len();
        ModelSize {
            velocities: 3 + 3 * discs,
            bilateral: 2 * discs,
            unilateral: self.geometry.supports.len() + 2 * discs,
            interface: 1,
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.start.clone(), vec![0.0; self.start.len()])
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        self.rotation = rotation(q[2]);
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut MassMatrix) {
        if let MassMatrix::Diagonal(diagonal) = mass {
            let g = &self.geometry;
            diagonal[..3].copy_from_slice(&[g.box_mass, g.box_mass, g.box_inertia]);
            for (disc, entries) in g.discs.iter().zip(diagonal[3..].chunks_exact_mut(3)) {
                entries.copy_from_slice(&[disc.mass, disc.mass, 0.5 * disc.mass * disc.radius * disc.radius]);
            }
        }
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.fill(0.0);
        force[1] = -self.geometry.box_mass * self.geometry.gravity;
        for (disc, entries) in self.geometry.discs.iter().zip(force[3..].chunks_exact_mut(3)) {
            entries[1] = -disc.mass * self.geometry.gravity;
        }
    }

    fn bilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let spin = v[2] * v[2];
        for (index, disc) in self.geometry.discs.iter().enumerate() {
            let (arm, first) = (self.arm(disc.pin), 3 + 3 * index);
            let error = Vector2::new(q[first] - q[0], q[first + 1] - q[1]) - arm;
            for (row, direction) in [(2 * index, Vector2::new(1.0, 0.0)), (2 * index + 1, Vector2::new(0.0, 1.0))] {
                rows.set_planar_body(row, 0, -direction, arm);
                rows.set_planar_body(row, first, direction, Vector2::zeros());
                rows.position[row] = error.dot(&direction);
                rows.convective[row] = spin * arm.dot(&direction);
            }
        }
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        for (support, tip) in self.geometry.supports.iter().enumerate() {
            let (row, arm) = (self.support_row(support), self.arm(*tip));
            let [height, slope, bend] = self.floor.at(q[0] + arm.x);
            let direction = Vector2::new(-slope, 1.0);
            let along = v[0] - v[2] * arm.y;
            rows.set_planar_body(row, 0, direction, arm);
            rows.position[row] = q[1] + arm.y - height;
            rows.convective[row] = -bend * along * along - v[2] * v[2] * arm.dot(&direction);
        }
        for (index, (disc, ledge)) in self.geometry.discs.iter().zip(&self.ledges).enumerate() {
            let (row, first) = (NAMED_SUPPORTS + 2 * index, 3 + 3 * index);
            let contact = ledge.contact(Vector2::new(q[first], q[first + 1]), disc.radius);
            let tangential = Vector2::new(v[first], v[first + 1]).perp(&contact.normal);
            rows.set_planar_body(row, first, contact.normal, Vector2::zeros());
            rows.position[row] = contact.gap;
            rows.convective[row] = contact.curvature * tangential * tangential;
            rows.set_planar_body(row + 1, first, Vector2::new(0.0, 1.0), Vector2::zeros());
            rows.position[row + 1] = q[first + 1] - disc.radius;
        }
    }

    /// The force of a support is vertical, which on a slope is not along the normal; ledges of discs are not offered.
    fn tangential_rows(&self) -> usize {
        if self.geometry.discs.is_empty() && self.geometry.washboard[0] == 0.0 {
            self.geometry.supports.len()
        } else {
            0
        }
    }

    fn tangential(&self, _q: &[f64], v: &[f64], rows: &mut Rows) {
        for (support, tip) in self.geometry.supports.iter().enumerate() {
            let arm = self.arm(*tip);
            rows.set_planar_body(support, 0, Vector2::new(1.0, 0.0), arm);
            rows.convective[support] = -v[2] * v[2] * arm.x;
        }
    }

    fn interface(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let arm = self.arm(self.geometry.attachment);
        let along = Vector2::new(q[0], q[1]) + arm - self.ground_pin;
        let length = along.norm();
        let direction = along / length;
        let across = direction.perp(&Vector2::new(v[0] - v[2] * arm.y, v[1] + v[2] * arm.x));
        rows.set_planar_body(0, 0, direction, arm);
        rows.position[0] = length;
        rows.convective[0] = across * across / length - v[2] * v[2] * direction.dot(&arm);
    }

    fn switches(&self) -> usize {
        2 * self.ledges.len()
    }

    fn switch_values(&self, q: &[f64], v: &[f64], switches: &mut [[f64; 2]]) {
        for (index, (ledge, switches)) in self.ledges.iter().zip(switches.chunks_exact_mut(2)).enumerate() {
            let first = 3 + 3 * index;
            let of_disc = |x: &[f64]| Vector2::new(x[first], x[first + 1]);
            switches.copy_from_slice(&ledge.borders(of_disc(q), of_disc(v)));
        }
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        let of_discs = self.geometry.discs.iter().zip(q[3..].chunks_exact(3)).map(|(disc, q)| disc.mass * q[1]);
        self.geometry.gravity * (self.geometry.box_mass * q[1] + of_discs.sum::<f64>())
    }

    fn observables(&self) -> Vec<Name> {
        names(&["box_x_m", "box_y_m", "box_angle_rad", "box_rate_rad_s", "gap_supports_least_m"])
    }

    fn gap_names(&self) -> Vec<Name> {
        match self.geometry.discs.len() {
            0 => names(&["gap_right_support_m", "gap_left_support_m"]),
            1 => names(&["gap_right_support_m", "gap_left_support_m", "gap_disc_ledge_m", "gap_disc_floor_m"]),
            _ => names(&[
                "gap_right_support_m",
                "gap_left_support_m",
                "gap_left_disc_ledge_m",
                "gap_left_disc_floor_m",
                "gap_right_disc_ledge_m",
                "gap_right_disc_floor_m",
            ]),
        }
    }

    fn contact_force_names(&self) -> Vec<Name> {
        names(&["contact_force_right_support_n", "contact_force_left_support_n"])
    }

    fn observe(&self, q: &[f64], v: &[f64], row: &mut [f64]) {
        let gap = |tip: &[f64; 2]| {
            let tip = Vector2::new(q[0], q[1]) + self.arm(*tip);
            tip.y - self.floor.at(tip.x)[0]
        };
        let least = self.geometry.supports.iter().map(gap).fold(f64::INFINITY, f64::min);
        row.copy_from_slice(&[q[0], q[1], q[2], v[2], least]);
    }
}
