//! The tolerance of macro steps, and the rule by which their length is found.

use crate::error::{Error, Result};

/// The tolerance of controlled macro steps, and their rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepRule {
    /// Error allowed per macro step, a pure number: by the energy residual relative to the largest mean power that has crossed the
    /// interface in a macro step, by the model's defect to the largest force of each row so far.
    pub tolerance: f64,
    /// Shortest macro step, s. One this short is taken whatever its error; only the last one may be shorter.
    pub shortest: f64,
    /// The estimate that is made into a step, and how.
    pub controller: ErrorEstimator,
}

/// How what is found of a macro step is made into the length of the next. Nothing is taken back, and nothing is exchanged for it.
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
/// p is the power of H with which the error of one macro step falls: 2 for the energy residual, which makes k_I = 0.15 and k_P = 0.2, the
/// gains of libcosim's examples; of the model's defect 3, or 2 where the mechanics' own step is of the first order.
///
/// *published* is what libcosim's `ecco_algorithm` does, with the parameters of its quarter-truck example (one tolerance for both
/// of its two); the tolerance is the level at which the residual settles, and ε is at most one over it. In *audited* the residual and its reference are ours.
/// # Source
/// open-simulation-platform/libcosim, `ecco_algorithm.cpp` as released in v0.11.0 (commit 5c2c7c14, March 2025), and its test configuration.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ErrorEstimator {
    /// Works counted by both sides.
    #[default]
    Audited,
    /// Products of the last values, as in libcosim.
    Published,
    /// The force by which the actuator goes astray because the scheme's model of the mechanics was not where the mechanics is.
    ModelDefect {
        /// Power of H with which it falls.
        order: u32,
        /// Whether a communication point is placed just after the next closing of a contact that the model foresees.
        closings: bool,
    },
}

impl StepRule {
    /// Checks tolerance and shortest step against the macro step H (s), which is the longest.
    ///
    /// # Errors
    /// [`Error::InvalidValue`].
    pub fn check(&self, macro_step: f64) -> Result<()> {
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            let expected = "a finite number above 0: the error allowed per macro step";
            return Err(Error::invalid("step_tolerance", self.tolerance, expected));
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

    /// Tells whether the defect of the scheme's model sets the macro steps.
    pub(crate) fn by_defect(&self) -> bool {
        matches!(self.controller, ErrorEstimator::ModelDefect { .. })
    }
}
