//! Where the communication points lie: integers in, times out, nothing accumulated.

use crate::error::{Error, Result};

/// Relative slack within which two step sizes count as multiples of each other.
const COMMENSURATE: f64 = 1e-9;

/// Shortest first macro step as a part of H: one of no length at all would be a division by nothing.
const SHORTEST_PHASE: f64 = 1e-9;

/// Least number that may have been meant in ms where s are asked for: shorter steps are told in µs.
const LEAST_TOLD: f64 = 0.1;

/// The communication points `t_0 = 0, t_k = (k − 1 + φ) H, …, t_K = T`.
///
/// The first macro step is `φH` long, so that an ensemble over φ moves the communication points relative to a contact
/// event. The last one is shortened where `H` does not divide what is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommunicationGrid {
    macro_step: f64,
    phase: f64,
    duration: f64,
    count: usize,
}

/// One macro step `[t_k, t_k + length]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MacroStep {
    /// k, from 0.
    pub index: usize,
    /// `t_k`, s.
    pub start: f64,
    /// s.
    pub length: f64,
}

impl CommunicationGrid {
    /// Lays the grid for macro step `H` (s), phase `φ` in (0, 1] and duration `T` (s).
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for `H ≤ 0`, `H > T`, φ outside [1e-9, 1], or anything that is not a finite number.
    pub fn new(macro_step: f64, phase: f64, duration: f64) -> Result<Self> {
        if !(duration.is_finite() && duration > 0.0) {
            return Err(Error::invalid("duration_s", duration, "a finite time above 0 s"));
        }
        if !(macro_step.is_finite() && macro_step > 0.0) {
            return Err(Error::invalid("macro_step_s", macro_step, "a finite time above 0 s"));
        }
        if macro_step > duration {
            // A number that would be a usual step in ms was probably meant so, though the option is in s.
            let told = macro_step >= LEAST_TOLD && 1e-3 * macro_step <= duration;
            let meant = if told { format!("; did you mean {macro_step}ms?") } else { String::new() };
            return Err(Error::invalid(
                "macro_step_s",
                macro_step,
                format!("at most the duration, {duration} s{meant}"),
            ));
        }
        if !(SHORTEST_PHASE..=1.0).contains(&phase) {
            let expected = format!("a number in (0, 1], at least {SHORTEST_PHASE:e}");
            return Err(Error::invalid("phase", format!("{phase:?}"), expected));
        }
        let rest = duration / macro_step - phase;
        // A duration that is a multiple of H up to round-off gets no sliver of a last step.
        let count = 1 + ceil_with_slack(rest.max(0.0));
        Ok(CommunicationGrid { macro_step, phase, duration, count })
    }

    /// Returns the number of macro steps K.
    pub fn macro_steps(&self) -> usize {
        self.count
    }

    /// Returns `H`, s.
    pub fn macro_step(&self) -> f64 {
        self.macro_step
    }

    /// Returns `T`, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Returns `t_k`, s.
    pub fn time(&self, index: usize) -> f64 {
        match index {
            0 => 0.0,
            k if k >= self.count => self.duration,
            k => (k as f64 - 1.0 + self.phase) * self.macro_step,
        }
    }

    /// Tells whether all macro steps are of one length, up to round-off.
    pub fn is_even(&self) -> bool {
        [0, self.count - 1].iter().all(|&index| (self.step(index).length / self.macro_step - 1.0).abs() < COMMENSURATE)
    }

    /// Returns the macro step that starts at `t_k`.
    pub fn step(&self, index: usize) -> MacroStep {
        let start = self.time(index);
        // Full steps are equally long to the bit; only the first and the last may be shorter.
        let full = index + 1 < self.count && (index > 0 || self.phase == 1.0);
        let length = if full { self.macro_step } else { self.time(index + 1) - start };
        MacroStep { index, start, length }
    }
}

/// Returns the number of steps, none longer than `longest`, that divide `length`.
///
/// ```text
/// n = ⌈length / longest⌉      the step used is length / n
/// ```
pub fn division(length: f64, longest: f64) -> usize {
    ceil_with_slack(length / longest).max(1)
}

fn ceil_with_slack(ratio: f64) -> usize {
    (ratio - COMMENSURATE * ratio.max(1.0)).ceil().max(0.0) as usize
}

/// One micro step inside a macro step. All times come from integers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MicroStep {
    /// j, from 0.
    pub index: usize,
    /// Number of micro steps in the macro step.
    pub count: usize,
    /// `δ`, s.
    pub length: f64,
    /// Absolute time at its start, `t_k + jδ`, s.
    pub start: f64,
    /// Time since the communication point at its start, `jδ`, s.
    pub since_exchange: f64,
}

impl MicroStep {
    /// Makes the micro step `index` of `count` in `step`.
    #[inline]
    pub fn new(step: MacroStep, index: usize, count: usize) -> Self {
        // Signed numbers become floating ones in a single instruction.
        let length = step.length / count as i64 as f64;
        let since_exchange = index as i64 as f64 * length;
        MicroStep { index, count, length, start: step.start + since_exchange, since_exchange }
    }

    /// Returns the absolute time at its middle, s.
    #[inline]
    pub fn middle(&self) -> f64 {
        self.start + 0.5 * self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(macro_step: f64, phase: f64, duration: f64) -> Vec<f64> {
        let grid = CommunicationGrid::new(macro_step, phase, duration).unwrap();
        (0..=grid.macro_steps()).map(|k| grid.time(k)).collect()
    }

    #[test]
    fn a_dividing_macro_step_gives_no_sliver() {
        assert_eq!(times(0.1, 1.0, 0.3).len(), 4);
        assert_eq!(times(2e-4, 1.0, 2.5).len(), 12501);
        assert_eq!(times(0.25, 1.0, 1.0), [0.0, 0.25, 0.5, 0.75, 1.0]);
    }

    #[test]
    fn a_phase_shortens_the_first_step_and_the_last_takes_what_is_left() {
        assert_eq!(times(0.25, 0.5, 1.0), [0.0, 0.125, 0.375, 0.625, 0.875, 1.0]);
        assert_eq!(times(0.4, 1.0, 1.0), [0.0, 0.4, 0.8, 1.0]);
        assert_eq!(times(1.0, 0.5, 1.0), [0.0, 0.5, 1.0]);
        assert_eq!(times(1.0, 1.0, 1.0), [0.0, 1.0]);
    }

    #[test]
    fn steps_tile_the_duration() {
        for (macro_step, phase, duration) in [(5e-3, 0.3, 2.5), (7e-4, 1.0, 2.5), (0.013, 0.001, 1.0)] {
            let grid = CommunicationGrid::new(macro_step, phase, duration).unwrap();
            let total: f64 = (0..grid.macro_steps()).map(|k| grid.step(k).length).sum();
            approx::assert_relative_eq!(total, duration, epsilon = 1e-12);
            assert!((0..grid.macro_steps()).all(|k| grid.step(k).length > 0.0));
        }
    }

    #[test]
    fn micro_steps_divide_the_macro_step_and_are_never_longer_than_asked() {
        assert_eq!(division(5e-3, 5e-5), 100);
        assert_eq!(division(2e-4, 5e-5), 4);
        assert_eq!(division(1e-3, 3e-4), 4);
        assert_eq!(division(1e-5, 5e-5), 1);
    }

    #[test]
    fn nonsense_is_refused() {
        for (macro_step, phase, duration) in
            [(0.0, 1.0, 1.0), (-1.0, 1.0, 1.0), (f64::NAN, 1.0, 1.0), (2.0, 1.0, 1.0), (0.1, 0.0, 1.0), (0.1, 1.1, 1.0)]
        {
            assert!(CommunicationGrid::new(macro_step, phase, duration).is_err());
        }
    }
}
