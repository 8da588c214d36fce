//! A force that follows the velocity directly within a micro step, such as that of viscous friction.

use crate::error::{Cause, Failure};
use rimbench_contact::affine_step::{DiscretisedColumns, DiscretisedModel};
use rimbench_contact::linear_algebra::Lu;

/// How the force of the actuator follows the motion of the model within a micro step of length δ, by the trapezoidal
/// rule.
///
/// ```text
/// λ = λ_m + D_s (s̄ − s₀) + D_w (w̄ − w₀)          w̄ = ½ (w + w⁺),  s̄ = s + ½δ w̄
///   = λ₀ + E (w⁺ − w)                              E = ½ D_w + ¼δ D_s
/// ```
/// λ_m is the force in the middle of the micro step with the inputs `s₀, w₀`.
/// # Shapes and units
/// `D = [D_s D_w]` n_i×2n_i (N/m, N·s/m); `E` and `K` n_i×n_i (N·s/m).
#[derive(Debug, Clone)]
pub(super) struct ImplicitFeedthrough {
    interface: usize,
    feedthrough: Vec<f64>,
    length: f64,
    e: Vec<f64>,
    k: Vec<f64>,
    /// `1 + K δ H_ii`.
    mixing: Vec<f64>,
    matrix: Vec<f64>,
    lu: Lu,
    /// One vector.
    room: Vec<f64>,
    /// The force with which a micro step starts.
    pub(super) start_force: Vec<f64>,
}

impl ImplicitFeedthrough {
    /// Makes room for `interface` rows.
    pub(super) fn new(interface: usize) -> Self {
        let square = vec![0.0; interface * interface];
        ImplicitFeedthrough {
            interface,
            feedthrough: vec![0.0; 2 * interface * interface],
            length: f64::NAN,
            e: square.clone(),
            k: square.clone(),
            mixing: square.clone(),
            matrix: square,
            lu: Lu::new(interface),
            room: vec![0.0; interface],
            start_force: vec![0.0; interface],
        }
    }

    /// Tells whether there is a feedthrough: whether micro steps are of the second order.
    #[inline]
    pub(super) fn is_on(&self) -> bool {
        !self.length.is_nan()
    }

    /// Takes note of `D` for micro steps of `length` (s); says whether that is anything new.
    pub(super) fn set(&mut self, feedthrough: &[f64], length: f64) -> bool {
        if self.length == length && self.feedthrough == feedthrough {
            return false;
        }
        let n = self.interface;
        self.feedthrough.copy_from_slice(feedthrough);
        self.length = length;
        for (row, e) in self.e.chunks_exact_mut(n).enumerate() {
            let (by_position, by_velocity) = feedthrough[2 * n * row..2 * n * (row + 1)].split_at(n);
            for (e, (s, w)) in e.iter_mut().zip(by_position.iter().zip(by_velocity)) {
                *e = 0.5 * w + 0.25 * length * s;
            }
        }
        true
    }

    /// Turns λ_m, taken with the inputs `told`, into λ₀ of a model at `position` and velocity `w`.
    pub(super) fn force_at_start(&self, told: &[f64], position: &[f64], w: &[f64], force: &mut [f64]) {
        let n = self.interface;
        let (told_position, told_velocity) = told.split_at(n);
        for (force, d) in force.iter_mut().zip(self.feedthrough.chunks_exact(2 * n)) {
            for i in 0..n {
                let reached = position[i] + 0.5 * self.length * w[i];
                *force += d[i] * (reached - told_position[i]) + d[n + i] * (w[i] - told_velocity[i]);
            }
        }
    }

    /// Eliminates the part of the force that depends on the velocity within the micro step from the model, whose force
    /// then is λ₀.
    ///
    /// ```text
    /// λ = λ₀ + E (w_i⁺ − w_i)        K = E (1 − δ H_ii E)⁻¹
    /// δ a += δ H_·i K δ a_i          δ H_·i += δ H_·i K δ H_ii          H_·u += δ H_·i K H_iu
    /// ```
    /// # Errors
    /// [`Cause::Singular`] if force and velocity do not determine each other.
    pub(super) fn eliminate_from(&mut self, model: &mut DiscretisedModel) -> Result<(), Failure> {
        let (n, n_i) = (model.contacts(), self.interface);
        let rows = n + n_i;
        let DiscretisedColumns { free_increment, force_columns, impulse_columns, h_uu } = model.columns_mut();
        let force_columns = &mut force_columns[..rows * n_i];
        self.eliminate(|row, column| force_columns[column * rows + n + row])?;
        let mut room = std::mem::take(&mut self.room);
        let mut respond = |target: &mut [f64]| {
            room.copy_from_slice(&target[n..]);
            for (force, column) in force_columns.chunks_exact(rows).enumerate() {
                let response = self.response(force, &room);
                target.iter_mut().zip(column).for_each(|(target, x)| *target += response * x);
            }
        };
        respond(&mut free_increment[..rows]);
        for (slot, column) in impulse_columns.chunks_exact_mut(rows.max(1)).take(n).enumerate() {
            respond(column);
            for row in 0..n {
                h_uu[row * n + slot] = column[row];
            }
        }
        self.room = room;
        // Rows of δ H_·i, all columns at once: each column is needed as it was.
        self.mix(rows, force_columns);
        Ok(())
    }

    /// Finds `K = E (1 − δ H_ii E)⁻¹`, given the entries of `δ H_ii`.
    fn eliminate(&mut self, h_ii: impl Fn(usize, usize) -> f64) -> Result<(), Failure> {
        let n = self.interface;
        self.k.copy_from_slice(&self.e);
        // Row r of K: K_r (1 − δ H_ii E) = E_r, transposed.
        for row in self.k.chunks_exact_mut(n) {
            for i in 0..n {
                for j in 0..n {
                    let product: f64 = (0..n).map(|l| h_ii(j, l) * self.e[l * n + i]).sum();
                    self.matrix[i * n + j] = f64::from(u8::from(i == j)) - product;
                }
            }
            if !self.lu.solve(&mut self.matrix, row) {
                return Err(Cause::Singular { matrix: "1 − δ H_ii E" }.into());
            }
        }
        for i in 0..n {
            for j in 0..n {
                let product: f64 = (0..n).map(|l| self.k[i * n + l] * h_ii(l, j)).sum();
                self.mixing[i * n + j] = f64::from(u8::from(i == j)) + product;
            }
        }
        Ok(())
    }

    /// One row of `K` times the interface part of a change of velocity, N.
    fn response(&self, force: usize, change: &[f64]) -> f64 {
        self.k[force * self.interface..].iter().zip(change).map(|(k, change)| k * change).sum()
    }

    /// Multiplies `δ H_·i`, columns of `rows` entries, by `1 + K δ H_ii` from the right.
    fn mix(&mut self, rows: usize, columns: &mut [f64]) {
        let n = self.interface;
        for row in 0..rows {
            for (j, room) in self.matrix[..n].iter_mut().enumerate() {
                *room = (0..n).map(|l| columns[l * rows + row] * self.mixing[l * n + j]).sum();
            }
            for j in 0..n {
                columns[j * rows + row] = self.matrix[j];
            }
        }
    }
}
