//! Equations among rows of a model of which some may depend on others.

use super::reduced_interface_model::ReducedInterfaceModel;
use rimbench_contact::linear_algebra::Factor;

/// Below this fraction of the largest diagonal entry a pivot counts as zero.
const DEPENDENT: f64 = 1e-10;

/// Solves `H_AA x = b` for rows A of a model that keeps every entry of `H`.
#[derive(Debug, Clone)]
pub struct IndependentRows {
    factor: Factor,
    kept: Vec<usize>,
    x: Vec<f64>,
}

impl IndependentRows {
    /// Reserves `rows` rows of models like `empty`.
    pub fn new(rows: usize, empty: &ReducedInterfaceModel) -> Self {
        let stride = if rows == 0 { 0 } else { empty.a.len() };
        IndependentRows { factor: Factor::new(stride), kept: Vec::with_capacity(rows), x: Vec::with_capacity(rows) }
    }

    /// Returns the independent ones of `rows` with their `x`; a row that depends on those before it has no part in the
    /// answer.
    pub fn solve(
        &mut self,
        model: &ReducedInterfaceModel,
        rows: &[usize],
        b: impl Fn(usize) -> f64,
    ) -> (&[usize], &[f64]) {
        let IndependentRows { factor, kept, x } = self;
        factor.clear(model.a.len());
        kept.clear();
        let largest = rows.iter().map(|&row| model.entry(row, row)).fold(0.0, f64::max);
        for &row in rows {
            let pivot = factor.border(&model.h, kept, row);
            if pivot > DEPENDENT * largest {
                factor.push(pivot);
                kept.push(row);
            }
        }
        x.clear();
        x.extend(kept.iter().map(|&row| b(row)));
        factor.solve(x);
        (kept, x)
    }
}
