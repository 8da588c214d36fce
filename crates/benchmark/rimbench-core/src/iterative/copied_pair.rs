//! A run that owns its sides and its scheme, so that it can be copied.

use crate::cosim::{CoupledPair, CouplingScheme, PairState, PerSide, Setup, Side, StopFlag, Subsystem, Work};
use crate::error::{Cause, Failure};

/// Sides, scheme and state of a run, in its own hands.
pub(super) struct CopiedPair<'a> {
    pub(super) setup: &'a Setup,
    sides: PerSide<Box<dyn Subsystem>>,
    scheme: Box<dyn CouplingScheme>,
    pub(super) state: PairState,
    stop: StopFlag<'a>,
    /// Largest magnitude of each output so far, where it is recorded.
    pub(super) sizes: PerSide<Vec<f64>>,
    /// Work on copies that were thrown away.
    discarded: Work,
}

impl<'a> CopiedPair<'a> {
    /// Copies what a run is to begin with.
    ///
    /// # Errors
    /// [`Cause::NotCopied`] if a side or the scheme has no copy to give.
    pub(super) fn of(pair: &CoupledPair<'a>) -> Result<Self, Failure> {
        let least = |side: Side| {
            let outputs = &pair.sides[side].ports().outputs;
            outputs.iter().map(|port| port.quantity.negligible()).collect()
        };
        Ok(CopiedPair {
            setup: pair.setup,
            sizes: PerSide::from_fn(least),
            sides: PerSide { mechanics: pair.sides.mechanics.try_clone()?, actuator: pair.sides.actuator.try_clone()? },
            scheme: pair.scheme.try_clone().ok_or(Cause::NotCopied)?,
            state: pair.state.clone(),
            stop: pair.stop,
            discarded: Work::default(),
        })
    }

    /// Returns a copy in the present state, for steps that may be taken back.
    ///
    /// # Errors
    /// [`Cause::NotCopied`].
    pub(super) fn try_clone(&self) -> Result<Self, Failure> {
        Ok(CopiedPair {
            setup: self.setup,
            sides: PerSide { mechanics: self.sides.mechanics.try_clone()?, actuator: self.sides.actuator.try_clone()? },
            scheme: self.scheme.try_clone().ok_or(Cause::NotCopied)?,
            state: self.state.clone(),
            stop: self.stop,
            sizes: self.sizes.clone(),
            discarded: self.discarded,
        })
    }

    /// Lends the pair as the loop knows it.
    pub(super) fn lend(&mut self) -> CoupledPair<'_> {
        CoupledPair {
            setup: self.setup,
            sides: self.sides.lend(),
            scheme: &mut *self.scheme,
            state: &mut self.state,
            stop: self.stop,
        }
    }

    /// Returns all work so far, that on copies thrown away included.
    pub(super) fn work(&mut self) -> Work {
        let mut work = self.lend().work();
        work.add(&self.discarded);
        work
    }

    /// Books work that led nowhere.
    pub(super) fn book_discarded(&mut self, work: Work) {
        self.discarded.add(&work.discarded());
    }

    /// Takes note of how large the coupling variables get.
    pub(super) fn record_sizes(&mut self) {
        for side in Side::BOTH {
            let outputs = &self.state.y[side];
            self.sizes[side].iter_mut().zip(outputs).for_each(|(size, y)| *size = size.max(y.abs()));
        }
    }
}
