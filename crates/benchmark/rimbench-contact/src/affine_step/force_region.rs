//! The forces for which a step from one state keeps its active set, and the answer to them.

use super::discretised_model::DiscretisedModel;
use super::{ActiveSetFactor, AffineStep, StepContactLaw};

/// The critical region of a step from one state in the space of the interface's forces, and the velocities of the
/// interface after it.
///
/// ```text
/// region: A λ + b ≥ 0        of one force: from ≤ λ ≤ to        w_i⁺ = w_0 + W λ
/// ```
#[derive(Debug, Clone)]
pub struct ForceRegion {
    /// Of one force, N.
    range: [f64; 2],
    /// Of several: rows `[b A]`, and whether there is any force.
    rows: Vec<f64>,
    known: bool,
    /// Rows `[w_0 W]`.
    answer: Vec<f64>,
    interface: usize,
}

impl ForceRegion {
    const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

    /// Makes room for `contact_rows` contact rows and `interface` interface rows; it has no force yet.
    pub fn new(contact_rows: usize, interface: usize) -> Self {
        let columns = interface + 1;
        // An open contact has one condition, one that sticks four, one that slides three; and one more says that zero
        // is no solution.
        let rows = if interface > 1 { (3 * contact_rows + 2) * columns } else { 0 };
        let (rows, answer) = (Vec::with_capacity(rows), vec![0.0; interface * columns]);
        ForceRegion { range: Self::NONE, rows, known: false, answer, interface }
    }

    /// Leaves no force in it.
    pub fn clear(&mut self) {
        (self.range, self.known) = (Self::NONE, false);
        self.rows.clear();
    }

    /// Tells whether forces are in it; what is not a number never is.
    #[inline(always)]
    pub fn contains(&self, forces: &[f64]) -> bool {
        if let &[force] = forces {
            return self.range[0] <= force && force <= self.range[1];
        }
        self.known && self.rows.chunks_exact(forces.len() + 1).all(|row| value(row, forces) >= 0.0)
    }

    /// Returns the velocity of interface row `i` after a step under `forces` that are in it, m/s.
    #[inline(always)]
    pub fn velocity(&self, i: usize, forces: &[f64]) -> f64 {
        let columns = forces.len() + 1;
        value(&self.answer[i * columns..(i + 1) * columns], forces)
    }

    /// Keeps the forces for which a row, `b` in column 0 and then `A`, is not below zero.
    pub(super) fn keep(&mut self, row: impl Fn(usize) -> f64) {
        if self.interface > 1 {
            let always = row(0) >= 0.0 && (1..=self.interface).all(|column| row(column) == 0.0);
            self.rows.extend((0..=self.interface).filter(|_| !always).map(row));
            return;
        }
        let (constant, slope) = (row(0), row(1));
        if slope > 0.0 {
            self.range[0] = self.range[0].max(-constant / slope);
        } else if slope < 0.0 {
            self.range[1] = self.range[1].min(-constant / slope);
        } else if constant < 0.0 {
            self.range = Self::NONE;
        }
    }
}

/// The value of a row `[b A]` at some forces.
#[inline(always)]
fn value(row: &[f64], forces: &[f64]) -> f64 {
    row[1..].iter().zip(forces).fold(row[0], |sum, (slope, force)| sum + slope * force)
}

impl<F: ActiveSetFactor> AffineStep<F> {
    /// Finds the region around the forces of the last step, which kept its active set from `w` and `gap` under a law
    /// that leaves gaps as they are.
    pub fn find_force_region(
        &self,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        (w, gap): (&[f64], &[f64]),
        forces: &[f64],
        region: &mut ForceRegion,
    ) {
        let n = self.rows;
        let (gap, rounding) = (&gap[..n / F::ROWS], self.tolerance(self.sigma, forces));
        let accepted = self.accepted(rounding);
        region.clear();
        (region.range, region.known) = ([f64::NEG_INFINITY, f64::INFINITY], true);
        for (contact, gap) in gap.iter().enumerate() {
            // Active rows rest at their gap terms whatever the forces.
            let term = law.rates.velocity(*gap) + accepted;
            region.keep(|column| self.velocity(w, contact, column) + if column == 0 { term } else { 0.0 });
        }
        F::keep_admissible(self, w, rounding, region);
        if F::ROWS == 2 && !self.active.is_empty() {
            // Zero impulses are no solution as long as this contact would close without any.
            let free = |contact: usize, column: usize| match column.checked_sub(1) {
                None => w[contact] + model.free_increment(n)[contact] + law.rates.velocity(gap[contact]),
                Some(force) => model.force_column(force, n + forces.len())[contact],
            };
            let at = |contact: usize| {
                forces.iter().enumerate().fold(free(contact, 0), |sum, (j, force)| sum + force * free(contact, j + 1))
            };
            if let Some(contact) = (0..gap.len()).min_by(|one, other| at(*one).total_cmp(&at(*other))) {
                region.keep(|column| -free(contact, column));
            }
        }
        let columns = forces.len() + 1;
        for (at, answer) in region.answer.iter_mut().enumerate() {
            *answer = self.velocity(w, n + at / columns, at % columns);
        }
    }

    /// The velocity of a row after the step: without forces, and per force.
    pub(super) fn velocity(&self, w: &[f64], row: usize, column: usize) -> f64 {
        let (rows, v) = (self.rows + self.interface, &self.velocities);
        if column == 0 { w[row] + v[row] + self.sigma * v[rows + row] } else { v[(column + 1) * rows + row] }
    }

    /// The impulse of the active row in this place likewise.
    pub(super) fn impulse(&self, slot: usize, column: usize) -> f64 {
        let (n, p) = (self.rows, &self.impulses);
        if column == 0 { p[slot] + self.sigma * p[n + slot] } else { p[(column + 1) * n + slot] }
    }

    /// Writes the velocities after a step from `w` under `lambda` (N) with the active set of the last tangents,
    /// wherever it is valid.
    pub fn velocities_with_set(&self, w: &[f64], lambda: &[f64], w_plus: &mut [f64]) {
        let rows = self.rows + lambda.len();
        self.velocities_after(&w[..rows], lambda, &mut w_plus[..rows]);
    }
}
