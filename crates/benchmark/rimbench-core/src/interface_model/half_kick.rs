//! The half-kick: what of the free accelerations depends on the state acts at once, as a change of velocity.

use super::independent_rows::IndependentRows;
use super::reduced_interface_model::ReducedInterfaceModel;

/// Room to kick models.
#[derive(Debug, Clone)]
pub(crate) struct HalfKick {
    closed: Vec<usize>,
    rows: IndependentRows,
}

impl HalfKick {
    /// Reserves models like `empty`.
    pub(crate) fn new(empty: &ReducedInterfaceModel) -> Self {
        let n = if empty.state_bias.is_empty() { 0 } else { empty.contacts() };
        HalfKick { closed: Vec::with_capacity(n), rows: IndependentRows::new(n, empty) }
    }

    /// Kicks a model without friction over a macro step of `length` (s), along its closed contacts; what they balance
    /// stays in `a`.
    ///
    /// ```text
    /// a_t = a_s − H_·c H_cc⁺ a_s,c        w ← w + ½ H a_t        a ← a − a_t
    /// ```
    pub(crate) fn apply(&mut self, model: &mut ReducedInterfaceModel, length: f64) {
        model.closed_contacts(&mut self.closed);
        let (kept, impulses) = self.rows.solve(model, &self.closed, |row| model.state_bias[row]);
        for row in 0..model.a.len() {
            let balanced: f64 = kept.iter().zip(impulses).map(|(&contact, p)| model.entry(row, contact) * p).sum();
            let along = model.state_bias[row] - balanced;
            model.w[row] += 0.5 * length * along;
            model.a[row] -= along;
        }
    }
}
