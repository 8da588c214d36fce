//! Mechanics of a block on a rough floor, pulled along it.

use rimbench_core::interface_model::{MassMatrix, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelSize};
use rimbench_core::name::{Name, names};

/// A block that does not turn. Coordinates: its place x along the floor and the height y of its sole above it.
///
/// ```text
/// g = y     A_u = [0, 1]     A_t = [1, 0]     A_i = [1, 0]     s = x
/// ```
/// # Source
/// Ours; the block of every text on friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlidingBlock {
    /// kg.
    pub mass: f64,
    /// m/s².
    pub gravity: f64,
}

impl MechanicalModel for SlidingBlock {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: 2, bilateral: 0, unilateral: 1, interface: 1 }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![0.0; 2], vec![0.0; 2])
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut MassMatrix) {
        if let MassMatrix::Diagonal(diagonal) = mass {
            diagonal.fill(self.mass);
        }
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&[0.0, -self.mass * self.gravity]);
    }

    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[1] = 1.0;
        rows.position[0] = q[1];
    }

    fn tangential_rows(&self) -> usize {
        1
    }

    fn tangential(&self, _q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[0] = 1.0;
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[0] = 1.0;
        rows.position[0] = q[0];
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.mass * self.gravity * q[1]
    }

    fn contact_names(&self) -> Vec<Name> {
        names(&["floor"])
    }
}
