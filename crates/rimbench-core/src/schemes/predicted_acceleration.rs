//! `predicted-acceleration`: the acceleration of the interface is held; velocity and position follow from it.
//!
//! An extrapolation treats position and velocity as two signals that know nothing of each other. Here the actuator sees a
//! motion: one acceleration per macro step, integrated to velocity and position.
//!
//! ```text
//! a_k = (w(t_k) − w(t_{k−1})) / (t_k − t_{k−1})      τ = t − t_k
//! w(t) = w(t_k) + a_k τ      s(t) = s(t_k) + w(t_k) τ + ½ a_k τ²      λ(t) = λ(t_k) + τ (λ(t_k) − λ(t_{k−1})) / (t_k − t_{k−1})
//! ```
//! **Needs** a force–displacement coupling; two samples, before which velocity and force are held (the position already
//! follows the velocity). **Order** 2 in H, by the velocity and the force; the position alone would give 3. **Known weakness**:
//! the acceleration is that of the last macro step: wrong after every impact and as soon as a contact opens.
//! **Source**: Kraft, Meyer, Schweizer 2019 (coupling variables predicted at the level of accelerations). Their subsystems
//! send accelerations; the ports here do not, so the backward difference of the velocity is ours, and so is the linear
//! extrapolation of the force.

use super::entry::SchemeEntry;
use super::extrapolation::History;
use super::line_style::{Dash, LineStyle, Marker};
use super::need::Need;
use crate::cosim::{CouplingScheme, MicroStep, Sample, SchemeReport, Side};
use crate::error::Failure;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 2,
        samples: 2,
        needs: vec![Need::ForceDisplacement],
        line: LineStyle::new([0xC2, 0x18, 0x5B], Dash::Long, Marker::Circle),
        ..SchemeEntry::new(
            "predicted-acceleration",
            "Hold the acceleration of the interface, integrate it to velocity and position",
            |construction| {
                let rows = construction.interface();
                let (motion, force) = (vec![Motion::default(); rows], History::new(rows, 2));
                Ok(Box::new(PredictedAcceleration { time: f64::NAN, motion, force }))
            },
        )
    }
}

/// One row of the interface at the time of the newest sample.
#[derive(Debug, Clone, Copy, Default)]
struct Motion {
    position: f64,
    velocity: f64,
    acceleration: f64,
}

#[derive(Clone)]
struct PredictedAcceleration {
    /// Of the newest sample of the mechanics; NaN before the first.
    time: f64,
    motion: Vec<Motion>,
    force: History,
}

impl CouplingScheme for PredictedAcceleration {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        if from == Side::Actuator {
            self.force.push(sample.time, sample.y);
            return Ok(());
        }
        let elapsed = sample.time - self.time;
        let (positions, velocities) = sample.y.split_at(self.motion.len());
        for (motion, (&position, &velocity)) in self.motion.iter_mut().zip(positions.iter().zip(velocities)) {
            if elapsed > 0.0 {
                motion.acceleration = (velocity - motion.velocity) / elapsed;
            }
            (motion.position, motion.velocity) = (position, velocity);
        }
        self.time = sample.time;
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Mechanics {
            self.force.evaluate(1, at.middle(), u);
            return Ok(());
        }
        let since = at.middle() - self.time;
        let (positions, velocities) = u.split_at_mut(self.motion.len());
        for (motion, (position, velocity)) in self.motion.iter().zip(positions.iter_mut().zip(velocities)) {
            let gained = motion.acceleration * since;
            *velocity = motion.velocity + gained;
            *position = motion.position + since * (motion.velocity + 0.5 * gained);
        }
        Ok(())
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport::default()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::MacroStep;

    #[test]
    fn free_fall_is_predicted_exactly_from_the_second_sample_on() {
        let (motion, force) = (vec![Motion::default()], History::new(1, 2));
        let mut scheme = PredictedAcceleration { time: f64::NAN, motion, force };
        // s = ½ · (−8) t², w = −8 t; F = 1 + 2 t.
        let fall = |t: f64| [-4.0 * t * t, -8.0 * t];
        let mut u = [f64::NAN; 2];
        for k in 0..3 {
            let step = MacroStep { index: k, start: k as f64, length: 1.0 };
            let y = fall(step.start);
            let sample = Sample { time: step.start, y: &y, model: None, rates: None, step, actuator_micro_step: 0.5 };
            scheme.receive(Side::Mechanics, &sample).unwrap();
            scheme.receive(Side::Actuator, &Sample { y: &[1.0 + 2.0 * step.start], ..sample }).unwrap();
            for j in 0..2 {
                let at = MicroStep::new(step, j, 2);
                scheme.input(Side::Actuator, at, &[0.0], &mut u).unwrap();
                // From one sample, at rest, rest is all that can be said. All numbers are dyadic: no rounding.
                assert_eq!(u, if k == 0 { [0.0, 0.0] } else { fall(at.middle()) });
            }
            let mut force = [f64::NAN];
            scheme.input(Side::Mechanics, MicroStep::new(step, 0, 1), &[0.0; 2], &mut force).unwrap();
            assert_eq!(force, [if k == 0 { 1.0 } else { 1.0 + 2.0 * (step.start + 0.5) }]);
        }
    }
}
