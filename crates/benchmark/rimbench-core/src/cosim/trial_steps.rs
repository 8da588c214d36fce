//! Steps that are tried on copies of the mechanics.

use super::communication_grid::{MacroStep, MicroStep};
use super::subsystem::{Subsystem, SubsystemCounters};
use super::trials::{TrialSettings, Trials};
use crate::error::Failure;

/// Room for trials, and their work.
#[derive(Debug, Clone, Default)]
pub(crate) struct TrialRoom {
    pub(crate) work: SubsystemCounters,
    taken: usize,
}

/// The mechanics as it stands at the communication point, for steps that are tried on copies of it.
pub(crate) struct TrialSteps<'a> {
    mechanics: &'a dyn Subsystem,
    step: MacroStep,
    own_steps: usize,
    semi_implicit: bool,
    room: &'a mut TrialRoom,
    settings: TrialSettings,
}

impl<'a> TrialSteps<'a> {
    /// Lends a mechanics that has not begun `step`, which it will take in so many steps of its own.
    pub(crate) fn new(
        mechanics: &'a mut dyn Subsystem,
        (step, own_steps): (MacroStep, usize),
        room: &'a mut TrialRoom,
        settings: TrialSettings,
    ) -> Self {
        room.taken = 0;
        let semi_implicit = mechanics.capabilities().contact_mechanics().is_some();
        TrialSteps { mechanics, step, own_steps, semi_implicit, room, settings }
    }
}

impl Trials for TrialSteps<'_> {
    fn length(&self) -> f64 {
        self.step.length
    }

    fn settings(&self) -> TrialSettings {
        self.settings
    }

    fn taken(&self) -> usize {
        self.room.taken
    }

    fn is_semi_implicit(&self) -> bool {
        self.semi_implicit
    }

    fn end_under(&mut self, force: &[f64], end: &mut [f64]) -> Result<(), Failure> {
        let TrialRoom { work, taken } = &mut *self.room;
        let before = self.mechanics.counters();
        let mut copy = self.mechanics.try_clone()?;
        *taken += 1;
        let mut cover = || {
            for index in 0..self.own_steps {
                let at = MicroStep::new(self.step, index, self.own_steps);
                copy.step(at.start, force, at.length)?;
            }
            copy.outputs(force, end)
        };
        let covered = cover();
        work.add(&copy.counters().since(&before));
        covered.map_err(|failure| {
            Failure::reported(format!(
                "a trial step of the mechanics from {} s under {force:?} N failed: {failure}",
                self.step.start
            ))
        })
    }
}
