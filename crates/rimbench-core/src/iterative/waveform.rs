//! Waveform iteration: both sides cover the macro step on the micro grid, again and again, until what they exchanged stays.

use super::copied_pair::CopiedPair;
use crate::cosim::{CoupledPair, MacroInterval, MacroStep, MicroStep, PairState};
use crate::error::{Cause, Failure};

/// Waveform iteration on the micro grid of the actuator.
///
/// ```text
/// λ_j⁰ = λ_k;   i = 1, 2, …:   mechanics over all micro steps with λ_j^{i−1} → (s, w)_{j+1}^i;
///                              actuator over all micro steps with (s, w)_{j+1}^i → λ_{j+1}^i
/// done when |λ_j^i − λ_j^{i−1}| ≤ tolerance · size for all j, likewise (s, w)
/// ```
/// Every pass starts from copies of both sides at `t_k`. The rule of a micro step is that of the monolithic stepper, so that this
/// is what it converges to, for any H, impacts included: each pass is the full complementarity step.
/// # Source
/// Textbook (waveform relaxation, Gauss–Seidel form); the micro-step rule is ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waveform {
    /// Largest change of a coupling variable, relative to its size, at which the iteration ends.
    pub tolerance: f64,
    /// Passes after which the run fails with [`Cause::NotConverged`].
    pub most_iterations: u32,
}

/// The coupling variables at all points of the micro grid, one row per point.
struct Waves {
    motion: Vec<f64>,
    force: Vec<f64>,
}

impl CopiedPair<'_> {
    /// Covers a macro step with waveforms that agree.
    ///
    /// # Errors
    /// [`Cause::NotConverged`]; that of a pass.
    pub(super) fn relax_waveforms(&mut self, waveform: Waveform, interval: MacroInterval) -> Result<(), Failure> {
        self.record_sizes();
        let points = self.setup.actuator_steps(interval.step) + 1;
        let mut waves =
            Waves { motion: self.state.y.mechanics.repeat(points), force: self.state.y.actuator.repeat(points) };
        let mut least = f64::INFINITY;
        for _ in 0..waveform.most_iterations {
            let mut trial = self.try_clone()?;
            let changes = trial.lend().pass(interval.step, &mut waves)?;
            let sizes = [&mut self.sizes.mechanics, &mut self.sizes.actuator];
            for (sizes, wave) in sizes.into_iter().zip([&waves.motion, &waves.force]) {
                for row in wave.chunks(sizes.len()) {
                    sizes.iter_mut().zip(row).for_each(|(size, value)| *size = size.max(value.abs()));
                }
            }
            let sizes = self.sizes.mechanics.iter().chain(&self.sizes.actuator);
            let change = changes.iter().zip(sizes).map(|(change, size)| change / size).fold(0.0, f64::max);
            least = least.min(change);
            if change <= waveform.tolerance {
                trial.sizes = self.sizes.clone();
                *self = trial;
                return Ok(());
            }
            let mut wasted = trial.work().since(&self.work());
            wasted.cosim.repeated_macro_steps += 1;
            self.book_discarded(wasted);
        }
        Err(Cause::NotConverged { residual: least, iterations: waveform.most_iterations }.into())
    }
}

impl CoupledPair<'_> {
    /// One pass over the macro step; returns the largest change of each coupling variable, the mechanics' outputs first.
    fn pass(&mut self, step: MacroStep, waves: &mut Waves) -> Result<Vec<f64>, Failure> {
        let PairState { received, work_sent, y, u, .. } = &mut *self.state;
        let (m, a) = (y.mechanics.len(), y.actuator.len());
        let count = waves.motion.len() / m - 1;
        let mut changes = vec![0.0_f64; m + a];
        let note = |changes: &mut [f64], old: &[f64], new: &[f64]| {
            for (change, (old, new)) in changes.iter_mut().zip(old.iter().zip(new)) {
                // What is not a number must not pass for a small change.
                let by = (new - old).abs();
                *change = if by <= *change { *change } else { by };
            }
        };
        received.fill(0.0);
        for j in 0..count {
            self.stop.check()?;
            let at = MicroStep::new(step, j, count);
            let force = &waves.force[j * a..(j + 1) * a];
            for (received, force) in received.iter_mut().zip(force) {
                *received += force / count as f64;
            }
            work_sent.add_half_step(at.length, force, &waves.motion[j * m..(j + 1) * m]);
            self.sides.mechanics.step(at.start, force, at.length)?;
            self.sides.mechanics.outputs(force, &mut y.mechanics)?;
            work_sent.add_half_step(at.length, force, &y.mechanics);
            let motion = &mut waves.motion[(j + 1) * m..(j + 2) * m];
            note(&mut changes[..m], motion, &y.mechanics);
            motion.copy_from_slice(&y.mechanics);
        }
        for j in 0..count {
            self.stop.check()?;
            let at = MicroStep::new(step, j, count);
            let motion = &waves.motion[(j + 1) * m..(j + 2) * m];
            self.sides.actuator.step(at.start, motion, at.length)?;
            self.sides.actuator.outputs(motion, &mut y.actuator)?;
            let force = &mut waves.force[(j + 1) * a..(j + 2) * a];
            note(&mut changes[m..], force, &y.actuator);
            force.copy_from_slice(&y.actuator);
        }
        if !y.mechanics.iter().chain(&y.actuator).all(|value| value.is_finite()) {
            return Err(Failure::non_finite("coupling variables"));
        }
        u.mechanics.copy_from_slice(&y.actuator);
        u.actuator.copy_from_slice(&y.mechanics);
        self.state.counters.macro_steps += 1;
        Ok(changes)
    }
}
