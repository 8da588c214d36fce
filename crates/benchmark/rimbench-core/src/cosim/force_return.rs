//! The order of the sides in a macro step, and the force that the mechanics then receives.

use super::side::Side;
use crate::error::{Error, Result};
use crate::name::by_name;
use std::fmt;
use std::str::FromStr;

/// The order of the two sides within a macro step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sequence {
    /// Both sides step from one exchange, in parallel as far as the data go.
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

/// The force that the mechanics receives from the actuator for one macro step.
///
/// ```text
/// held     F(t_k), or the scheme's own extrapolation of it
/// end      F(t_{k+1})
/// mean     (1/H) Σ δ F_j                      the exact impulse
/// profile  (n_m/H) Σ δ F_j over each of the mechanics' n_m sub-steps: the impulse, and when it acted
/// pieces   the mean over each piece of a sub-step that the mechanics splits at events
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
    /// The mean over each piece of the mechanics' sub-steps, which it must split at events.
    Pieces,
}

impl ForceReturn {
    /// All of them, by name.
    pub const ALL: [(&'static str, ForceReturn); 5] = [
        ("held", ForceReturn::Held),
        ("end", ForceReturn::End),
        ("mean", ForceReturn::Mean),
        ("profile", ForceReturn::Profile),
        ("pieces", ForceReturn::Pieces),
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

by_name!(ForceReturn, ALL, "force return");
