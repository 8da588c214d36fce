//! What a claim says.

use rimbench_core::error::Error;
use rimbench_results::budget::way_of;
use rimbench_results::claims::{Claimant, Verdict};
use rimbench_results::selection::ALL;
use rimbench_runs::Finding;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::fmt;

/// Relative slack when a macro step of a claim is looked up among those of the runs.
const SAME_STEP: f64 = 1e-9;

/// One claim of an experiment file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Short name.
    pub id: String,
    /// Who claims it.
    pub by: Claimant,
    /// The claim in words.
    pub text: String,
    /// The case it is about, by name; `all` of several, which must be said.
    pub(crate) case: Option<String>,
    /// The set of parameters it is about, as in the column `set` of `runs.csv`, or words that several have in common;
    /// `all` of several, which must be said.
    pub(crate) set: Option<String>,
    /// Label of the scheme row it is about.
    pub(crate) scheme: String,
    /// Label of another scheme row. Measured is then the factor between the two in each case, set and macro step, of
    /// which the statistic is taken; or the ratio of their shares, where runs are counted.
    pub(crate) relative_to: Option<String>,
    /// A counter by name: the ratio to the other scheme row is then that at equal counts, case by case. Or budgets: it is
    /// then that of the best forms of two ways of coupling within each.
    pub(crate) at_equal: Option<AtEqual>,
    /// Within a budget: labels with this word in them are left out.
    pub(crate) without: Option<String>,
    /// The macro step it is about; all of them if absent.
    pub(crate) macro_step_s: Option<f64>,
    /// A metric by name, of which what may be below 0 is compared by its magnitude; or how runs end.
    #[serde(deserialize_with = "subject")]
    pub(crate) metric: Finding,
    /// Counts runs: the value is 1 where the metric is above this, else 0.
    pub(crate) above: Option<f64>,
    /// Counts usable runs: the value is 1 where a run completed and the magnitude of the metric is at most this,
    /// else 0.
    pub(crate) within: Option<f64>,
    /// What to make of several runs.
    #[serde(default)]
    pub(crate) statistic: Statistic,
    /// Of a share of settings: those whose two errors differ by no more than this share are ties.
    pub(crate) apart: Option<f64>,
    /// Whether runs that failed are witnesses, where the claim says so.
    pub(crate) witnesses: Option<Witnesses>,
    /// A comparison with a number, for example `>= 2`.
    pub(crate) expect: Expectation,
    /// What was found when the experiment was last looked at.
    pub finding: Verdict,
    /// Why the claim has been replaced by another, if it has: it is kept, and measured, all the same.
    #[serde(default)]
    pub(crate) superseded: String,
    /// The claim, by id, of which this one is a variant: it says the same of another phase, statistic or option. It is
    /// measured all the same, and statements are counted once.
    #[serde(default)]
    pub(crate) variant_of: String,
    /// Whether numbers of such runs were known when its bound was set, from a trial or from earlier runs.
    #[serde(default)]
    pub(crate) numbers_known: bool,
}

/// At what two rows are compared, if not at equal macro steps.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "toml::Value")]
pub(crate) enum AtEqual {
    /// A count of work.
    Counter(Finding),
    /// Communication points and mechanics steps, each per second.
    Budgets(Vec<[f64; 2]>),
}

impl TryFrom<toml::Value> for AtEqual {
    type Error = Error;

    fn try_from(value: toml::Value) -> Result<Self, Error> {
        let toml::Value::Array(mut pairs) = value else {
            let name = value.as_str().map_or_else(|| format!("{value:?}"), str::to_owned);
            return Finding::among("counter", &name, Finding::counters()).map(AtEqual::Counter);
        };
        if pairs.iter().all(|value| !value.is_array()) {
            pairs = vec![toml::Value::Array(pairs)];
        }
        let found = toml::Value::Array(pairs);
        let is_budget = |pair: &[f64; 2]| pair.iter().all(|count| count.is_finite() && *count > 0.0);
        let budgets: Option<Vec<[f64; 2]>> = found.clone().try_into().ok();
        budgets.filter(|budgets| !budgets.is_empty() && budgets.iter().all(is_budget)).map(AtEqual::Budgets).ok_or_else(
            || {
                let valid =
                    "a counter, or exchanges and mechanics steps per second, as [200, 1000], or a list of such pairs";
                Error::invalid("at_equal", format!("{found:?}"), valid)
            },
        )
    }
}

/// Which runs a claim on a metric asks, where it says so itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Witnesses {
    /// Those that completed, whatever became of the others.
    Completed,
    /// Those that failed too, with what they had come to by then.
    All,
}

/// What to make of several runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Statistic {
    #[default]
    Median,
    Min,
    Max,
    Mean,
    /// Slope of the median over phases against the macro step, in logarithms.
    Order,
    /// Share of the settings in which the median over phases is less than that of `relative_to`.
    ShareBetter,
    /// Share of the runs for which a single macro step tells whether they complete, chosen after the fact: the baseline
    /// of a prediction. The metric says which runs count: those that have it.
    OneThreshold,
    /// The same with a macro step for each case.
    ThresholdPerCase,
}

impl Statistic {
    /// Whether it is about completion, of the runs that have the metric.
    pub(crate) fn is_threshold(self) -> bool {
        matches!(self, Statistic::OneThreshold | Statistic::ThresholdPerCase)
    }
}

/// A comparison with a number.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub(crate) struct Expectation {
    pub(crate) at_least: bool,
    pub(crate) bound: f64,
}

impl Expectation {
    /// Tells whether a value is as expected.
    pub(crate) fn admits(self, value: f64) -> bool {
        if self.at_least { value >= self.bound } else { value <= self.bound }
    }
}

impl TryFrom<String> for Expectation {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let parsed = [(">=", true), ("<=", false)].into_iter().find_map(|(sign, at_least)| {
            let bound: f64 = text.trim().strip_prefix(sign)?.trim().parse().ok()?;
            bound.is_finite().then_some(Expectation { at_least, bound })
        });
        parsed.ok_or_else(|| {
            format!("expect = \"{text}\" is no comparison; valid: \">= number\" or \"<= number\", the number finite")
        })
    }
}

impl fmt::Display for Expectation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", if self.at_least { "≥" } else { "≤" }, self.bound)
    }
}

/// Reads what a claim is about: a metric, or how runs end.
fn subject<'de, D: Deserializer<'de>>(from: D) -> Result<Finding, D::Error> {
    let all = Finding::metrics().chain(Finding::ENDS);
    Finding::among("metric of a claim", &String::deserialize(from)?, all).map_err(D::Error::custom)
}

impl AtEqual {
    /// The counter, if it is one.
    pub(crate) fn counter(&self) -> Option<Finding> {
        if let AtEqual::Counter(counter) = self { Some(*counter) } else { None }
    }
}

impl fmt::Display for AtEqual {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AtEqual::Counter(counter) => f.write_str(counter.name()),
            AtEqual::Budgets(budgets) => {
                let words = budgets
                    .iter()
                    .map(|[points, steps]| format!("{points} exchanges and {steps} mechanics steps per s"));
                f.write_str(&words.collect::<Vec<_>>().join("; "))
            }
        }
    }
}

impl Claim {
    /// The budgets within which the best forms of two ways are compared, if that is what is done.
    pub(crate) fn budgets(&self) -> Option<&[[f64; 2]]> {
        if let Some(AtEqual::Budgets(budgets)) = &self.at_equal { Some(budgets) } else { None }
    }

    /// Whether a label is that of a row it names: within budgets it names ways, or all.
    pub(crate) fn names(&self, named: &str, label: &str) -> bool {
        match self.budgets() {
            None => label == named,
            Some(_) => named == ALL || way_of(label) == named,
        }
    }

    /// Whether values that may be below 0 count by their magnitude: wherever they are held against others.
    pub(crate) fn is_by_magnitude(&self) -> bool {
        let compares = matches!(self.statistic, Statistic::Order | Statistic::ShareBetter);
        self.metric.metric().is_some_and(|metric| metric.signed) && (compares || self.relative_to.is_some())
    }

    /// Whether it is about factors between two rows, one for each case with its set and macro step, or one for each
    /// case with its set at equal counts.
    pub(crate) fn is_about_ratios(&self) -> bool {
        let of_ratios = matches!(self.statistic, Statistic::Median | Statistic::Min | Statistic::Max | Statistic::Mean);
        self.relative_to.is_some() && of_ratios && self.above.is_none() && !self.counts_ends()
    }

    /// Whether it is about how runs end.
    pub(crate) fn is_about_ends(&self) -> bool {
        Finding::ENDS.contains(&self.metric)
    }

    /// Whether it counts runs by how they end, so that one that failed says as much as one that completed.
    pub(crate) fn counts_ends(&self) -> bool {
        self.is_about_ends()
            || self.within.is_some()
            || self.statistic.is_threshold()
            || self.metric.metric().is_some_and(|metric| metric.ends)
    }

    /// Whether it is about zeros and ones, so that a mean is a share.
    pub(crate) fn is_a_share(&self) -> bool {
        self.within.is_some() || self.above.is_some() || matches!(self.metric, Finding::Completed | Finding::Failed)
    }

    /// Whether it is about runs at a macro step (s).
    pub(crate) fn is_about(&self, macro_step: f64) -> bool {
        self.macro_step_s.is_none_or(|wanted| (macro_step / wanted - 1.0).abs() < SAME_STEP)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_expectation_is_a_comparison_or_an_error() {
        assert_eq!(Expectation::try_from(">= 2".to_owned()), Ok(Expectation { at_least: true, bound: 2.0 }));
        for text in ["about 2", ">= nan", "<= inf", ">= -inf", ">=", "> 2"] {
            assert!(Expectation::try_from(text.to_owned()).unwrap_err().contains("valid"), "{text}");
        }
    }
}
