//! When the next contact closes, as the model foresees it.

use super::ReducedInterface;
use super::gap_law::GapTerm;
use crate::interface_model::TOUCHING;

impl ReducedInterface {
    /// Returns the time τ until the first of the open contacts closes, its acceleration being that of the last micro
    /// step, s.
    ///
    /// ```text
    /// g + w τ + ½ a τ² = 0        τ = 2g / (√(w² − 2 a g) − w)
    /// ```
    /// Where a contact was hit in that step the difference of velocities is no acceleration, and `a = 0`. A contact
    /// that touches without an impulse is not open. Tangential rows come after those of the contacts, and have no gap.
    pub(super) fn next_closing(&self) -> Option<f64> {
        let tracked = (self.gap_term == GapTerm::Tracked).then_some(self.set.contacts().len())?;
        let (delta, state) = (self.discretised.length(), &self.state);
        let behind = self.own.as_ref().map_or(0.0, |own| own.gaps_behind());
        let gap = |slot: usize| state.gap[slot] + behind * state.w_plus[slot];
        // A contact that closes comes to rest in two steps: in the first it uses up its gap, in the second it stops.
        let approached = |slot: usize| (gap(slot) - delta * state.w_plus[slot]).max(-delta * state.w[slot]);
        let hit = (0..tracked).any(|slot| state.impulses[slot] > 0.0 && approached(slot) > TOUCHING);
        let open = (0..tracked).filter(|&slot| gap(slot) > TOUCHING && state.impulses[slot] <= 0.0);
        let closing = open.filter_map(|slot| {
            let (gap, w) = (gap(slot), state.w_plus[slot]);
            let a = if hit { 0.0 } else { (w - state.w[slot]) / delta };
            let speed = (w * w - 2.0 * a * gap).sqrt() - w;
            (speed > 0.0).then(|| 2.0 * gap / speed)
        });
        closing.reduce(f64::min)
    }
}
