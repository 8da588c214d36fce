//! No coupling at all: both sides in one loop.

use crate::cosim::{CoupledPair, LentActuator, MacroInterval, MicroStep, PairState};
use crate::error::Failure;

impl CoupledPair<'_> {
    /// Lets both sides cover a macro step in one loop at the micro step, as
    /// [`monolithic`](crate::mechanics::monolithic) does it: the mechanics with the force of the state before, the
    /// actuator with the motion after; or piece by piece where the mechanics is of the second order.
    pub(super) fn advance_together(&mut self, MacroInterval { step, .. }: MacroInterval) -> Result<(), Failure> {
        let count = self.setup.actuator_steps(step);
        let PairState { received, work_sent, y, u, .. } = &mut *self.state;
        received.fill(0.0);
        for j in 0..count {
            self.stop.check()?;
            let at = MicroStep::new(step, j, count);
            let contacts = self.sides.mechanics.capabilities().contact_mechanics();
            if let Some(mechanics) = contacts.filter(|mechanics| mechanics.is_of_second_order()) {
                mechanics.step_together(
                    &mut LentActuator(self.sides.actuator),
                    at.start,
                    at.length,
                    &mut |length, force, motion| {
                        work_sent.add_step(length, force, motion);
                        let share = length / step.length;
                        received.iter_mut().zip(force).for_each(|(received, force)| *received += share * force);
                    },
                )?;
                self.sides.mechanics.outputs(&y.actuator, &mut y.mechanics)?;
                self.sides.actuator.outputs(&y.mechanics, &mut y.actuator)?;
                continue;
            }
            for (received, y) in received.iter_mut().zip(&y.actuator) {
                *received += y / count as f64;
            }
            work_sent.add_half_step(at.length, &y.actuator, &y.mechanics);
            self.sides.mechanics.step(at.start, &y.actuator, at.length)?;
            self.sides.mechanics.outputs(&y.actuator, &mut y.mechanics)?;
            work_sent.add_half_step(at.length, &y.actuator, &y.mechanics);
            self.sides.actuator.step(at.start, &y.mechanics, at.length)?;
            self.sides.actuator.outputs(&y.mechanics, &mut y.actuator)?;
        }
        u.mechanics.copy_from_slice(&y.actuator);
        u.actuator.copy_from_slice(&y.mechanics);
        self.state.counters.macro_steps += 1;
        Ok(())
    }
}
