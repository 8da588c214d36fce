//! How both sides cover a macro step, and with how many steps of their own.

use super::{CoupledPair, Interval};
use crate::cosim::communication_grid::{MacroStep, division};
use crate::cosim::coupling_scheme::MicroStep;
use crate::cosim::force_return::{ForceReturn, Sequence};
use crate::cosim::iteration::Coupling;
use crate::cosim::subsystem::Side;
use crate::error::Failure;

impl CoupledPair<'_> {
    /// Lets both sides cover a macro step in the way that the scheme couples them.
    pub(in crate::cosim) fn advance(&mut self, interval: Interval) -> Result<(), Failure> {
        match self.coupling {
            Coupling::Explicit => self.advance_in_sequence(interval)?,
            Coupling::Implicit(iteration) => self.iterate(iteration, interval)?,
            Coupling::Monolithic => self.advance_together(interval.step)?,
        }
        self.counters.macro_steps += 1;
        Ok(())
    }

    fn advance_in_sequence(&mut self, interval: Interval) -> Result<(), Failure> {
        let step = interval.step;
        match self.setup.sequence {
            Sequence::Jacobi | Sequence::GaussSeidel { first: Side::Actuator } => {
                self.advance_actuator(step)?;
                self.advance_mechanics(step)
            }
            Sequence::GaussSeidel { first: Side::Mechanics } => {
                self.advance_mechanics(step)?;
                self.mechanics.outputs(&self.u_mechanics, &mut self.y_mechanics);
                self.send_ahead(Side::Mechanics, interval)?;
                self.advance_actuator(step)
            }
        }
    }

    pub(in crate::cosim) fn advance_actuator(&mut self, step: MacroStep) -> Result<(), Failure> {
        let count = self.actuator_steps(step);
        let own = &mut self.own[..self.y_actuator.len()];
        let averaged = matches!(self.setup.force_return, ForceReturn::Mean | ForceReturn::Profile);
        let (actuator, scheme) = (&mut *self.actuator, &mut *self.scheme);
        self.transmission.clear();
        for j in 0..count {
            let at = MicroStep::new(step, j, count);
            actuator.outputs(&self.u_actuator, own);
            self.work_sent.add_half_step(at.length, own, &self.u_actuator);
            scheme.input(Side::Actuator, at, own, &mut self.u_actuator)?;
            self.work_sent.add_half_step(at.length, own, &self.u_actuator);
            actuator.step(at.start, &self.u_actuator, at.length)?;
            if averaged {
                self.transmission.push(own);
            }
        }
        // The value at the end of the step, for the force return `end`.
        actuator.outputs(&self.u_actuator, own);
        Ok(())
    }

    pub(in crate::cosim) fn advance_mechanics(&mut self, step: MacroStep) -> Result<(), Failure> {
        let count = self.mechanics_steps(step);
        let (mechanics, scheme) = (&mut *self.mechanics, &mut *self.scheme);
        self.received.fill(0.0);
        for i in 0..count {
            let at = MicroStep::new(step, i, count);
            match self.setup.force_return {
                ForceReturn::Held => {
                    let own = &mut self.own[..self.y_mechanics.len()];
                    mechanics.outputs(&self.u_mechanics, own);
                    scheme.input(Side::Mechanics, at, own, &mut self.u_mechanics)?;
                }
                ForceReturn::End => self.u_mechanics.copy_from_slice(&self.own[..self.y_actuator.len()]),
                ForceReturn::Mean => self.transmission.mean_over(0, 1, &mut self.u_mechanics),
                ForceReturn::Profile => self.transmission.mean_over(i, count, &mut self.u_mechanics),
            }
            mechanics.step(at.start, &self.u_mechanics, at.length)?;
            for (received, u) in self.received.iter_mut().zip(&self.u_mechanics) {
                *received += u / count as f64;
            }
        }
        Ok(())
    }

    /// Both sides in one loop at the micro step, as [`monolithic`](crate::mechanics::monolithic) does it: the mechanics
    /// with the force of the state before, the actuator with the motion after.
    fn advance_together(&mut self, step: MacroStep) -> Result<(), Failure> {
        let count = self.mechanics_steps(step);
        self.received.fill(0.0);
        for j in 0..count {
            let at = MicroStep::new(step, j, count);
            for (received, y) in self.received.iter_mut().zip(&self.y_actuator) {
                *received += y / count as f64;
            }
            self.work_sent.add_half_step(at.length, &self.y_actuator, &self.y_mechanics);
            self.mechanics.step(at.start, &self.y_actuator, at.length)?;
            self.mechanics.outputs(&self.y_actuator, &mut self.y_mechanics);
            self.work_sent.add_half_step(at.length, &self.y_actuator, &self.y_mechanics);
            self.actuator.step(at.start, &self.y_mechanics, at.length)?;
            self.actuator.outputs(&self.y_mechanics, &mut self.y_actuator);
        }
        self.u_mechanics.copy_from_slice(&self.y_actuator);
        self.u_actuator.copy_from_slice(&self.y_mechanics);
        Ok(())
    }

    /// The mechanics' own step in a macro step, s.
    pub(super) fn mechanics_step(&self, step: MacroStep) -> f64 {
        step.length / self.mechanics_steps(step) as f64
    }

    fn mechanics_steps(&self, step: MacroStep) -> usize {
        match self.setup.mechanics_steps {
            count if count > 0 && self.coupling != Coupling::Monolithic => count,
            _ => self.actuator_steps(step),
        }
    }

    /// The actuator's own step in a macro step, s.
    pub(super) fn actuator_micro_step(&self, step: MacroStep) -> f64 {
        step.length / self.actuator_steps(step) as f64
    }

    fn actuator_steps(&self, step: MacroStep) -> usize {
        division(step.length, self.setup.micro_step)
    }
}
