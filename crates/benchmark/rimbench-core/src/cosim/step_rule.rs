//! How the length of the macro steps is found, and what it is to keep to.

use crate::error::{Error, Result};
use crate::name::by_name;

/// How what is found of a macro step is made into the length of the next. Nothing is taken back, and nothing is
/// exchanged for it.
///
/// ```text
/// audited    δE = sent − received as both sides count it         ε = |δE|/H / (tolerance · P_k),  P_k the largest mean power so far
///            σ = 0.8, ε held within [1e-3, 1e3]
/// published  r_i = |λ_{k+1} w_k − w_{k+1} λ_k| of each row       outputs at the end of the step, inputs that were held during it
///            ε = H √(mean r_i²) / (tolerance · 1 J + tolerance · H max r_i)               σ = 0.99
///            while ε or the one before is 0 the step stays as it is
/// defect     e = |K (s_model − s)| at t_{k+1},  K = −∂Ḟ/∂w     ε = max e_i / (tolerance · |F_i|),  |F_i| the largest force so far
///            σ = 1, ε held within [1e-3, 1e3]
///            H ← min(H, 1.05 τ)                              τ the time until a contact closes in the model, if that is looked at
/// all        H ← H σ ε^(−k_I−k_P) ε_before^(k_P),  k_I = 0.3/p, k_P = 0.4/p, by no less than 0.2 and no more than 1.5
/// ```
/// p is the power of H with which the error of one macro step falls: 2 for the energy residual, which makes k_I = 0.15
/// and k_P = 0.2, the gains of libcosim's examples; of the model's defect 3, or 2 where the mechanics' own step is of
/// the first order.
///
/// *published* is what libcosim's `ecco_algorithm` does, with the parameters of its quarter-truck example (one
/// tolerance for both of its two); the tolerance is the level at which the residual settles, and ε is at most one over
/// it. In *audited* the residual and its reference are ours.
/// # Source
/// open-simulation-platform/libcosim, `ecco_algorithm.cpp` as released in v0.11.0 (commit 5c2c7c14, March 2025), and
/// its test configuration.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum StepControl {
    /// The communication grid.
    #[default]
    None,
    /// *audited*: works counted by both sides.
    EnergyResidual,
    /// *published*: products of the last values, as in libcosim.
    EnergyResidualLibcosim,
    /// *defect*: the force by which the actuator goes astray because the scheme's model of the mechanics was not where
    /// the mechanics is.
    ModelDefect,
    /// The same, without a communication point just after the next closing of a contact that the model foresees.
    ModelDefectBlind,
}

impl StepControl {
    const NAMES: [(&'static str, StepControl); 5] = [
        ("none", StepControl::None),
        ("energy-residual", StepControl::EnergyResidual),
        ("energy-residual-libcosim", StepControl::EnergyResidualLibcosim),
        ("model-defect", StepControl::ModelDefect),
        ("model-defect-blind", StepControl::ModelDefectBlind),
    ];

    /// Tells whether the defect of the scheme's model sets the macro steps.
    pub fn by_defect(self) -> bool {
        matches!(self, StepControl::ModelDefect | StepControl::ModelDefectBlind)
    }
}

by_name!(StepControl, NAMES, "step control");

/// What controlled macro steps keep to. The first macro step of the grid is the first one here, its `H` is the longest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepRule {
    /// By what the length is found; not the grid.
    pub control: StepControl,
    /// Error allowed per macro step, a pure number: by the energy residual relative to the largest mean power that has
    /// crossed the interface in a macro step, by the model's defect to the largest force of each row so far.
    pub tolerance: f64,
    /// Shortest macro step, s. One this short is taken whatever its error; only the last one may be shorter.
    pub shortest: f64,
    /// Power p of H with which the error of one macro step falls.
    pub order: u32,
}

/// Shortest macro step unless another is asked for, as a part of H.
const SHORTEST: f64 = 1e-2;
/// What a tolerance is to be.
const TOLERANCE: &str = "a finite number above 0: the error allowed per macro step";
/// Power of H with which the energy residual of a macro step falls.
const RESIDUAL_ORDER: u32 = 2;

impl StepRule {
    /// Puts a rule together; none for the grid. `macro_step` is H (s), which is the longest; the shortest step is H/100
    /// unless one is given.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a tolerance that is missing or not above 0, or a shortest step outside (0, H];
    /// [`Error::Incompatible`] for a tolerance or a shortest step with nothing to control.
    pub fn new(
        control: StepControl,
        tolerance: Option<f64>,
        shortest: Option<f64>,
        macro_step: f64,
    ) -> Result<Option<Self>> {
        if control == StepControl::None {
            let idle = tolerance.map(|_| "step_tolerance").or(shortest.map(|_| "min_macro_step_s"));
            return idle.map_or(Ok(None), |key| {
                Err(Error::Incompatible(format!(
                    "{key} is given but nothing controls the step: add step_control = \"energy-residual\", \
                     \"energy-residual-libcosim\" or \"model-defect\""
                )))
            });
        }
        let missing =
            || Error::Incompatible(format!("step_control = {control} lacks step_tolerance; valid: {TOLERANCE}"));
        let tolerance = tolerance.ok_or_else(missing)?;
        let shortest = shortest.unwrap_or(SHORTEST * macro_step);
        let rule = StepRule { control, tolerance, shortest, order: RESIDUAL_ORDER };
        rule.check(macro_step).map(|()| Some(rule))
    }

    /// Checks tolerance and shortest step against the macro step H (s), which is the longest.
    ///
    /// # Errors
    /// [`Error::InvalidValue`].
    pub fn check(&self, macro_step: f64) -> Result<()> {
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            return Err(Error::invalid("step_tolerance", self.tolerance, TOLERANCE));
        }
        if !(self.shortest.is_finite() && self.shortest > 0.0) {
            return Err(Error::invalid("min_macro_step_s", self.shortest, "a finite time above 0 s"));
        }
        if self.shortest > macro_step {
            let expected = format!("at most the macro step, {macro_step} s, which is the longest");
            return Err(Error::invalid("min_macro_step_s", self.shortest, expected));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_refused_with_the_key_and_what_is_valid() {
        use StepControl::{EnergyResidual, EnergyResidualLibcosim, ModelDefect, ModelDefectBlind, None as Grid};
        let new = |kind, tolerance, shortest| StepRule::new(kind, tolerance, shortest, 1e-2);
        let refused = |control: Result<Option<StepRule>>| control.unwrap_err().to_string();
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
        let message = "modeldefect".parse::<StepControl>().unwrap_err().to_string();
        assert!(message.contains("did you mean `model-defect`"), "{message}");
        assert_eq!(new(Grid, None, None).unwrap(), None);
        let rule = StepRule { control: EnergyResidual, tolerance: 1e-3, shortest: 1e-4, order: 2 };
        assert_eq!(new(EnergyResidual, Some(1e-3), None).unwrap(), Some(rule));
        for kind in [Grid, EnergyResidual, EnergyResidualLibcosim, ModelDefect, ModelDefectBlind] {
            assert_eq!(kind.to_string().parse::<StepControl>().unwrap(), kind);
        }
    }
}
