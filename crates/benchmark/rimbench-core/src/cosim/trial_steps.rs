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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::{Capabilities, Ports, subsystem_methods};

    /// A body of 2 kg from outside, whose steps are exact.
    #[derive(Clone)]
    struct Body {
        ports: Ports,
        counters: SubsystemCounters,
        motion: [f64; 2],
    }

    impl Subsystem for Body {
        subsystem_methods!(ports capabilities counters clone);

        fn outputs(&mut self, _: &[f64], y: &mut [f64]) -> Result<(), Failure> {
            y.copy_from_slice(&self.motion);
            Ok(())
        }

        fn step(&mut self, _: f64, u: &[f64], h: f64) -> Result<(), Failure> {
            let ([s, w], a) = (self.motion, u[0] / 2.0);
            self.motion = [s + h * (w + 0.5 * h * a), w + h * a];
            self.counters.micro_steps += 1;
            Ok(())
        }
    }

    impl Capabilities for Body {}

    #[test]
    fn a_trial_leaves_the_mechanics_where_it_is_and_one_from_outside_is_not_said_to_move_by_its_last_velocity() {
        let ports = Ports { inputs: Vec::new(), outputs: Vec::new(), direct_feedthrough: false };
        let mut body = Body { ports, counters: SubsystemCounters::default(), motion: [0.5, 1.0] };
        let (mut room, step) = (TrialRoom::default(), MacroStep { index: 0, start: 0.0, length: 0.5 });
        let mut trials = TrialSteps::new(&mut body, (step, 4), &mut room, TrialSettings::default());
        let mut end = [0.0; 2];
        trials.end_under(&[8.0], &mut end).unwrap();
        assert_eq!((end, trials.taken(), trials.is_semi_implicit()), ([1.5, 3.0], 1, false));
        assert_eq!((body.motion, body.counters.micro_steps, room.work.micro_steps), ([0.5, 1.0], 0, 4));
    }
}
