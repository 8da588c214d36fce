//! Mechanics of the wedge box: a box on wedges, with discs on revolute joints, each on a ledge with a ramp; and a block
//! without discs. With tangential rows for friction where the floor is level.

use super::ledge::{Ledge, SurfaceContact};
use super::rotation::rotation;
use super::washboard::Washboard;
use nalgebra::Vector2;
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};
use rimbench_core::name::{Name, names};

/// A disc on a revolute joint of the box, with its own ledge: discs roll on tracks of their own, beside that of the
/// supports.
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
pub struct WedgeBoxGeometry {
    /// kg.
    pub box_mass: f64,
    /// Width and height of the box, m: its inertia is that of a rectangle.
    pub box_size: [f64; 2],
    /// Tips of the wedges, m: the rightmost, the leftmost, then the others.
    pub wedges: Vec<[f64; 2]>,
    /// What names of columns call a wedge.
    pub wedge_name: &'static str,
    /// At most two discs.
    pub discs: Vec<LedgeDisc>,
    /// Height of the waves of the floor under the wedges, m, and their length, m, where there are any.
    pub washboard: [f64; 2],
    /// Distance of the first wave ahead of the rightmost wedge at the start, m.
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

impl WedgeBoxGeometry {
    /// Returns the inertia of the box about its centre of mass, kg·m².
    pub fn box_inertia(&self) -> f64 {
        let [width, height] = self.box_size;
        self.box_mass * (width * width + height * height) / 12.0
    }
}

/// The wedge box of the paper, of which there are kin with more wedges, with two discs or none, and waves on the floor:
///
#[doc = include_str!("wedge_box.md")]
///
/// Velocities: box `(ẋ, ẏ, ω)`, then each disc `(ẋ, ẏ, ω)`. Contacts: right and left wedge, then ledge and floor of
/// each disc, then the other wedges.
///
/// ```text
/// wedge      g = y_tip − f(x_tip),  ġ = (−f', 1)·v_tip      vertical distance from the floor y = f(x)
/// ```
/// The gap of a wedge is vertical, and so is its force: on a slope both are off from the normal ones by a factor that
/// the product, the work, does not see.
#[derive(Debug, Clone, PartialEq)]
pub struct WedgeBox {
    geometry: WedgeBoxGeometry,
    start: Vec<f64>,
    /// Diagonal of the mass matrix, and the force of gravity.
    mass: Vec<f64>,
    weight: Vec<f64>,
    ledges: Vec<Ledge>,
    floor: Washboard,
    ground_pin: Vector2<f64>,
    /// Tips of the wedges, pins of the discs and the attachment, box frame.
    points: Vec<Vector2<f64>>,
    /// The points turned into the world frame at the present angle.
    arms: Vec<Vector2<f64>>,
}

/// The first contacts: the wedges that have a name.
const NAMED_WEDGES: usize = 2;
/// Positions of up to a metre are rounded to this, m.
const ROUND_OFF: f64 = 1e-9;

impl WedgeBox {
    /// Places the box at rest.
    ///
    /// ```text
    /// no disc      at its start angle, on its lowest wedge
    /// one disc     on one wedge, the disc on its ledge
    /// two discs    both discs on their ledges, the wedges above the floor
    /// ```
    /// # Errors
    /// [`Error::Incompatible`] if no angle satisfies this, if a wedge or a disc would start inside the ground, or if
    /// the actuator would start with no length.
    pub fn new(geometry: WedgeBoxGeometry) -> Result<Self> {
        let pose = start_pose(&geometry)?;
        Self::at_rest(geometry, pose, |disc, centre| Ok(centre.x + disc.ledge_lead))
    }

    /// Places the box at rest and level, its first wedge on the floor and its discs against their ramps; the ledges are
    /// where they then must be, whatever their lead.
    ///
    /// ```text
    /// (c_disc − corner)·n_ramp = R
    /// ```
    /// # Errors
    /// [`Error::Incompatible`] if a disc would not touch its ramp between its corner and the floor; those of
    /// [`new`](Self::new).
    pub fn against_ramp(geometry: WedgeBoxGeometry) -> Result<Self> {
        let height = -geometry.wedges[0][1];
        Self::at_rest(geometry, (0.0, height), |disc, centre| {
            let LedgeDisc { radius, ledge_height, ramp_slope, .. } = *disc;
            let length = (1.0 + ramp_slope * ramp_slope).sqrt();
            let corner_x = centre.x - (radius * length - (centre.y - ledge_height)) / ramp_slope;
            // Down the ramp from its corner to the point below the disc, m.
            let along = ((centre.x - corner_x) - ramp_slope * (centre.y - ledge_height)) / length;
            if along > 0.0 {
                return Ok(corner_x);
            }
            Err(Error::Incompatible(format!(
                "impossible geometry: with both wedges on the floor the disc's centre is {:.4} m up, and so it cannot lean on a \
                 ramp of slope {ramp_slope} that falls from {ledge_height} m",
                centre.y
            )))
        })
    }

    /// Places the box at rest at this angle and height; `corner_x` says where the ledge of a disc with this centre
    /// ends.
    fn at_rest(
        geometry: WedgeBoxGeometry,
        (angle, height): (f64, f64),
        corner_x: impl Fn(&LedgeDisc, Vector2<f64>) -> Result<f64>,
    ) -> Result<Self> {
        debug_assert!(geometry.wedges.len() >= NAMED_WEDGES && geometry.discs.len() <= 2);
        let g = &geometry;
        let rotation = rotation(angle);
        let centre = Vector2::new(0.0, height);
        let place = |point: [f64; 2]| centre + rotation * Vector2::from(point);
        let mut start = vec![centre.x, centre.y, angle];
        let mut mass = vec![g.box_mass, g.box_mass, g.box_inertia()];
        let mut ledges = Vec::new();
        for disc in &g.discs {
            let position = place(disc.pin);
            start.extend([position.x, position.y, 0.0]);
            mass.extend([disc.mass, disc.mass, 0.5 * disc.mass * disc.radius * disc.radius]);
            ledges.push(Ledge::new(corner_x(disc, position)?, disc.ledge_height, disc.ramp_slope));
        }
        let points = g.wedges.iter().copied().chain(g.discs.iter().map(|disc| disc.pin)).chain([g.attachment]);
        let points: Vec<_> = points.map(Vector2::from).collect();
        let mut model = WedgeBox {
            ground_pin: Vector2::new(g.ground_pin_x, place(g.attachment).y),
            ledges,
            floor: Washboard::new(place(g.wedges[0]).x + g.washboard_lead, g.washboard),
            arms: points.clone(),
            points,
            weight: (0..mass.len()).map(|row| if row % 3 == 1 { -mass[row] * g.gravity } else { 0.0 }).collect(),
            mass,
            start,
            geometry,
        };
        model.prepare(&model.start.clone(), &[]);
        model.check_start()?;
        Ok(model)
    }

    /// Returns the actuator length at the start, m.
    pub fn start_length(&self) -> f64 {
        let centre = Vector2::new(self.start[0], self.start[1]);
        (centre + rotation(self.start[2]) * Vector2::from(self.geometry.attachment) - self.ground_pin).norm()
    }

    /// Returns its geometry.
    pub fn geometry(&self) -> &WedgeBoxGeometry {
        &self.geometry
    }

    /// Returns where the actuator is held, m.
    pub fn ground_pin(&self) -> [f64; 2] {
        self.ground_pin.into()
    }

    /// Returns the corners of the ledges, disc by disc, m.
    pub fn ledge_corners(&self) -> Vec<[f64; 2]> {
        self.ledges.iter().map(Ledge::corner).collect()
    }

    fn check_start(&self) -> Result<()> {
        let size = self.size();
        let mut rows = Rows::zeros(size.unilateral, size.velocities);
        self.unilateral(&self.start, &vec![0.0; size.velocities], &mut rows);
        for (contact, gap) in rows.position.iter().enumerate() {
            if *gap < -ROUND_OFF {
                let names = self.names();
                let name = names
                    .contacts
                    .get(contact)
                    .map_or("the gap of another wedge".into(), |name| format!("gap_{name}_m"));
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

    /// Row of the contact of a wedge.
    fn wedge_row(&self, wedge: usize) -> usize {
        if wedge < NAMED_WEDGES { wedge } else { wedge + 2 * self.geometry.discs.len() }
    }

    /// Tips of the wedges and pins of the discs, from the centre of the box.
    fn arms(&self) -> (&[Vector2<f64>], &[Vector2<f64>]) {
        let (wedges, pins) = self.arms.split_at(self.geometry.wedges.len());
        (wedges, &pins[..self.ledges.len()])
    }

    /// Rows of the contacts of a disc; apart, as preparing a loop of this takes more than its one turn or two save.
    #[inline(never)]
    fn contacts_of_disc(&self, disc: usize, q: &[f64], v: &[f64], rows: &mut Rows) {
        let (row, first) = (NAMED_WEDGES + 2 * disc, 3 + 3 * disc);
        let (contact, velocity) = self.ledge_contact(disc, q, v);
        let tangential = velocity.perp(&contact.normal);
        rows.set_planar_body(row, first, contact.normal, Vector2::zeros());
        rows.position[row] = contact.gap;
        rows.convective[row] = contact.curvature * tangential * tangential;
        rows.set_planar_body(row + 1, first, Vector2::new(0.0, 1.0), Vector2::zeros());
        rows.position[row + 1] = q[first + 1] - self.geometry.discs[disc].radius;
    }

    /// Contact of a disc with its ledge, and the velocity of its centre.
    #[inline(always)]
    fn ledge_contact(&self, disc: usize, q: &[f64], v: &[f64]) -> (SurfaceContact, Vector2<f64>) {
        let first = 3 + 3 * disc;
        let centre = Vector2::new(q[first], q[first + 1]);
        let contact = self.ledges[disc].contact(centre, self.geometry.discs[disc].radius);
        (contact, Vector2::new(v[first], v[first + 1]))
    }
}

/// Angle of the box and height of its centre at the start.
fn start_pose(g: &WedgeBoxGeometry) -> Result<(f64, f64)> {
    let rest = |disc: &LedgeDisc| disc.ledge_height + disc.radius;
    match g.discs.as_slice() {
        [] => {
            let lowest = |low: f64, tip: &[f64; 2]| low.min(turned_height(*tip, g.start_angle));
            Ok((g.start_angle, -g.wedges.iter().fold(f64::INFINITY, lowest)))
        }
        [disc] => {
            // The wedge that carries the box is the one with which no other is inside the floor.
            let mut nearest: Option<(f64, f64, f64)> = None;
            for tip in &g.wedges {
                let angle = level_angle(*tip, disc.pin, rest(disc))?;
                let height = -turned_height(*tip, angle);
                let clear =
                    g.wedges.iter().map(|tip| height + turned_height(*tip, angle)).fold(f64::INFINITY, f64::min);
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
pub(crate) fn level_angle(from: [f64; 2], to: [f64; 2], rise: f64) -> Result<f64> {
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

impl MechanicalModel for WedgeBox {
    fn size(&self) -> ModelSize {
        let discs = self.geometry.discs.len();
        let unilateral = self.geometry.wedges.len() + 2 * discs;
        ModelSize {
            velocities: 3 + 3 * discs,
            bilateral: 2 * discs,
            unilateral,
            tangential: if self.geometry.washboard[0] == 0.0 { unilateral } else { 0 },
            interface: 1,
            switches: 2 * self.ledges.len(),
            constant_mass: true,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.start.clone(), vec![0.0; self.start.len()])
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        let rotation = rotation(q[2]);
        self.arms.iter_mut().zip(&self.points).for_each(|(arm, point)| *arm = rotation * point);
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.copy_from_slice(&self.mass);
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&self.weight);
    }

    fn bilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let spin = v[2] * v[2];
        for (index, arm) in self.arms().1.iter().enumerate() {
            let first = 3 + 3 * index;
            for (axis, direction) in [Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)].into_iter().enumerate() {
                let row = 2 * index + axis;
                rows.set_planar_body(row, 0, -direction, *arm);
                rows.set_planar_body(row, first, direction, Vector2::zeros());
                rows.position[row] = q[first + axis] - q[axis] - arm[axis];
                rows.convective[row] = spin * arm[axis];
            }
        }
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let up = Vector2::new(0.0, 1.0);
        for (wedge, arm) in self.arms().0.iter().enumerate() {
            let (row, x) = (self.wedge_row(wedge), q[0] + arm.x);
            rows.set_planar_body(row, 0, up, *arm);
            rows.position[row] = q[1] + arm.y;
            rows.convective[row] = -v[2] * v[2] * arm.y;
            if self.floor.is_wavy(x) {
                let [height, slope, bend] = self.floor.at(x);
                let direction = Vector2::new(-slope, 1.0);
                let along = v[0] - v[2] * arm.y;
                rows.set_planar_body(row, 0, direction, *arm);
                rows.position[row] -= height;
                rows.convective[row] = -bend * along * along - v[2] * v[2] * arm.dot(&direction);
            }
        }
        for disc in 0..self.geometry.discs.len() {
            self.contacts_of_disc(disc, q, v, rows);
        }
    }

    /// None on a wavy floor: the force of a wedge is vertical, which on a slope is not along the normal.
    fn tangential(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let along = Vector2::new(1.0, 0.0);
        for (wedge, arm) in self.arms().0.iter().enumerate() {
            let row = self.wedge_row(wedge);
            rows.set_planar_body(row, 0, along, *arm);
            rows.convective[row] = -v[2] * v[2] * arm.x;
        }
        for (index, disc) in self.geometry.discs.iter().enumerate() {
            let (row, first) = (NAMED_WEDGES + 2 * index, 3 + 3 * index);
            let (SurfaceContact { normal, curvature, .. }, velocity) = self.ledge_contact(index, q, v);
            rows.set_planar_body(row, first, Vector2::new(normal.y, -normal.x), -disc.radius * normal);
            rows.convective[row] = -curvature * velocity.perp(&normal) * velocity.dot(&normal);
            rows.set_planar_body(row + 1, first, along, Vector2::new(0.0, -disc.radius));
        }
    }

    fn interface(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let arm = self.arms[self.arms.len() - 1];
        let along = Vector2::new(q[0], q[1]) + arm - self.ground_pin;
        let length = along.norm();
        let direction = along / length;
        let across = direction.perp(&Vector2::new(v[0] - v[2] * arm.y, v[1] + v[2] * arm.x));
        rows.set_planar_body(0, 0, direction, arm);
        rows.position[0] = length;
        rows.convective[0] = across * across / length - v[2] * v[2] * direction.dot(&arm);
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

    fn names(&self) -> ModelNames {
        let mut observables = names(&["box_x_m", "box_y_m", "box_angle_rad", "box_rate_rad_s"]);
        let wedge = self.geometry.wedge_name;
        observables.push(format!("gap_{wedge}s_least_m").into());
        if self.geometry.discs.len() == 1 {
            observables.push("disc_ledge_normal_rad".into());
        }
        let discs: &[&str] = match self.geometry.discs.len() {
            0 => &[],
            1 => &["disc"],
            _ => &["left_disc", "right_disc"],
        };
        let wedges = [format!("right_{wedge}"), format!("left_{wedge}")].into_iter();
        let at_discs = discs.iter().flat_map(|disc| [format!("{disc}_ledge"), format!("{disc}_floor")]);
        ModelNames { observables, contacts: wedges.chain(at_discs).map(Name::from).collect() }
    }

    fn observe(&self, q: &[f64], v: &[f64], row: &mut [f64]) {
        let gap = |arm: &Vector2<f64>| q[1] + arm.y - self.floor.at(q[0] + arm.x)[0];
        let least = self.arms().0.iter().map(gap).fold(f64::INFINITY, f64::min);
        row[..5].copy_from_slice(&[q[0], q[1], q[2], v[2], least]);
        if let [normal] = &mut row[5..] {
            let contact = self.ledge_contact(0, q, v).0.normal;
            *normal = libm::atan2(contact.y, contact.x);
        }
    }
}
