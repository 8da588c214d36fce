//! Implicit coupling: a macro step is taken again, on copies, until both sides agree on what they exchanged.

use super::copied_pair::CopiedPair;
use super::relaxation::Relaxation;
use crate::cosim::{CoupledPair, MacroInterval, PerSide, Sequence, Side};
use crate::error::{Cause, Failure};
use nalgebra::DVector;

/// The iteration of an implicit coupling.
///
/// ```text
/// guess x of the coupling variables at t_{k+1};  the scheme gets it as a sample taken there
/// both sides cover the macro step from copies of their state at t_k;  G(x): their outputs at t_{k+1}
/// done when |G(x) − x| ≤ tolerance · size, variable by variable
/// ```
/// The size of a variable is its largest magnitude so far, at least
/// [`Quantity::negligible`](crate::cosim::Quantity::negligible). The guess is of the inputs of the side that goes
/// first; in the Jacobi sequence those of both sides. The first guess is the value at `t_k`. A guess with which a step
/// fails is drawn back half way to the last one that went well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// Relative residual at which the iteration ends.
    pub tolerance: f64,
    /// Iterations after which the run fails with [`Cause::NotConverged`].
    pub most_iterations: u32,
}

impl CopiedPair<'_> {
    /// Covers a macro step with inputs that agree with the outputs at its end.
    ///
    /// # Errors
    /// [`Cause::NotConverged`]; that of the first guess.
    pub(super) fn iterate(&mut self, iteration: Iteration, interval: MacroInterval) -> Result<(), Failure> {
        self.record_sizes();
        let sequence = self.setup.sequence;
        let mut guess = guessed(sequence, &self.state.y);
        let mut sizes = guessed(sequence, &self.sizes);
        let mut relaxation = Relaxation::default();
        let mut least = f64::INFINITY;
        for _ in 0..iteration.most_iterations {
            let mut trial = self.try_clone()?;
            let swept = trial.lend().sweep(interval, guess.as_slice());
            let back = guessed(sequence, &trial.state.y);
            if swept.as_ref().is_err_and(Failure::is_stop) {
                return swept;
            }
            if swept.is_ok() && back.iter().all(|value| value.is_finite()) {
                if relaxation.last_guess().is_none() {
                    sizes.iter_mut().zip(&back).for_each(|(size, back)| *size = size.max(back.abs()));
                }
                let residual = (&back - &guess).component_div(&sizes);
                let largest = residual.amax();
                least = least.min(largest);
                if largest <= iteration.tolerance {
                    *self = trial;
                    return Ok(());
                }
                guess = relaxation.next(guess.component_div(&sizes), residual).component_mul(&sizes);
            } else {
                // Nothing went well yet: the step itself fails.
                let Some(last) = relaxation.last_guess() else {
                    return swept.and(Err(Failure::non_finite("coupling variables")));
                };
                guess = 0.5 * (guess + last.component_mul(&sizes));
            }
            let mut wasted = trial.work().since(&self.work());
            wasted.cosim.repeated_macro_steps += 1;
            self.book_discarded(wasted);
        }
        Err(Cause::NotConverged { residual: least, iterations: iteration.most_iterations }.into())
    }
}

/// Of a number per output of either side, those of the outputs that are guessed.
fn guessed(sequence: Sequence, of: &PerSide<Vec<f64>>) -> DVector<f64> {
    match sequence {
        Sequence::Jacobi => {
            let count = of.mechanics.len() + of.actuator.len();
            DVector::from_iterator(count, of.iter().flatten().copied())
        }
        Sequence::GaussSeidel { first } => DVector::from_column_slice(&of[first.other()]),
    }
}

impl CoupledPair<'_> {
    /// Both sides cover the macro step, given a guess of the outputs at its end; those outputs are then evaluated.
    fn sweep(&mut self, interval: MacroInterval, guess: &[f64]) -> Result<(), Failure> {
        let step = interval.step;
        match self.setup.sequence {
            Sequence::Jacobi => {
                let (motion, force) = guess.split_at(self.state.y.mechanics.len());
                self.state.y.mechanics.copy_from_slice(motion);
                self.state.y.actuator.copy_from_slice(force);
                self.send_fresh_sample(Side::Mechanics, interval)?;
                self.send_fresh_sample(Side::Actuator, interval)?;
                self.advance_actuator(step)?;
                self.advance_mechanics(step)?;
                self.sides.actuator.outputs(motion, &mut self.state.y.actuator)?;
                self.sides.mechanics.outputs(force, &mut self.state.y.mechanics)?;
            }
            Sequence::GaussSeidel { first } => {
                let second = first.other();
                self.state.y[second].copy_from_slice(guess);
                self.send_fresh_sample(second, interval)?;
                self.advance_side(first, step)?;
                self.sides[first].outputs(guess, &mut self.state.y[first])?;
                self.send_fresh_sample(first, interval)?;
                self.advance_side(second, step)?;
                let (of_first, of_second) = self.state.y.split_mut(first);
                self.sides[second].outputs(of_first, of_second)?;
            }
        }
        Ok(())
    }
}
