//! Steps of the mechanics that are tried while the actuator steps: what it would answer to a force over the macro step.

use crate::error::{Error, Failure, Result};
use crate::parts::Parts;
use std::fmt;
use std::str::FromStr;

/// How a scheme that tries steps of the mechanics uses them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialSettings {
    /// How far a force may be from one that was tried before it is tried itself, of the largest mean force of the run
    /// so far.
    pub range: f64,
    /// By how much the velocity at the end of the macro step may be off, of what it has moved, before there is another
    /// tangent.
    pub tolerance: f64,
    /// Most trials per macro step.
    pub most: usize,
    /// Standard deviation of velocities that are read, m/s: forces are changed by the whole range then, and six times
    /// this is no error.
    pub noise: f64,
}

/// Rows of the interface from which on the trials of a tangent count by themselves.
const BY_THE_DOZEN: usize = 10;

impl Default for TrialSettings {
    fn default() -> Self {
        TrialSettings { range: 0.05, tolerance: 0.02, most: 24, noise: 0.0 }
    }
}

impl fmt::Display for TrialSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TrialSettings { range, tolerance, most, noise } = self;
        write!(f, "range:{range:?},tolerance:{tolerance:?},most:{most},noise:{noise:?}")
    }
}

impl FromStr for TrialSettings {
    type Err = Error;

    /// Reads `range=R,tolerance=T,most=N,noise=V`, each part at most once and in any order.
    fn from_str(text: &str) -> Result<Self> {
        let mut settings = TrialSettings::default();
        let TrialSettings { range, tolerance, most, noise } = &mut settings;
        let parts = Parts::of("trials", text, ["range", "tolerance", "most", "noise"])?;
        let above = |number: &f64| number.is_finite() && *number > 0.0;
        parts.read("range", range, above, "a share of the force above 0, as in `range=0.05`")?;
        parts.read("tolerance", tolerance, above, "a share of the motion above 0, as in `tolerance=0.02`")?;
        let count = "trials per macro step, from 1, as in `most=24`";
        parts.read("most", most, |most| (1..=100_000).contains(most), count)?;
        let velocity = "a velocity in m/s from 0, as in `noise=1e-4`";
        parts.read("noise", noise, |noise| noise.is_finite() && *noise >= 0.0, velocity)?;
        Ok(settings)
    }
}

/// What was tried in a run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TrialReport {
    /// Trials of all macro steps.
    pub count: u64,
    /// Most in one macro step.
    pub most: u64,
    /// Macro steps in which a force was not tried because there were as many as are allowed.
    pub cut: u64,
    /// Tangents beside the first of a macro step.
    pub further: u64,
    /// Median of the error of the velocity at the end of a macro step, of what it has moved, and the largest.
    pub miss: [f64; 2],
}

/// The mechanics as it stands at the communication point, for steps that are tried on copies of it.
pub trait Trials {
    /// Returns the length of the macro step, s.
    fn length(&self) -> f64;

    /// Counts the trials of this macro step.
    fn taken(&self) -> usize;

    /// Returns how they are used.
    fn settings(&self) -> TrialSettings;

    /// Tells whether there may be so many more in this macro step; of `rows` by the dozen as many as a tangent needs, and
    /// five.
    fn has_left(&self, more: usize, rows: usize) -> bool {
        let least = if rows >= BY_THE_DOZEN { 2 * rows + 6 } else { 0 };
        self.taken() + more <= self.settings().most.max(least)
    }

    /// Tells whether the mechanics moves by its own step times the velocity at its end, as that of the benchmark does.
    /// One from outside may take steps of its own in between, which only its position tells.
    fn is_semi_implicit(&self) -> bool;

    /// Writes the positions, m, and velocities, m/s, of the interface at the end of the macro step to `end`, positions
    /// first, if `force` (N) acts during all of it.
    ///
    /// # Errors
    /// That of copying the mechanics, and that of its step, with the force.
    fn end_under(&mut self, force: &[f64], end: &mut [f64]) -> Result<(), Failure>;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_of_trials_are_written_as_they_are_read_and_nonsense_is_refused() {
        let text = "range:0.1,tolerance:0.02,most:9,noise:0.0001";
        assert_eq!(text.parse::<TrialSettings>().unwrap().to_string(), text);
        for (text, valid) in [
            ("range:0", "above 0"),
            ("most:0", "from 1"),
            ("noise:-1", "from 0"),
            ("most:3,most:4", "at most once"),
            ("rnge:1", "did you mean `range`"),
        ] {
            let message = text.parse::<TrialSettings>().unwrap_err().to_string();
            assert!(message.contains(valid), "{message}");
        }
    }
}
