//! Implicit coupling: a macro step is taken again, on copies, until both sides agree on what they exchanged.

use super::acceleration::{Acceleration, Accelerator};
use super::coupled_pair::{CoupledPair, Interval};
use super::force_return::Sequence;
use super::subsystem::Side;
use crate::error::Failure;
use nalgebra::DVector;

/// How a scheme couples the two sides over a macro step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Coupling {
    /// Once, from what is known at its start.
    #[default]
    Explicit,
    /// Again and again until what was guessed comes back.
    Implicit(Iteration),
    /// Both sides together at the micro step, with no macro step between them.
    Monolithic,
}

/// The iteration of an implicit coupling.
///
/// ```text
/// guess x of the coupling variables at t_{k+1};  the scheme gets it as a sample taken there
/// both sides cover the macro step from copies of their state at t_k;  G(x): their outputs at t_{k+1}
/// done when |G(x) − x| ≤ tolerance · size, variable by variable
/// ```
/// The size of a variable is its largest magnitude so far, at least [`Quantity::negligible`](super::Quantity::negligible).
/// What is guessed is what the side that goes first is given: its inputs; in the Jacobi sequence those of both sides. The
/// first guess is the value at `t_k`. A guess with which a step fails is drawn back half way to the last one that went well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// How the next guess is found.
    pub acceleration: Acceleration,
    /// Relative residual at which the iteration ends.
    pub tolerance: f64,
    /// Iterations after which the run fails with [`Failure::NotConverged`].
    pub most_iterations: u32,
}

impl CoupledPair<'_> {
    /// Covers a macro step with inputs that agree with the outputs at its end.
    ///
    /// # Errors
    /// [`Failure::NotConverged`]; that of the first guess.
    pub(super) fn iterate(&mut self, iteration: Iteration, interval: Interval) -> Result<(), Failure> {
        self.note_sizes();
        let mut guess = self.guessed(&self.y_mechanics, &self.y_actuator);
        let mut sizes = self.guessed(&self.size_mechanics, &self.size_actuator);
        let mut accelerator = Accelerator::new(iteration.acceleration);
        let mut least = f64::INFINITY;
        for _ in 0..iteration.most_iterations {
            let mut trial = self.try_clone()?;
            let swept = trial.sweep(interval, guess.as_slice());
            let back = trial.guessed(&trial.y_mechanics, &trial.y_actuator);
            if swept.is_ok() && back.iter().all(|value| value.is_finite()) {
                if accelerator.last_guess().is_none() {
                    sizes.iter_mut().zip(&back).for_each(|(size, back)| *size = size.max(back.abs()));
                }
                let residual = (&back - &guess).component_div(&sizes);
                let largest = residual.amax();
                least = least.min(largest);
                if largest <= iteration.tolerance {
                    *self = trial;
                    return Ok(());
                }
                guess = accelerator.next(guess.component_div(&sizes), residual).component_mul(&sizes);
            } else {
                // Nothing went well yet: the step itself fails.
                let Some(last) = accelerator.last_guess() else {
                    return swept.and(Err(Failure::NonFinite { quantity: "coupling variables" }));
                };
                guess = 0.5 * (guess + last.component_mul(&sizes));
            }
            let mut wasted = trial.work().since(&self.work());
            wasted.cosim.repeated_macro_steps += 1;
            self.book_discarded(wasted);
        }
        Err(Failure::NotConverged { residual: least, iterations: iteration.most_iterations })
    }
}

impl CoupledPair<'_> {
    /// Takes note of how large the coupling variables get.
    pub(super) fn note_sizes(&mut self) {
        let sides = [(&mut self.size_mechanics, &self.y_mechanics), (&mut self.size_actuator, &self.y_actuator)];
        for (sizes, y) in sides {
            sizes.iter_mut().zip(y).for_each(|(size, y)| *size = size.max(y.abs()));
        }
    }

    /// Of a number per output of either side, those of the outputs that are guessed.
    fn guessed(&self, mechanics: &[f64], actuator: &[f64]) -> DVector<f64> {
        match self.setup.sequence {
            Sequence::Jacobi => {
                DVector::from_iterator(mechanics.len() + actuator.len(), mechanics.iter().chain(actuator).copied())
            }
            Sequence::GaussSeidel { first: Side::Actuator } => DVector::from_column_slice(mechanics),
            Sequence::GaussSeidel { first: Side::Mechanics } => DVector::from_column_slice(actuator),
        }
    }

    /// Both sides cover the macro step, given a guess of the outputs at its end; those outputs are then evaluated.
    fn sweep(&mut self, interval: Interval, guess: &[f64]) -> Result<(), Failure> {
        let step = interval.step;
        match self.setup.sequence {
            Sequence::Jacobi => {
                let (motion, force) = guess.split_at(self.y_mechanics.len());
                self.y_mechanics.copy_from_slice(motion);
                self.y_actuator.copy_from_slice(force);
                self.send_ahead(Side::Mechanics, interval)?;
                self.send_ahead(Side::Actuator, interval)?;
                self.advance_actuator(step)?;
                self.advance_mechanics(step)?;
                self.actuator.outputs(motion, &mut self.y_actuator);
                self.mechanics.outputs(force, &mut self.y_mechanics);
            }
            Sequence::GaussSeidel { first: Side::Actuator } => {
                self.y_mechanics.copy_from_slice(guess);
                self.send_ahead(Side::Mechanics, interval)?;
                self.advance_actuator(step)?;
                self.actuator.outputs(guess, &mut self.y_actuator);
                self.send_ahead(Side::Actuator, interval)?;
                self.advance_mechanics(step)?;
                self.mechanics.outputs(&self.y_actuator, &mut self.y_mechanics);
            }
            Sequence::GaussSeidel { first: Side::Mechanics } => {
                self.y_actuator.copy_from_slice(guess);
                self.send_ahead(Side::Actuator, interval)?;
                self.advance_mechanics(step)?;
                self.mechanics.outputs(guess, &mut self.y_mechanics);
                self.send_ahead(Side::Mechanics, interval)?;
                self.advance_actuator(step)?;
                self.actuator.outputs(&self.y_mechanics, &mut self.y_actuator);
            }
        }
        Ok(())
    }
}
