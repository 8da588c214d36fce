//! Mechanics of the wedge box: a box on two wedges, a disc on a revolute joint, floor, ledge and ramp, with tangential rows for friction.

use super::ledge::{Ledge, SurfaceContact};
use super::rotation::rotation;
use nalgebra::Vector2;
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::{MassMatrix, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelSize};
use rimbench_core::name::{Name, names};

/// Geometry and masses. Points of the box are in its frame, whose origin is the centre of mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WedgeBoxGeometry {
    /// kg.
    pub box_mass: f64,
    /// Width and height of the box, m.
    pub box_size: [f64; 2],
    /// Tip of the right wedge, box frame, m; the left one is its mirror image.
    pub wedge_tip: [f64; 2],
    /// kg.
    pub disc_mass: f64,
    /// m.
    pub disc_radius: f64,
    /// Joint of the disc, box frame, m.
    pub disc_pin: [f64; 2],
    /// m.
    pub ledge_height: f64,
    /// Distance of the ledge's corner ahead of the disc's centre at the start, m.
    pub ledge_lead: f64,
    /// Fall over run.
    pub ramp_slope: f64,
    /// Where the actuator holds the box, box frame, m.
    pub attachment: [f64; 2],
    /// x of the actuator's fixed end, m; its y is the attachment's height at the start.
    pub ground_pin_x: f64,
    /// m/s².
    pub gravity: f64,
}

/// Velocities: box `(ẋ, ẏ, ω)`, disc `(ẋ, ẏ, ω)`. Contacts: right wedge–floor, left wedge–floor, disc–ledge, disc–floor.
#[derive(Debug, Clone, PartialEq)]
pub struct WedgeBox {
    geometry: WedgeBoxGeometry,
    start: [f64; 6],
    mass: [f64; 6],
    ledge: Ledge,
    ground_pin: Vector2<f64>,
    /// Box points turned into the world frame at the present angle: right tip, left tip, disc pin, attachment.
    arms: [Vector2<f64>; 4],
}

const BOX: usize = 0;
const DISC: usize = 3;
const RIGHT_WEDGE: usize = 0;
const LEFT_WEDGE: usize = 1;
const DISC_LEDGE: usize = 2;
const DISC_FLOOR: usize = 3;

impl WedgeBox {
    /// Places the box at rest with the right wedge on the floor and the disc on the ledge.
    ///
    /// ```text
    /// y_right = 0,  y_disc = h_ledge + R    ⇒    (x_d − x_w) sin θ + (y_d − y_w) cos θ = h_ledge + R
    /// ```
    /// # Errors
    /// [`Error::Incompatible`] if no angle satisfies this, if the left wedge or the disc would start inside the floor,
    /// or if the actuator would start with no length.
    pub fn new(geometry: WedgeBoxGeometry) -> Result<Self> {
        let g = &geometry;
        let (tip, pin) = (Vector2::from(g.wedge_tip), Vector2::from(g.disc_pin));
        let across = pin - tip;
        let rise = g.ledge_height + g.disc_radius;
        let reach = across.norm();
        if rise.abs() > reach {
            return Err(Error::Incompatible(format!(
                "the disc cannot rest on the ledge: its centre would have to be {rise} m above the right wedge tip, \
                 but is only {reach:.4} m away from it"
            )));
        }
        // across.x sin θ + across.y cos θ = rise has two solutions; take the one closest to level.
        let (sum, offset) = (libm::asin(rise / reach), libm::atan2(across.y, across.x));
        let wrap = |angle: f64| libm::atan2(libm::sin(angle), libm::cos(angle));
        let (first, second) = (wrap(sum - offset), wrap(std::f64::consts::PI - sum - offset));
        let angle = if first.abs() < second.abs() { first } else { second };
        let lead = g.ledge_lead;
        Self::at_rest(geometry, angle, |disc, _| Ok(disc.x + lead))
    }

    /// Places the box at rest and level, both wedges on the floor and the disc against the ramp; the ledge is where it then must be,
    /// whatever its lead says.
    ///
    /// ```text
    /// (c_disc − corner)·n_ramp = R
    /// ```
    /// # Errors
    /// [`Error::Incompatible`] if the disc would not touch the ramp between its corner and the floor; those of [`new`](Self::new).
    pub fn against_ramp(geometry: WedgeBoxGeometry) -> Result<Self> {
        let g = geometry;
        Self::at_rest(geometry, 0.0, |disc, radius| {
            let length = (1.0 + g.ramp_slope * g.ramp_slope).sqrt();
            let corner_x = disc.x - (radius * length - (disc.y - g.ledge_height)) / g.ramp_slope;
            // Down the ramp from its corner to the point below the disc, m.
            let along = ((disc.x - corner_x) - g.ramp_slope * (disc.y - g.ledge_height)) / length;
            if along > 0.0 {
                return Ok(corner_x);
            }
            Err(Error::Incompatible(format!(
                "impossible geometry: with both wedges on the floor the disc's centre is {:.4} m up, and so it cannot lean on a \
                 ramp of slope {} that falls from {} m",
                disc.y, g.ramp_slope, g.ledge_height
            )))
        })
    }

    /// Places the box at rest at `angle` with the right wedge on the floor; `corner_x` says where the ledge's corner is for a disc
    /// with this centre and radius.
    fn at_rest(
        geometry: WedgeBoxGeometry,
        angle: f64,
        corner_x: impl FnOnce(Vector2<f64>, f64) -> Result<f64>,
    ) -> Result<Self> {
        let g = &geometry;
        let (tip, pin) = (Vector2::from(g.wedge_tip), Vector2::from(g.disc_pin));
        let rotation = rotation(angle);
        let centre = Vector2::new(0.0, -(rotation * tip).y);
        let disc = centre + rotation * pin;
        let corner_x = corner_x(disc, g.disc_radius)?;
        let attachment = centre + rotation * Vector2::from(g.attachment);
        let [width, height] = g.box_size;
        let box_inertia = g.box_mass * (width * width + height * height) / 12.0;
        let disc_inertia = 0.5 * g.disc_mass * g.disc_radius * g.disc_radius;
        let mut model = WedgeBox {
            start: [centre.x, centre.y, angle, disc.x, disc.y, 0.0],
            mass: [g.box_mass, g.box_mass, box_inertia, g.disc_mass, g.disc_mass, disc_inertia],
            ledge: Ledge::new(corner_x, g.ledge_height, g.ramp_slope),
            ground_pin: Vector2::new(g.ground_pin_x, attachment.y),
            arms: [Vector2::zeros(); 4],
            geometry,
        };
        model.prepare(&model.start.clone(), &[0.0; 6]);
        model.check_start()?;
        Ok(model)
    }

    /// Returns the actuator length at the start, m.
    pub fn start_length(&self) -> f64 {
        (Vector2::new(self.start[0], self.start[1]) + self.arms[3] - self.ground_pin).norm()
    }

    fn check_start(&self) -> Result<()> {
        let mut rows = Rows::zeros(4, 6);
        self.unilateral(&self.start, &[0.0; 6], &mut rows);
        for (name, gap) in self.gap_names().iter().zip(&rows.position) {
            if *gap < -1e-9 {
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
}

impl MechanicalModel for WedgeBox {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: 6, bilateral: 2, unilateral: 4, interface: 1 }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.start.to_vec(), vec![0.0; 6])
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        let rotation = rotation(q[2]);
        let g = &self.geometry;
        let [tip_x, tip_y] = g.wedge_tip;
        self.arms =
            [[tip_x, tip_y], [-tip_x, tip_y], g.disc_pin, g.attachment].map(|point| rotation * Vector2::from(point));
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut MassMatrix) {
        if let MassMatrix::Diagonal(diagonal) = mass {
            diagonal.copy_from_slice(&self.mass);
        }
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&[
            0.0,
            -self.geometry.box_mass * self.geometry.gravity,
            0.0,
            0.0,
            -self.geometry.disc_mass * self.geometry.gravity,
            0.0,
        ]);
    }

    fn bilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let pin = self.arms[2];
        let error = [q[3] - q[0] - pin.x, q[4] - q[1] - pin.y];
        let spin = v[2] * v[2];
        for (row, direction) in [Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)].into_iter().enumerate() {
            rows.set_planar_body(row, BOX, -direction, pin);
            rows.set_planar_body(row, DISC, direction, Vector2::zeros());
            rows.position[row] = error[row];
            rows.convective[row] = spin * pin.dot(&direction);
        }
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let up = Vector2::new(0.0, 1.0);
        for (row, arm) in [(RIGHT_WEDGE, self.arms[0]), (LEFT_WEDGE, self.arms[1])] {
            rows.set_planar_body(row, BOX, up, arm);
            rows.position[row] = q[1] + arm.y;
            rows.convective[row] = -v[2] * v[2] * arm.y;
        }
        let radius = self.geometry.disc_radius;
        let ledge = self.ledge.contact(Vector2::new(q[3], q[4]), radius);
        let velocity = Vector2::new(v[3], v[4]);
        let tangential = velocity.perp(&ledge.normal);
        rows.set_planar_body(DISC_LEDGE, DISC, ledge.normal, Vector2::zeros());
        rows.position[DISC_LEDGE] = ledge.gap;
        rows.convective[DISC_LEDGE] = ledge.curvature * tangential * tangential;
        rows.set_planar_body(DISC_FLOOR, DISC, up, Vector2::zeros());
        rows.position[DISC_FLOOR] = q[4] - radius;
        rows.convective[DISC_FLOOR] = 0.0;
    }

    fn tangential_rows(&self) -> usize {
        4
    }

    fn tangential(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let along = Vector2::new(1.0, 0.0);
        for (row, arm) in [(RIGHT_WEDGE, self.arms[0]), (LEFT_WEDGE, self.arms[1])] {
            rows.set_planar_body(row, BOX, along, arm);
            rows.convective[row] = -v[2] * v[2] * arm.x;
        }
        let radius = self.geometry.disc_radius;
        let SurfaceContact { normal, curvature, .. } = self.ledge.contact(Vector2::new(q[3], q[4]), radius);
        let velocity = Vector2::new(v[3], v[4]);
        rows.set_planar_body(DISC_LEDGE, DISC, Vector2::new(normal.y, -normal.x), -radius * normal);
        rows.convective[DISC_LEDGE] = -curvature * velocity.perp(&normal) * velocity.dot(&normal);
        rows.set_planar_body(DISC_FLOOR, DISC, along, Vector2::new(0.0, -radius));
        rows.convective[DISC_FLOOR] = 0.0;
    }

    fn interface(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let arm = self.arms[3];
        let along = Vector2::new(q[0], q[1]) + arm - self.ground_pin;
        let length = along.norm();
        let direction = along / length;
        let velocity = Vector2::new(v[0] - v[2] * arm.y, v[1] + v[2] * arm.x);
        let across = direction.perp(&velocity);
        rows.set_planar_body(0, BOX, direction, arm);
        rows.position[0] = length;
        rows.convective[0] = across * across / length - v[2] * v[2] * direction.dot(&arm);
    }

    fn switches(&self) -> usize {
        2
    }

    fn switch_values(&self, q: &[f64], v: &[f64], switches: &mut [[f64; 2]]) {
        switches.copy_from_slice(&self.ledge.borders(Vector2::new(q[3], q[4]), Vector2::new(v[3], v[4])));
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.geometry.gravity * (self.geometry.box_mass * q[1] + self.geometry.disc_mass * q[4])
    }

    fn observables(&self) -> Vec<Name> {
        names(&["box_x_m", "box_y_m", "box_angle_rad", "disc_ledge_normal_rad"])
    }

    fn gap_names(&self) -> Vec<Name> {
        names(&["gap_right_wedge_m", "gap_left_wedge_m", "gap_disc_ledge_m", "gap_disc_floor_m"])
    }

    fn contact_force_names(&self) -> Vec<Name> {
        names(&[
            "contact_force_right_wedge_n",
            "contact_force_left_wedge_n",
            "contact_force_disc_ledge_n",
            "contact_force_disc_floor_n",
        ])
    }

    fn observe(&self, q: &[f64], _v: &[f64], row: &mut [f64]) {
        let normal = self.ledge.contact(Vector2::new(q[3], q[4]), self.geometry.disc_radius).normal;
        row.copy_from_slice(&[q[0], q[1], q[2], libm::atan2(normal.y, normal.x)]);
    }
}
