//! How the macro step follows what a run finds, as an option of a run with any scheme.

use rimbench_core::cosim::{ErrorEstimator, StepRule};
use rimbench_core::error::{Error, Result};
use rimbench_core::name::by_name;

/// By what the length of the macro steps is found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum StepControlKind {
    /// The communication grid.
    #[default]
    None,
    /// The power residual of the interface (ECCO), as the energy audit counts it.
    EnergyResidual,
    /// The same as libcosim has it.
    EnergyResidualLibcosim,
    /// By how much the scheme's model of the mechanics was wrong, and by what it says will close.
    ModelDefect,
    /// The same, but blind to what will close.
    ModelDefectBlind,
}

impl StepControlKind {
    const NAMES: [(&'static str, StepControlKind); 5] = [
        ("none", StepControlKind::None),
        ("energy-residual", StepControlKind::EnergyResidual),
        ("energy-residual-libcosim", StepControlKind::EnergyResidualLibcosim),
        ("model-defect", StepControlKind::ModelDefect),
        ("model-defect-blind", StepControlKind::ModelDefectBlind),
    ];
}

by_name!(StepControlKind, NAMES, "step control");

/// How the length of the macro steps is found, and what it is to keep to.
///
/// ```text
/// none             t_k of the communication grid
/// energy-residual  H_{k+1} = H_k σ ε_k^(−k_I−k_P) ε_{k−1}^(k_P)                      no step is ever taken back
/// model-defect     the same with k_I, k_P by the order of the defect, σ = 1; just after closings    the same
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
    /// By how much the scheme's model of the mechanics was wrong.
    ModelDefect {
        /// What it is to keep to; `controller` is found when the run begins.
        rule: StepRule,
        /// Whether a communication point is placed just after a closing that the model foresees.
        closings: bool,
    },
}

/// Shortest macro step unless another is asked for, as a part of H.
const SHORTEST: f64 = 1e-2;

impl StepControl {
    /// Puts a step control together. `macro_step` is H (s); the shortest step is H/100 unless one is given.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a tolerance that is missing or not above 0, or a shortest step outside (0, H];
    /// [`Error::Incompatible`] for a tolerance or a shortest step with nothing to control.
    pub fn new(kind: StepControlKind, tolerance: Option<f64>, shortest: Option<f64>, macro_step: f64) -> Result<Self> {
        let build = match kind {
            StepControlKind::None => {
                let idle = tolerance.map(|_| "step_tolerance").or(shortest.map(|_| "min_macro_step_s"));
                return idle.map_or(Ok(StepControl::None), |key| {
                    Err(Error::Incompatible(format!(
                        "{key} is given but nothing controls the step: add step_control = \"energy-residual\", \
                         \"energy-residual-libcosim\" or \"model-defect\""
                    )))
                });
            }
            StepControlKind::EnergyResidual | StepControlKind::EnergyResidualLibcosim => StepControl::EnergyResidual,
            StepControlKind::ModelDefect => |rule| StepControl::ModelDefect { rule, closings: true },
            StepControlKind::ModelDefectBlind => |rule| StepControl::ModelDefect { rule, closings: false },
        };
        let expected = "a finite number above 0: the error allowed per macro step";
        let missing = || Error::Incompatible(format!("step_control = {kind} lacks step_tolerance; valid: {expected}"));
        let tolerance = tolerance.ok_or_else(missing)?;
        let controller = match kind {
            StepControlKind::EnergyResidualLibcosim => ErrorEstimator::Published,
            _ => ErrorEstimator::Audited,
        };
        let rule = StepRule { tolerance, shortest: shortest.unwrap_or(SHORTEST * macro_step), controller };
        rule.check(macro_step)?;
        Ok(build(rule))
    }

    /// Says which one it is.
    pub fn kind(&self) -> StepControlKind {
        match self {
            StepControl::None => StepControlKind::None,
            StepControl::EnergyResidual(rule) => match rule.controller {
                ErrorEstimator::Published => StepControlKind::EnergyResidualLibcosim,
                _ => StepControlKind::EnergyResidual,
            },
            StepControl::ModelDefect { closings: true, .. } => StepControlKind::ModelDefect,
            StepControl::ModelDefect { closings: false, .. } => StepControlKind::ModelDefectBlind,
        }
    }

    /// Says what is to be kept to, if anything is controlled.
    pub fn rule(&self) -> Option<&StepRule> {
        match self {
            StepControl::None => None,
            StepControl::EnergyResidual(rule) | StepControl::ModelDefect { rule, .. } => Some(rule),
        }
    }

    /// What the macro loop is to keep to, where the defect of the scheme's model falls with H to the power `order`.
    pub(super) fn step_rule(&self, order: u32) -> Option<StepRule> {
        match self {
            StepControl::EnergyResidual(rule) => Some(*rule),
            StepControl::ModelDefect { rule, closings } => {
                let controller = ErrorEstimator::ModelDefect { order, closings: *closings };
                Some(StepRule { controller, ..*rule })
            }
            StepControl::None => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_refused_with_the_key_and_what_is_valid() {
        use StepControlKind::{EnergyResidual, EnergyResidualLibcosim, ModelDefect, ModelDefectBlind, None as Grid};
        let new = |kind, tolerance, shortest| StepControl::new(kind, tolerance, shortest, 1e-2);
        let refused = |control: Result<StepControl>| control.unwrap_err().to_string();
        for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(refused(new(EnergyResidual, Some(tolerance), None)).contains("step_tolerance"));
        }
        for shortest in [0.0, -1e-3, f64::NAN, 2e-2] {
            let message = refused(new(EnergyResidual, Some(1e-2), Some(shortest)));
            assert!(message.contains("min_macro_step_s"), "{message}");
        }
        assert!(refused(new(EnergyResidual, None, None)).contains("lacks step_tolerance"));
        assert!(refused(new(Grid, Some(1e-3), None)).contains("nothing controls the step"));
        assert!(refused(new(Grid, None, Some(1e-3))).contains("min_macro_step_s"));
        let message = "modeldefect".parse::<StepControlKind>().unwrap_err().to_string();
        assert!(message.contains("did you mean `model-defect`"), "{message}");
        assert_eq!(new(Grid, None, None).unwrap(), StepControl::None);
        let rule = *new(EnergyResidual, Some(1e-3), None).unwrap().rule().unwrap();
        assert_eq!(rule, StepRule { tolerance: 1e-3, shortest: 1e-4, controller: ErrorEstimator::Audited });
        for kind in [Grid, EnergyResidual, EnergyResidualLibcosim, ModelDefect, ModelDefectBlind] {
            assert_eq!(kind.to_string().parse::<StepControlKind>().unwrap(), kind);
        }
    }
}
