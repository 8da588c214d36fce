//! Rows of an engine over several of its steps: each takes its target anew from where the row has come to. One that is
//! away from what it touches by then pushes no more, as the engine has no such row; one that it gets is not foreseen.

use crate::interface_model::{ReducedInterfaceModel, RowTarget};

/// How many times faster than any row one would have to be to push while it is away.
const AWAY: f64 = 1e3;

/// The targets of the model's rows in the present step of the engine; nothing while it takes one step only.
///
/// The model that was received has those of its first step in `a_u`. In later ones a row must go `b w + k g` of then
/// beyond where it is, and `more` is the difference.
#[derive(Clone, Default)]
pub(super) struct Targets {
    on: bool,
    rows: Vec<RowTarget>,
    /// What was asked for first, m/s²; and what is of a row that is away, on top.
    first: Vec<f64>,
    away: f64,
    /// Impulses of the present step so far, N·s, and how long it lasts by now, s.
    pushed: Vec<f64>,
    elapsed: f64,
}

impl Targets {
    /// Starts from a model that has arrived, whose engine takes so many `steps` in the macro step.
    pub(super) fn start(&mut self, model: &ReducedInterfaceModel, steps: usize) {
        self.on = model.has_targets && steps > 1;
        if self.on {
            self.rows.clone_from(&model.targets);
            self.first.clear();
            self.first.extend(self.rows.iter().map(RowTarget::asked));
            self.away = 0.0;
            self.clear();
        }
    }

    fn clear(&mut self) {
        self.elapsed = 0.0;
        self.pushed.clear();
        self.pushed.resize(self.rows.len(), 0.0);
    }

    /// Tells whether there is anything to go on with.
    #[inline(always)]
    pub(super) fn is_on(&self) -> bool {
        self.on
    }

    /// Adds to the velocities of rows what they are to go beyond the first step's target in `time` (s).
    pub(super) fn add_more(&self, time: f64, w: &mut [f64]) {
        let more = self.rows.iter().zip(&self.first).map(|(row, first)| asked(row, self.away) - first);
        w.iter_mut().zip(more).for_each(|(w, more)| *w += time * more);
    }

    /// Adds a `share` of impulses (N·s), those of a part of the engine's step that lasts `time` (s).
    pub(super) fn add_impulses(&mut self, time: f64, share: f64, impulses: &[f64]) {
        self.elapsed += time;
        self.pushed.iter_mut().zip(impulses).for_each(|(sum, impulse)| *sum += share * impulse);
    }

    /// Ends a step of the engine in which rows have come to move by `beyond` (m/s) beyond their targets; from then on
    /// they are at rest beyond new ones.
    pub(super) fn end_step(&mut self, beyond: &mut [f64]) {
        for ((row, beyond), pushed) in self.rows.iter_mut().zip(beyond).zip(&self.pushed) {
            // ŵ⁺ = w⁺ − w − h ẇ_ref + R P
            row.velocity += *beyond - self.elapsed * asked(row, self.away) - row.compliance * pushed;
            *beyond = 0.0;
        }
        let fastest = self.rows.iter().fold(0.0, |most: f64, row| most.max(row.velocity.abs()));
        self.away = if self.elapsed > 0.0 { AWAY * fastest / self.elapsed } else { self.away };
        for row in 0..self.rows.len() {
            let velocities = self.rows[row].velocity + self.rows[self.rows[row].opposite].velocity;
            self.rows[row].distance += 0.5 * self.elapsed * velocities;
        }
        self.clear();
    }
}

/// What a row is asked for beyond where it is, m/s².
fn asked(row: &RowTarget, away: f64) -> f64 {
    row.asked() + if row.distance > 0.0 { away } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mass of 2 kg that falls on a row, bounces off and falls again: by the law in position and velocity, and beyond
    /// targets.
    #[test]
    fn a_row_goes_beyond_its_targets_as_the_law_says() {
        const H: f64 = 2e-3;
        let (mobility, pull) = (0.5, -9.81);
        let first =
            RowTarget { velocity: -0.5, distance: -1e-3, damping: 20.0, stiffness: 5e4, compliance: 0.05, opposite: 0 };
        let mut model = ReducedInterfaceModel::zeros_with_targets(3, 1);
        model.set_contacts(1);
        (model.targets[0], model.a[0], model.h[0]) = (first, pull, mobility);
        model.go_beyond_targets();
        let mut targets = Targets::default();
        targets.start(&model, 20);
        let (mut w, mut gap, mut beyond, mut away) = (first.velocity, first.distance, [0.0], 0);
        for _ in 0..20 {
            // 0 ≤ w⁺ − (1 − h b) w + h k g + R P
            let free = H * pull + H * (first.damping * w + first.stiffness * gap);
            let impulse = if gap > 0.0 { 0.0 } else { (-free / (mobility + first.compliance)).max(0.0) };
            away += usize::from(gap > 0.0);
            w += H * pull + mobility * impulse;
            gap += H * w;
            targets.add_more(H, &mut beyond);
            let free = beyond[0] + H * model.a[0];
            let own = (-free / model.h[0]).max(0.0);
            assert!((own - impulse).abs() < 1e-12, "{own} {impulse}");
            beyond[0] = free + model.h[0] * own;
            targets.add_impulses(H, 1.0, &[own]);
            targets.end_step(&mut beyond);
            assert!((targets.rows[0].velocity - w).abs() < 1e-12 && (targets.rows[0].distance - gap).abs() < 1e-14);
        }
        assert!(away > 3 && away < 17, "it was away in {away} steps");
    }
}
