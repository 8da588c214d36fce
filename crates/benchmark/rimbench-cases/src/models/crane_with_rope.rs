//! The hydraulic crane with its load on a rope above the ground: two contacts that open and close.

use super::crane::{Crane, CraneGeometry};
use nalgebra::Vector2;
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};

/// One link of a crane, driven by the actuator, and a point load on a massless rope that can only pull.
///
#[doc = include_str!("crane_with_rope.md")]
///
/// Coordinates: the angle θ of the link, the load's place. With d from the end of the link to the load, n = d/|d|:
///
/// ```text
/// A_rope = [n·P', −n_x, −n_y]       Ȧv_rope = n·P'' θ̇² − |ḋ_⊥|²/|d|       A_ground = [0, 0, 1]       A_t = [0, 1, 0]
/// ```
/// While the rope is taut this is [`Crane`] with link 2 as the rope.
/// # Source
/// Geometry and masses of the LIM cosim-benchmarks; rope and ground are ours.
#[derive(Debug, Clone, PartialEq)]
pub struct CraneWithRope {
    geometry: CraneGeometry,
    crane: Crane,
    ground_height: f64,
    /// Where the load starts.
    load: [f64; 2],
    /// `P'` at the prepared angle; `P = [P'_y, −P'_x]`.
    tip_rate: Vector2<f64>,
}

const ROPE: usize = 0;
const GROUND: usize = 1;

impl CraneWithRope {
    /// Lets the load hang at rest; `link_2_length` is the length of the rope, the second start angle is taken as −90°.
    ///
    /// # Errors
    /// Those of [`Crane::new`]; [`Error::Incompatible`] if the load would start inside the ground.
    pub fn new(mut geometry: CraneGeometry, ground_height: f64) -> Result<Self> {
        geometry.start_angles[1] = -std::f64::consts::FRAC_PI_2;
        let crane = Crane::new(geometry)?;
        let (sin, cos) = libm::sincos(geometry.start_angles[0]);
        let load = [geometry.link_1_length * cos, geometry.link_1_length * sin - geometry.link_2_length];
        if load[1] < ground_height {
            return Err(Error::Incompatible(format!(
                "impossible geometry: the load would start at a height of {:.6} m, inside the ground at \
                 ground_height_m = {ground_height}",
                load[1]
            )));
        }
        Ok(Self::started(geometry, crane, ground_height, load))
    }

    /// Lets the load lie on the ground `offset` (m) further out than the end of the link, the rope straight and without
    /// tension.
    ///
    /// # Errors
    /// Those of [`Crane::new`]; [`Error::Incompatible`] if the rope does not reach as far.
    pub fn with_load_on_ground(mut geometry: CraneGeometry, offset: f64) -> Result<Self> {
        geometry.start_angles[1] = -std::f64::consts::FRAC_PI_2;
        let crane = Crane::new(geometry)?;
        let rope = geometry.link_2_length;
        if offset.abs() >= rope {
            return Err(Error::Incompatible(format!(
                "impossible geometry: the load would start {offset} m aside of the end of the link, beyond the rope of {rope} m"
            )));
        }
        let (sin, cos) = libm::sincos(geometry.start_angles[0]);
        let height = geometry.link_1_length * sin - (rope * rope - offset * offset).sqrt();
        Ok(Self::started(geometry, crane, height, [geometry.link_1_length * cos + offset, height]))
    }

    fn started(geometry: CraneGeometry, crane: Crane, ground_height: f64, load: [f64; 2]) -> Self {
        let mut model = CraneWithRope { geometry, crane, ground_height, load, tip_rate: Vector2::zeros() };
        let (q, v) = model.initial_state();
        model.prepare(&q, &v);
        model
    }

    /// Returns the actuator force that balances the weight of the link alone at the start, N.
    pub fn link_force(&self) -> f64 {
        let g = &self.geometry;
        let (_, lever, _) = self.crane.actuator();
        g.gravity * (0.5 * g.rod_mass + g.joint_mass) * g.link_1_length * libm::cos(g.start_angles[0]) / lever
    }

    /// Returns the crane it is while the rope is taut and hangs straight down.
    pub fn taut(&self) -> &Crane {
        &self.crane
    }

    /// Inertia of the link about its joint, kg·m².
    pub(super) fn link_inertia(&self) -> f64 {
        let g = &self.geometry;
        g.link_1_length * g.link_1_length * (g.rod_mass / 3.0 + g.joint_mass)
    }

    /// Row of the rope in the link's angle and the load's place, its gap and convective term.
    #[inline]
    pub(super) fn rope_row(&self, q: &[f64], v: &[f64]) -> ([f64; 3], f64, f64) {
        let rope = self.rope(q);
        let length = rope.norm();
        let normal = rope / length;
        let rate = Vector2::new(v[1], v[2]) - v[0] * self.tip_rate;
        let across = normal.perp(&rate);
        // P'' = −P.
        let bend = Vector2::new(-self.tip_rate.y, self.tip_rate.x);
        let convective = normal.dot(&bend) * v[0] * v[0] - across * across / length;
        ([normal.dot(&self.tip_rate), -normal.x, -normal.y], self.geometry.link_2_length - length, convective)
    }

    /// From the end of the link to the load.
    fn rope(&self, q: &[f64]) -> Vector2<f64> {
        Vector2::new(q[1] - self.tip_rate.y, q[2] + self.tip_rate.x)
    }
}

impl MechanicalModel for CraneWithRope {
    fn size(&self) -> ModelSize {
        ModelSize {
            velocities: 3,
            unilateral: 2,
            tangential: 2,
            interface: 1,
            constant_mass: true,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![self.geometry.start_angles[0], self.load[0], self.load[1]], vec![0.0; 3])
    }

    fn prepare(&mut self, q: &[f64], v: &[f64]) {
        let (sin, cos) = libm::sincos(q[0]);
        self.tip_rate = self.geometry.link_1_length * Vector2::new(-sin, cos);
        self.crane.prepare(&[q[0], -std::f64::consts::FRAC_PI_2], &[v[0], 0.0]);
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        let load = self.geometry.end_mass;
        mass.copy_from_slice(&[self.link_inertia(), load, load]);
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        let g = &self.geometry;
        let lifted = 0.5 * g.rod_mass + g.joint_mass;
        force.copy_from_slice(&[-g.gravity * lifted * self.tip_rate.y, 0.0, -g.gravity * g.end_mass]);
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let (row, position, convective) = self.rope_row(q, v);
        rows.jacobian[..3].copy_from_slice(&row);
        rows.position[ROPE] = position;
        rows.convective[ROPE] = convective;
        rows.jacobian[5] = 1.0;
        rows.position[GROUND] = q[2] - self.ground_height;
    }

    /// The rope has no surface: its row stays zero, so whatever the coefficient it has no friction.
    fn tangential(&self, _q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[3 * GROUND + 1] = 1.0;
    }

    fn interface(&self, _q: &[f64], v: &[f64], rows: &mut Rows) {
        let (length, lever, lever_rate) = self.crane.actuator();
        rows.jacobian[0] = lever;
        rows.position[0] = length;
        rows.convective[0] = lever_rate * v[0] * v[0];
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        let g = &self.geometry;
        let lifted = 0.5 * g.rod_mass + g.joint_mass;
        g.gravity * (-lifted * self.tip_rate.x + g.end_mass * q[2])
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(&["theta_1_rad", "load_x_m", "load_y_m"], &["rope", "ground"])
    }
}
