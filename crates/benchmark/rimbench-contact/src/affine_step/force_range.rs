//! The forces for which a step from one state keeps its active set.

use super::discretised_model::DiscretisedModel;
use super::{ActiveSetFactor, AffineStep, StepContactLaw};

/// A quantity that is linear in the force: its value without one, and its slope.
pub(super) type Line = [f64; 2];

/// The forces between two bounds, N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceRange {
    from: f64,
    to: f64,
}

impl ForceRange {
    /// No force.
    pub const NONE: ForceRange = ForceRange { from: f64::INFINITY, to: f64::NEG_INFINITY };
    const ALL: ForceRange = ForceRange { from: f64::NEG_INFINITY, to: f64::INFINITY };

    /// Tells whether a force is among them; one that is not a number never is.
    #[inline(always)]
    pub fn contains(&self, force: f64) -> bool {
        self.from <= force && force <= self.to
    }

    /// Keeps the forces for which a line is not below zero.
    pub(super) fn keep(&mut self, [constant, slope]: Line) {
        if slope > 0.0 {
            self.from = self.from.max(-constant / slope);
        } else if slope < 0.0 {
            self.to = self.to.min(-constant / slope);
        } else if constant < 0.0 {
            *self = Self::NONE;
        }
    }
}

impl<F: ActiveSetFactor> AffineStep<F> {
    /// Returns the forces around `force` (N) for which a step from `w` and `gap` keeps the active set of the last one, and the interface's
    /// velocity after it, without force and per force; for an interface of one row, under a law that leaves gaps as they are.
    pub fn force_range(
        &self,
        model: &DiscretisedModel,
        law: &StepContactLaw,
        w: &[f64],
        gap: &[f64],
        force: f64,
    ) -> (ForceRange, [f64; 2]) {
        let n = self.rows;
        let (gap, mut range) = (&gap[..n / F::ROWS], ForceRange::ALL);
        let [accepted, rounding] =
            [self.accepted(self.tolerance(self.sigma, &[force])), self.tolerance(self.sigma, &[force])];
        // Active rows rest at their gap terms.
        for (contact, gap) in gap.iter().enumerate() {
            let [constant, slope] = self.velocity(w, contact);
            range.keep([constant + law.rates.velocity(*gap) + accepted, slope]);
        }
        F::keep_admissible(self, w, rounding, &mut range);
        if F::ROWS == 2 && !self.active.is_empty() {
            // Where zero impulses are a solution as well.
            let mut zero = ForceRange::ALL;
            for (contact, gap) in gap.iter().enumerate() {
                let free = w[contact] + model.free_increment(n + 1)[contact] + law.rates.velocity(*gap);
                zero.keep([free, model.force_column(0, n + 1)[contact]]);
            }
            if zero.from <= zero.to {
                if force < zero.from {
                    range.to = range.to.min(zero.from)
                } else {
                    range.from = range.from.max(zero.to)
                }
            }
        }
        (range, self.velocity(w, n))
    }

    /// The velocity of a row after the step.
    pub(super) fn velocity(&self, w: &[f64], row: usize) -> Line {
        let rows = self.rows + 1;
        [w[row] + self.velocities[row] + self.sigma * self.velocities[rows + row], self.velocities[2 * rows + row]]
    }

    /// The impulses of the active rows, each behind its row.
    pub(super) fn impulse_lines(&self) -> impl Iterator<Item = (usize, Line)> {
        let (n, p) = (self.rows, &self.impulses);
        self.active
            .iter()
            .enumerate()
            .map(move |(slot, &row)| (row, [p[slot] + self.sigma * p[n + slot], p[2 * n + slot]]))
    }

    /// Writes the velocities after a step from `w` under `lambda` (N) with the active set of the last tangents, wherever it is valid.
    pub fn velocities_with_set(&self, w: &[f64], lambda: &[f64], w_plus: &mut [f64]) {
        let rows = self.rows + lambda.len();
        self.velocities_after(&w[..rows], lambda, &mut w_plus[..rows]);
    }
}
