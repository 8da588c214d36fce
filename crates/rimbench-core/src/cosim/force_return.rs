//! Who goes first in a macro step, and what the mechanics then receives.

use super::subsystem::Side;
use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// The order of the two sides within a macro step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sequence {
    /// Both sides step from the same exchange, in parallel as far as the data go.
    Jacobi,
    /// `first` steps, its result is passed on, then the other side steps.
    GaussSeidel {
        /// The side that goes first.
        first: Side,
    },
}

impl fmt::Display for Sequence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Sequence::Jacobi => "jacobi",
            Sequence::GaussSeidel { first: Side::Actuator } => "gauss-seidel",
            Sequence::GaussSeidel { first: Side::Mechanics } => "gauss-seidel-mechanics-first",
        })
    }
}

impl FromStr for Sequence {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text {
            "jacobi" => Ok(Sequence::Jacobi),
            "gauss-seidel" => Ok(Sequence::GaussSeidel { first: Side::Actuator }),
            "gauss-seidel-mechanics-first" => Ok(Sequence::GaussSeidel { first: Side::Mechanics }),
            _ => Err(Error::unknown("sequence", text, ["jacobi", "gauss-seidel", "gauss-seidel-mechanics-first"])),
        }
    }
}

/// What the mechanics receives from the actuator for one macro step.
///
/// ```text
/// held     F(t_k), or the scheme's own extrapolation of it
/// end      F(t_{k+1})
/// mean     (1/H) Σ δ F_j                      the exact impulse
/// profile  (n_m/H) Σ δ F_j over each of the mechanics' n_m sub-steps: the impulse, and when it acted
/// ```
/// All but `held` need an actuator that went first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForceReturn {
    /// The scheme's prediction from past samples.
    Held,
    /// The fresh value at the end of the macro step.
    End,
    /// The mean over the macro step.
    Mean,
    /// The mean over each of the mechanics' sub-steps.
    Profile,
}

impl ForceReturn {
    /// All of them, by name.
    pub const ALL: [(&'static str, ForceReturn); 4] = [
        ("held", ForceReturn::Held),
        ("end", ForceReturn::End),
        ("mean", ForceReturn::Mean),
        ("profile", ForceReturn::Profile),
    ];

    /// Checks that a sequence can deliver this.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if the actuator does not go first and the return is not `held`.
    pub fn check(self, sequence: Sequence) -> Result<()> {
        if self == ForceReturn::Held || sequence == (Sequence::GaussSeidel { first: Side::Actuator }) {
            return Ok(());
        }
        Err(Error::Incompatible(format!(
            "force return `{self}` needs the actuator's forces over the same macro step, so the actuator must go \
             first: use sequence `gauss-seidel`, or force return `held` with `{sequence}`"
        )))
    }
}

impl fmt::Display for ForceReturn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, _) = ForceReturn::ALL[*self as usize];
        f.write_str(name)
    }
}

impl FromStr for ForceReturn {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let found = ForceReturn::ALL.iter().find(|(name, _)| *name == text);
        found
            .map(|(_, value)| *value)
            .ok_or_else(|| Error::unknown("force return", text, ForceReturn::ALL.iter().map(|(name, _)| *name)))
    }
}

/// The actuator's outputs over one macro step, handed to the mechanics as the force return says.
#[derive(Debug, Clone)]
pub(super) struct Transmission {
    width: usize,
    count: usize,
    /// Row j: output at the start of micro step j.
    outputs: Vec<f64>,
}

impl Transmission {
    pub(super) fn new(width: usize, micro_steps: usize) -> Self {
        Transmission { width, count: 0, outputs: vec![0.0; width * micro_steps] }
    }

    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    #[inline]
    pub(super) fn push(&mut self, output: &[f64]) {
        let at = self.count * self.width;
        self.outputs[at..at + self.width].copy_from_slice(output);
        self.count += 1;
    }

    /// Mean output over part `index` of `parts` equal parts of the macro step; micro steps that straddle a border
    /// count with the share that lies inside.
    pub(super) fn mean_over(&self, index: usize, parts: usize, mean: &mut [f64]) {
        mean.fill(0.0);
        // In units of 1/(count·parts) of the macro step all borders are integers.
        let (from, to) = (index * self.count, (index + 1) * self.count);
        for j in from / parts..self.count.min(to.div_ceil(parts)) {
            let overlap = to.min((j + 1) * parts) - from.max(j * parts);
            let weight = overlap as f64 / self.count as f64;
            for (sum, y) in mean.iter_mut().zip(&self.outputs[j * self.width..(j + 1) * self.width]) {
                *sum += weight * y;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_share_out_straddling_micro_steps_and_keep_the_impulse() {
        let mut transmission = Transmission::new(1, 3);
        for force in [1.0, 2.0, 6.0] {
            transmission.push(&[force]);
        }
        let mean = |index, parts| {
            let mut out = [0.0];
            transmission.mean_over(index, parts, &mut out);
            out[0]
        };
        approx::assert_relative_eq!(mean(0, 1), 3.0, epsilon = 1e-15);
        // Halves: (1 + ½·2)/1.5 and (½·2 + 6)/1.5.
        approx::assert_relative_eq!(mean(0, 2), 2.0 / 1.5, epsilon = 1e-15);
        approx::assert_relative_eq!(mean(1, 2), 7.0 / 1.5, epsilon = 1e-15);
        for parts in 1..8 {
            let total: f64 = (0..parts).map(|index| mean(index, parts)).sum();
            approx::assert_relative_eq!(total / parts as f64, 3.0, epsilon = 1e-14);
        }
    }

    #[test]
    fn only_an_actuator_that_went_first_can_return_more_than_the_held_force() {
        assert!(ForceReturn::Mean.check(Sequence::Jacobi).is_err());
        assert!(ForceReturn::Mean.check(Sequence::GaussSeidel { first: Side::Mechanics }).is_err());
        assert!(ForceReturn::Held.check(Sequence::Jacobi).is_ok());
        for (name, value) in ForceReturn::ALL {
            assert_eq!(name.parse::<ForceReturn>().unwrap(), value);
            assert_eq!(value.to_string(), name);
        }
    }
}
