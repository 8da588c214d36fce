//! The axes of an experiment's grid as its file gives them: macro steps, phases, values of parameters.

use super::stability::logarithmic_grid;
use rimbench_cases::cases::{Case, Parameters};
use rimbench_core::error::{Error, Result};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Macro steps one by one, or evenly spread in logarithms.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum MacroSteps {
    List(Vec<f64>),
    Range(MacroStepRange),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MacroStepRange {
    from: f64,
    to: f64,
    per_decade: usize,
}

impl MacroSteps {
    pub(super) fn list(&self) -> Result<Vec<f64>> {
        match self {
            MacroSteps::List(steps) => Ok(steps.clone()),
            MacroSteps::Range(range) => logarithmic_grid(range.from, range.to, range.per_decade)
                .map_err(|error| Error::Incompatible(format!("macro_steps_s: {error}"))),
        }
    }
}

/// A number of phases, or the phases themselves.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum Phases {
    Count(usize),
    List(Vec<f64>),
}

impl Phases {
    pub(super) fn count(&self) -> usize {
        match self {
            Phases::Count(count) => *count,
            Phases::List(phases) => phases.len(),
        }
    }

    pub(super) fn list(&self) -> Vec<f64> {
        match self {
            Phases::Count(count) => phase_ensemble(*count),
            Phases::List(phases) => phases.clone(),
        }
    }
}

pub(super) fn one_phase() -> Phases {
    Phases::Count(1)
}

/// The first `count` members of the phase ensemble, a low-discrepancy set in (0, 1].
///
/// ```text
/// φ_j = 1 − frac(j (√5 − 1)/2),   j = 0 … count − 1
/// ```
/// The first member is 1: no shortened step.
pub fn phase_ensemble(count: usize) -> Vec<f64> {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    (0..count).map(|j| 1.0 - (j as f64 * golden).fract()).collect()
}

/// Every combination of the values that are lists.
pub(super) fn parameter_grid(case: &Case, set: &BTreeMap<String, toml::Value>) -> Result<Vec<Parameters>> {
    let mut grid = vec![case.default_parameters()];
    for (key, value) in set {
        let values = match value {
            toml::Value::Array(values) => values.as_slice(),
            single => std::slice::from_ref(single),
        };
        let mut next = Vec::with_capacity(grid.len() * values.len());
        for parameters in &grid {
            for value in values {
                let mut changed = parameters.clone();
                changed.set(key, &scalar_text(key, value)?)?;
                next.push(changed);
            }
        }
        grid = next;
    }
    Ok(grid)
}

/// A TOML scalar as the text that `--set` would take.
pub(super) fn scalar_text(key: &str, value: &toml::Value) -> Result<String> {
    match value {
        toml::Value::String(text) => Ok(text.clone()),
        toml::Value::Integer(number) => Ok(number.to_string()),
        toml::Value::Float(number) => Ok(format!("{number:?}")),
        toml::Value::Boolean(flag) => Ok(flag.to_string()),
        other => Err(Error::invalid(key, format!("<{}>", other.type_str()), "a number or a name")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_phase_ensemble_starts_at_one_and_spreads() {
        let phases = phase_ensemble(16);
        assert_eq!(phases[0], 1.0);
        assert!(phases.iter().all(|phase| *phase > 0.0 && *phase <= 1.0));
        let mut sorted = phases.clone();
        sorted.sort_by(f64::total_cmp);
        let largest_hole = sorted.windows(2).map(|pair| pair[1] - pair[0]).fold(sorted[0], f64::max);
        assert!(largest_hole < 2.0 / 16.0 * 1.2, "{largest_hole}");
    }
}
