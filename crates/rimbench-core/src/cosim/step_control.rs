//! How the macro step follows what a run finds, as an option of a run with any scheme.

use crate::error::{Error, Result};
use std::fmt;

/// How the length of the macro steps is found.
///
/// ```text
/// none             t_k of the communication grid
/// energy-residual  H_{k+1} = H_k σ ε_k^(−k_I−k_P) ε_{k−1}^(k_P)                      no step is ever taken back
/// step-doubling    one step H against two of H/2, both on copies; H ← 0.9 H ε^(−1/(p+1))  taken back where ε > 1
/// ```
/// `ε` is an error in units of what the rule allows; see [`StepRule`]. The first macro step of the grid is the first one
/// here, its `H` is the longest.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum StepControl {
    /// The communication grid.
    #[default]
    None,
    /// By the power residual of the interface (ECCO).
    EnergyResidual(StepRule),
    /// By comparing one step with two halves.
    StepDoubling(StepRule),
}

/// What a step control is to keep to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepRule {
    /// Error allowed per macro step, a pure number: for `energy-residual` relative to the largest mean power that has
    /// crossed the interface in a macro step, for `step-doubling` relative to the largest value that each coupling variable
    /// has had.
    pub tolerance: f64,
    /// Shortest macro step, s. One this short is taken whatever its error; only the last one may be shorter.
    pub shortest: f64,
    /// Order p of the scheme in H: how the error of `step-doubling` falls, `H^(p+1)`.
    pub order: u32,
}

/// Shortest macro step unless another is asked for, as a part of H.
const SHORTEST: f64 = 1e-2;

impl StepControl {
    /// The names in data.
    pub const NAMES: [&'static str; 3] = ["none", "energy-residual", "step-doubling"];

    /// Builds a step control by name. `macro_step` is H (s); the shortest step is H/100 unless one is given.
    ///
    /// # Errors
    /// [`Error::UnknownName`]; [`Error::InvalidValue`] for a tolerance that is missing or not above 0, or a shortest step
    /// outside (0, H]; [`Error::Incompatible`] for a tolerance or a shortest step with nothing to control.
    pub fn new(
        name: Option<&str>,
        tolerance: Option<f64>,
        shortest: Option<f64>,
        macro_step: f64,
        order: u32,
    ) -> Result<Self> {
        let build = match name.unwrap_or("none") {
            "none" => {
                let idle = tolerance.map(|_| "step_tolerance").or(shortest.map(|_| "min_macro_step_s"));
                return idle.map_or(Ok(StepControl::None), |key| {
                    Err(Error::Incompatible(format!(
                        "{key} is given but nothing controls the step: add step_control = \"energy-residual\" or \
                         \"step-doubling\""
                    )))
                });
            }
            "energy-residual" => StepControl::EnergyResidual,
            "step-doubling" => StepControl::StepDoubling,
            other => return Err(Error::unknown("step control", other, Self::NAMES)),
        };
        let expected = "a finite number above 0: the error allowed per macro step";
        let tolerance = tolerance.ok_or_else(|| Error::invalid("step_tolerance", "nothing", expected))?;
        let control = build(StepRule { tolerance, shortest: shortest.unwrap_or(SHORTEST * macro_step), order });
        control.check(macro_step)?;
        Ok(control)
    }

    /// Checks tolerance and shortest step against the macro step H (s), which is the longest.
    ///
    /// # Errors
    /// [`Error::InvalidValue`].
    pub fn check(&self, macro_step: f64) -> Result<()> {
        let Some(rule) = self.rule() else { return Ok(()) };
        if !(rule.tolerance.is_finite() && rule.tolerance > 0.0) {
            let expected = "a finite number above 0: the error allowed per macro step";
            return Err(Error::invalid("step_tolerance", rule.tolerance, expected));
        }
        if !(rule.shortest.is_finite() && rule.shortest > 0.0) {
            return Err(Error::invalid("min_macro_step_s", rule.shortest, "a finite time above 0 s"));
        }
        if rule.shortest > macro_step {
            let expected = format!("at most the macro step, {macro_step} s, which is the longest");
            return Err(Error::invalid("min_macro_step_s", rule.shortest, expected));
        }
        Ok(())
    }

    /// What is to be kept to, if anything is controlled.
    pub fn rule(&self) -> Option<&StepRule> {
        match self {
            StepControl::None => None,
            StepControl::EnergyResidual(rule) | StepControl::StepDoubling(rule) => Some(rule),
        }
    }
}

impl fmt::Display for StepControl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            StepControl::None => Self::NAMES[0],
            StepControl::EnergyResidual(_) => Self::NAMES[1],
            StepControl::StepDoubling(_) => Self::NAMES[2],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_refused_with_the_key_and_what_is_valid() {
        let new = |name, tolerance, shortest| StepControl::new(name, tolerance, shortest, 1e-2, 1);
        let refused = |control: Result<StepControl>| control.unwrap_err().to_string();
        for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(refused(new(Some("step-doubling"), Some(tolerance), None)).contains("step_tolerance"));
        }
        for shortest in [0.0, -1e-3, f64::NAN, 2e-2] {
            let message = refused(new(Some("energy-residual"), Some(1e-2), Some(shortest)));
            assert!(message.contains("min_macro_step_s"), "{message}");
        }
        assert!(refused(new(Some("energy-residual"), None, None)).contains("step_tolerance = nothing"));
        assert!(refused(new(None, Some(1e-3), None)).contains("nothing controls the step"));
        assert!(refused(new(Some("none"), None, Some(1e-3))).contains("min_macro_step_s"));
        assert!(refused(new(Some("stepdoubling"), Some(1e-3), None)).contains("did you mean `step-doubling`"));
        assert_eq!(new(None, None, None).unwrap(), StepControl::None);
        let rule = *new(Some("step-doubling"), Some(1e-3), None).unwrap().rule().unwrap();
        assert_eq!(rule, StepRule { tolerance: 1e-3, shortest: 1e-4, order: 1 });
    }
}
