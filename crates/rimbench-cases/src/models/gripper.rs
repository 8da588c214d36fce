//! Mechanics of a gripper: two jaws on a rail close on a box that stands on the floor.

use super::rotation::rotation;
use nalgebra::{Rotation2, Vector2};
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::{MassMatrix, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelSize};
use rimbench_core::name::{Name, names};

/// Masses, geometry and start of a [`Gripper`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GripperGeometry {
    /// Of each jaw, kg.
    pub jaw_mass: f64,
    /// kg.
    pub box_mass: f64,
    /// Width and height of the box, m.
    pub box_size: [f64; 2],
    /// Heights of the lower and the upper pad of both jaws, m.
    pub pad_heights: [f64; 2],
    /// Distance of left and right jaw from the box at the start, m.
    pub clearances: [f64; 2],
    /// Length of both actuators at the start, m.
    pub actuator_length: f64,
    /// m/s².
    pub gravity: f64,
}

/// Jaws and box. Coordinates: x of the pads of left and right jaw, box `(x, y, φ)`.
///
/// ```text
/// pad p on a face with outward normal n(φ):   g = (p − c)·n − b/2
/// A = [n_x (jaw), −n_x, −n_y, (p − c)·n_⊥]     Ȧv = 2φ̇ (ṗ − ċ)·n_⊥ − φ̇² (p − c)·n
/// s₁ = x_left − anchor                          s₂ = anchor − x_right
/// ```
/// Four pad contacts and two corners on the floor hold a box with three freedoms between two jaws: six rows of rank four, and the
/// jaws can only move together.
/// # Source
/// Ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Gripper {
    geometry: GripperGeometry,
    mass: [f64; 5],
    /// x of the actuators' fixed ends.
    anchors: [f64; 2],
    rotation: Rotation2<f64>,
}

const VELOCITIES: usize = 5;
const BOX: usize = 2;

impl Gripper {
    /// Places the box at x = 0 between the jaws, its lower side at y = 0.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if a jaw would start inside the box or a pad beside its faces.
    pub fn new(geometry: GripperGeometry) -> Result<Self> {
        let g = &geometry;
        let [width, height] = g.box_size;
        for (side, clearance) in ["left", "right"].into_iter().zip(g.clearances) {
            if clearance < 0.0 {
                return Err(Error::Incompatible(format!(
                    "impossible geometry: the {side} jaw would start {clearance:.6} m from the box, inside it"
                )));
            }
        }
        if let Some(pad) = g.pad_heights.iter().find(|pad| !(0.0..=height).contains(*pad)) {
            return Err(Error::Incompatible(format!(
                "impossible geometry: a pad at {pad} m is beside the box, which reaches from 0 to {height} m"
            )));
        }
        let inertia = g.box_mass * (width * width + height * height) / 12.0;
        let (left, right) = Self::start_of_jaws(g);
        Ok(Gripper {
            mass: [g.jaw_mass, g.jaw_mass, g.box_mass, g.box_mass, inertia],
            anchors: [left - g.actuator_length, right + g.actuator_length],
            rotation: Rotation2::identity(),
            geometry,
        })
    }

    /// Outward normal of the face that a pad presses.
    fn outward(&self, pad: usize) -> Vector2<f64> {
        self.rotation * Vector2::new(if pad < 2 { -1.0 } else { 1.0 }, 0.0)
    }

    fn start_of_jaws(g: &GripperGeometry) -> (f64, f64) {
        let half = 0.5 * g.box_size[0];
        (-half - g.clearances[0], half + g.clearances[1])
    }
}

impl MechanicalModel for Gripper {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: VELOCITIES, bilateral: 0, unilateral: 6, interface: 2 }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        let (left, right) = Self::start_of_jaws(&self.geometry);
        (vec![left, right, 0.0, 0.5 * self.geometry.box_size[1], 0.0], vec![0.0; VELOCITIES])
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        self.rotation = rotation(q[4]);
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut MassMatrix) {
        if let MassMatrix::Diagonal(diagonal) = mass {
            diagonal.copy_from_slice(&self.mass);
        }
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&[0.0, 0.0, 0.0, -self.geometry.box_mass * self.geometry.gravity, 0.0]);
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let [width, height] = self.geometry.box_size;
        let spin = v[4];
        for row in 0..4 {
            let (jaw, pad) = (row / 2, row % 2);
            let normal = self.outward(row);
            let across = Vector2::new(-normal.y, normal.x);
            let arm = Vector2::new(q[jaw], self.geometry.pad_heights[pad]) - Vector2::new(q[2], q[3]);
            let rate: Vector2<f64> = Vector2::new(v[jaw], 0.0) - Vector2::new(v[2], v[3]);
            let at = VELOCITIES * row;
            rows.jacobian[at + jaw] = normal.x;
            rows.jacobian[at + BOX..at + VELOCITIES].copy_from_slice(&[-normal.x, -normal.y, arm.dot(&across)]);
            rows.position[row] = arm.dot(&normal) - 0.5 * width;
            rows.convective[row] = 2.0 * spin * rate.dot(&across) - spin * spin * arm.dot(&normal);
        }
        for (row, side) in [(4, -0.5), (5, 0.5)] {
            let arm = self.rotation * Vector2::new(side * width, -0.5 * height);
            rows.set_planar_body(row, BOX, Vector2::new(0.0, 1.0), arm);
            rows.position[row] = q[3] + arm.y;
            rows.convective[row] = -spin * spin * arm.y;
        }
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[0] = 1.0;
        rows.position[0] = q[0] - self.anchors[0];
        rows.jacobian[VELOCITIES + 1] = -1.0;
        rows.position[1] = self.anchors[1] - q[1];
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.geometry.gravity * self.geometry.box_mass * q[3]
    }

    fn observables(&self) -> Vec<Name> {
        names(&["left_jaw_x_m", "right_jaw_x_m", "box_x_m", "box_y_m", "box_angle_rad"])
    }

    fn contact_names(&self) -> Vec<Name> {
        names(&[
            "left_lower_pad",
            "left_upper_pad",
            "right_lower_pad",
            "right_upper_pad",
            "left_corner",
            "right_corner",
        ])
    }

    fn observe(&self, q: &[f64], _v: &[f64], row: &mut [f64]) {
        row.copy_from_slice(q);
    }
}
