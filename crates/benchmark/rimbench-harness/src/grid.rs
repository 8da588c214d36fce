//! The axes of an experiment's grid as its file gives them: macro steps, phases, values of parameters.

use rimbench_cases::cases::Case;
use rimbench_cases::parameter::Parameters;
use rimbench_core::error::{Error, Result};
use rimbench_runs::Given;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;

/// Most runs whose plan and tables are held in memory at once, some 3 kB for each run.
pub const MOST_RUNS: usize = 100_000;

/// Most runs of one experiment: one that has more than are held at once is planned part by part, and has no tables of
/// all its runs.
pub const MOST_PLANNED: usize = 1_000_000;

/// Runs of a part.
pub(super) const PART: usize = 10_000;

/// Macro steps one by one, or evenly spread in logarithms.
#[derive(Debug, Clone)]
pub(super) enum MacroSteps {
    /// H, s.
    List(Vec<f64>),
    Range(MacroStepRange),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MacroStepRange {
    /// Shortest, s.
    from: f64,
    /// Longest, s.
    to: f64,
    per_decade: usize,
}

/// What is valid, in words.
const MACRO_STEPS: &str =
    "a list of macro steps in s, [1e-3, 5e-3], or a range, { from = 1e-4, to = 1e-1, per_decade = 8 }";
const PHASES: &str = "a number of phases, 16, or a list of phases in (0, 1], [1.0, 0.5]";

/// Says what stands where something else is expected, without repeating what may be long.
fn unexpected<T, E: serde::de::Error>(found: &toml::Value, expected: &str) -> Result<T, E> {
    let found = if found.is_str() { "text" } else { found.type_str() };
    Err(E::custom(format!("a {found}, expected {expected}")))
}

/// Reads what stands in a file, so that a slip is told as what it is.
impl<'de> Deserialize<'de> for MacroSteps {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = toml::Value::deserialize(deserializer)?;
        let one = |step: f64| Err(D::Error::custom(format!("one macro step is a list of one: [{step:?}]")));
        match value {
            toml::Value::Array(_) => value.try_into().map(MacroSteps::List).map_err(D::Error::custom),
            toml::Value::Table(_) => value.try_into().map(MacroSteps::Range).map_err(D::Error::custom),
            toml::Value::Float(step) => one(step),
            toml::Value::Integer(step) => one(step as f64),
            other => unexpected(&other, MACRO_STEPS),
        }
    }
}

/// Reads what stands in a file, so that a slip is told as what it is.
impl<'de> Deserialize<'de> for Phases {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = toml::Value::deserialize(deserializer)?;
        let wrong = |message| Err(D::Error::custom(message));
        match value {
            toml::Value::Array(_) => value.try_into().map(Phases::List).map_err(D::Error::custom),
            toml::Value::Integer(count) => match usize::try_from(count) {
                Ok(count) => Ok(Phases::Count(count)),
                Err(_) => wrong(format!("a number of phases is not below 0: {count}")),
            },
            toml::Value::Float(phase) => {
                wrong(format!("one phase is a list of one, [{phase:?}]; a number of phases is whole"))
            }
            other => unexpected(&other, PHASES),
        }
    }
}

/// Returns the macro steps from `from` to `to` (s), `per_decade` to a decade, both ends included.
///
/// # Errors
/// [`Error::InvalidValue`] for an interval or density that makes no grid.
pub fn logarithmic_grid(from: f64, to: f64, per_decade: usize) -> Result<Vec<f64>> {
    if !(from.is_finite() && from > 0.0) {
        return Err(Error::invalid("from", from, "a finite time above 0 s"));
    }
    if !(to.is_finite() && to >= from) {
        return Err(Error::invalid("to", to, format!("a finite time, at least {from} s")));
    }
    if !(1..=1000).contains(&per_decade) {
        return Err(Error::invalid("per_decade", per_decade, "a whole number from 1 to 1000"));
    }
    let intervals = ((to / from).log10() * per_decade as f64).ceil().max(0.0);
    if intervals >= MOST_RUNS as f64 {
        return Err(Error::invalid("to", to, format!("at most {MOST_RUNS} macro steps between {from} s and it")));
    }
    let intervals = intervals as usize;
    if intervals == 0 {
        return Ok(vec![from]);
    }
    Ok((0..=intervals)
        .map(|index| if index == intervals { to } else { from * (to / from).powf(index as f64 / intervals as f64) })
        .collect())
}

impl MacroSteps {
    /// Checks what each step must be wherever it is used.
    ///
    /// # Errors
    /// [`Error::InvalidValue`], by the key of a file.
    pub(super) fn check(&self) -> Result<()> {
        let steps = self.list()?;
        let wrong = steps.iter().find(|step| !(step.is_finite() && **step > 0.0));
        wrong.map_or(Ok(()), |step| Err(Error::invalid("macro_steps_s", step, "finite times above 0 s")))
    }

    pub(super) fn list(&self) -> Result<Vec<f64>> {
        match self {
            MacroSteps::List(steps) => Ok(steps.clone()),
            MacroSteps::Range(range) => logarithmic_grid(range.from, range.to, range.per_decade)
                .map_err(|error| Error::Incompatible(format!("macro_steps_s: {error}"))),
        }
    }
}

/// A number of phases, or the phases themselves.
#[derive(Debug, Clone)]
pub(super) enum Phases {
    /// So many of the phase ensemble.
    Count(usize),
    /// In (0, 1].
    List(Vec<f64>),
}

impl Phases {
    /// The same for phases.
    pub(super) fn check(&self) -> Result<()> {
        let Phases::List(phases) = self else { return Ok(()) };
        let wrong = phases.iter().find(|phase| !(**phase > 0.0 && **phase <= 1.0));
        wrong.map_or(Ok(()), |phase| Err(Error::invalid("phases", format!("{phase:?}"), "numbers in (0, 1]")))
    }

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

/// Returns the first `count` members of the phase ensemble, a low-discrepancy set in (0, 1].
///
/// ```text
/// φ_j = 1 − frac(j (√5 − 1)/2),   j = 0 … count − 1
/// ```
/// The first member is 1: no shortened step.
pub fn phase_ensemble(count: usize) -> Vec<f64> {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    (0..count).map(|j| 1.0 - (j as f64 * golden).fract()).collect()
}

/// Counts the combinations of the values that are lists.
pub(super) fn points_of_grid(set: &BTreeMap<String, toml::Value>) -> usize {
    set.values().map(|value| values_of(value).len()).fold(1, usize::saturating_mul)
}

/// One combination of the values that are lists; that of the last key varies fastest.
pub(super) fn grid_point(case: &Case, set: &BTreeMap<String, toml::Value>, index: usize) -> Result<Parameters> {
    let mut parameters = case.default_parameters();
    let mut below = points_of_grid(set);
    for (key, value) in set {
        let values = values_of(value);
        below /= values.len();
        parameters.set(key, &scalar_text(key, &values[index / below % values.len()])?)?;
    }
    Ok(parameters)
}

/// The values of a key, of which there may be one.
fn values_of(value: &toml::Value) -> &[toml::Value] {
    match value {
        toml::Value::Array(values) => values.as_slice(),
        single => std::slice::from_ref(single),
    }
}

/// A TOML scalar as the value of an option; what is written without a point may be a count, or a number.
pub(super) fn scalar(key: &str, value: &toml::Value) -> Result<Given> {
    match value {
        toml::Value::String(text) => Ok(Given::from(text)),
        toml::Value::Integer(number) => Ok(Given::Text(number.to_string())),
        toml::Value::Float(number) => Ok(Given::from(*number)),
        toml::Value::Boolean(flag) => Ok(Given::Text(flag.to_string())),
        other => Err(Error::invalid(key, format!("<{}>", other.type_str()), "a number or a name")),
    }
}

/// The same as the text that `--set` would take.
pub(super) fn scalar_text(key: &str, value: &toml::Value) -> Result<String> {
    scalar(key, value).map(|value| value.to_string())
}
