//! The half-kick: what of the free accelerations depends on the state acts at once, as a change of velocity.

use super::reduced_interface_model::ReducedInterfaceModel;

/// Below this fraction of the largest diagonal entry a pivot counts as zero.
const DEPENDENT: f64 = 1e-10;

/// Room to kick models.
#[derive(Debug, Clone)]
pub(crate) struct HalfKick {
    closed: Vec<usize>,
    matrix: Vec<f64>,
    impulses: Vec<f64>,
}

impl HalfKick {
    /// Reserves models like `empty`.
    pub(crate) fn new(empty: &ReducedInterfaceModel) -> Self {
        let n = if empty.state_bias.is_empty() { 0 } else { empty.contacts() };
        HalfKick { closed: Vec::with_capacity(n), matrix: vec![0.0; n * n], impulses: vec![0.0; n] }
    }

    /// Kicks a model without friction over a macro step of `length` (s), along its closed contacts; what they balance stays in `a`.
    ///
    /// ```text
    /// a_t = a_s − H_·c H_cc⁺ a_s,c        w ← w + ½ H a_t        a ← a − a_t
    /// ```
    pub(crate) fn apply(&mut self, model: &mut ReducedInterfaceModel, length: f64) {
        model.closed_contacts(&mut self.closed);
        let n = self.closed.len();
        for (k, &row) in self.closed.iter().enumerate() {
            self.impulses[k] = model.state_bias[row];
            for (l, &column) in self.closed.iter().enumerate() {
                self.matrix[k * n + l] = model.entry(row, column);
            }
        }
        solve_semidefinite(&mut self.matrix[..n * n], &mut self.impulses[..n]);
        for row in 0..model.a.len() {
            let balanced: f64 =
                self.closed.iter().zip(&self.impulses).map(|(&contact, p)| model.entry(row, contact) * p).sum();
            let along = model.state_bias[row] - balanced;
            model.w[row] += 0.5 * length * along;
            model.a[row] -= along;
        }
    }
}

/// Solves `A x = b` in place for a positive semidefinite row-major `A`, which is destroyed; of dependent rows one answer.
pub(crate) fn solve_semidefinite(a: &mut [f64], b: &mut [f64]) {
    let n = b.len();
    let largest = (0..n).map(|i| a[i * n + i]).fold(0.0, f64::max);
    // Elimination down to what is left of each row; a row that depends on those before has no part in the answer.
    for k in 0..n {
        if a[k * n + k] <= DEPENDENT * largest {
            (0..n).for_each(|j| (a[k * n + j], a[j * n + k]) = (0.0, 0.0));
            b[k] = 0.0;
            continue;
        }
        for i in k + 1..n {
            let factor = a[i * n + k] / a[k * n + k];
            (k..n).for_each(|j| a[i * n + j] -= factor * a[k * n + j]);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let rest: f64 = (k + 1..n).map(|j| a[k * n + j] * b[j]).sum();
        b[k] = if a[k * n + k] > 0.0 { (b[k] - rest) / a[k * n + k] } else { 0.0 };
    }
}
