//! Claims: what an experiment file says should come out, held against what did.

use super::experiment::{Experiment, PlannedRun};
use rimbench_cases::metrics::METRICS;
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::ResultsTable;
use rimbench_statistics::{median, order_of_convergence};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

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
    /// Label of the scheme row it is about.
    scheme: String,
    /// Label of another scheme row; the measured value is then the ratio of the two.
    relative_to: Option<String>,
    /// The macro step it is about; all of them if absent.
    macro_step_s: Option<f64>,
    /// A metric by name, or `diverged` (1 or 0), or `diverged_at_s`.
    metric: String,
    /// What to make of several runs.
    #[serde(default)]
    statistic: Statistic,
    /// A comparison with a number, for example `>= 2`.
    expect: Expectation,
    /// What was found when the experiment was last looked at.
    pub finding: Verdict,
}

/// Who makes a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Claimant {
    /// The source paper.
    Paper,
    /// This project.
    Ours,
}

/// What to make of several runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Statistic {
    #[default]
    Median,
    Min,
    Max,
    Mean,
    /// Slope of the median over phases against the macro step, in logarithms.
    Order,
}

/// What came of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The expectation holds.
    Reproduced,
    /// It does not.
    NotReproduced,
    /// The runs it is about are not part of this plan (a quick one), or the metric does not apply to them.
    NotMeasured,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Reproduced => "reproduced",
            Verdict::NotReproduced => "not reproduced",
            Verdict::NotMeasured => "not measured",
        })
    }
}

/// A comparison with a number.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "String")]
struct Expectation {
    at_least: bool,
    bound: f64,
}

impl TryFrom<String> for Expectation {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let parsed = [(">=", true), ("<=", false)].into_iter().find_map(|(sign, at_least)| {
            let bound = text.trim().strip_prefix(sign)?.trim().parse().ok()?;
            Some(Expectation { at_least, bound })
        });
        parsed.ok_or_else(|| format!("expect = \"{text}\" is no comparison; valid: \">= number\" or \"<= number\""))
    }
}

impl fmt::Display for Expectation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", if self.at_least { "≥" } else { "≤" }, self.bound)
    }
}

/// A claim with what was measured.
#[derive(Debug, Clone, Serialize)]
pub struct CheckedClaim {
    /// Experiment the claim stands in.
    pub experiment: String,
    /// Short name.
    pub id: String,
    /// Who claims it.
    pub by: Claimant,
    /// The claim in words.
    pub text: String,
    /// Metric and statistic.
    pub quantity: String,
    /// What was measured.
    pub measured: Option<f64>,
    /// What was expected.
    pub expected: String,
    /// Whether it holds.
    pub verdict: Verdict,
    /// What was found when the experiment was last looked at.
    pub finding: Verdict,
    /// The runs it rests on.
    pub run_ids: String,
}

/// Quantities of a claim besides the metrics.
const OUTCOMES: [&str; 2] = ["diverged", "diverged_at_s"];

/// Checks all claims of an experiment against the `runs.csv` in its results folder. Claims about macro steps that are not
/// there, as after a quick run, come back as not measured.
///
/// # Errors
/// [`Error::File`] if there is no such file.
pub fn check_claims(experiment: &Experiment, folder: &Path) -> Result<Vec<CheckedClaim>> {
    let runs = ResultsTable::read(&folder.join("runs.csv"))?;
    experiment.claims().iter().map(|claim| check(claim, &experiment.name(), &runs)).collect()
}

/// Checks that each claim is about runs of the plan.
///
/// # Errors
/// A claim about a scheme, metric or macro step that the plan does not have.
pub(super) fn check_claims_against_plan(claims: &[Claim], planned: &[PlannedRun]) -> Result<()> {
    for claim in claims {
        let names = || METRICS.iter().map(|metric| metric.name).chain(OUTCOMES);
        if !names().any(|name| name == claim.metric) {
            return Err(Error::unknown("metric of a claim", &claim.metric, names()));
        }
        for label in std::iter::once(&claim.scheme).chain(&claim.relative_to) {
            let of_label = || planned.iter().filter(|run| run.label == *label);
            if of_label().next().is_none() {
                let mut valid: Vec<&str> = planned.iter().map(|run| run.label.as_str()).collect();
                valid.dedup();
                return Err(Error::unknown("scheme of a claim", label, valid));
            }
            if !of_label().any(|run| claim.is_about(run.spec.macro_step)) {
                let step = claim.macro_step_s.unwrap_or(f64::NAN);
                let message =
                    format!("claim `{}` is about macro_step_s = {step}, which `{label}` does not run", claim.id);
                return Err(Error::Incompatible(message));
            }
        }
    }
    Ok(())
}

impl Claim {
    fn is_about(&self, macro_step: f64) -> bool {
        self.macro_step_s.is_none_or(|wanted| (macro_step / wanted - 1.0).abs() < SAME_STEP)
    }
}

fn check(claim: &Claim, experiment: &str, runs: &ResultsTable) -> Result<CheckedClaim> {
    let mut ids = Vec::new();
    let own = measure(claim, &claim.scheme, runs, &mut ids)?;
    let measured = match &claim.relative_to {
        None => own,
        Some(other) => {
            let other = measure(claim, other, runs, &mut ids)?;
            own.zip(other).map(|(own, other)| own / other)
        }
    };
    let verdict = match measured {
        None => Verdict::NotMeasured,
        Some(value) if claim.expect.at_least && value >= claim.expect.bound => Verdict::Reproduced,
        Some(value) if !claim.expect.at_least && value <= claim.expect.bound => Verdict::Reproduced,
        Some(_) => Verdict::NotReproduced,
    };
    let statistic = format!("{:?}", claim.statistic).to_lowercase();
    let relative = claim.relative_to.as_ref().map(|other| format!(" relative to {other}")).unwrap_or_default();
    let step = claim.macro_step_s.map(|step| format!(" at H = {} ms", step * 1e3)).unwrap_or_default();
    Ok(CheckedClaim {
        experiment: experiment.to_owned(),
        id: claim.id.clone(),
        by: claim.by,
        text: claim.text.clone(),
        quantity: format!("{statistic} of {} of {}{relative}{step}", claim.metric, claim.scheme),
        measured,
        expected: claim.expect.to_string(),
        verdict,
        finding: claim.finding,
        run_ids: ids.join(" "),
    })
}

/// The statistic of the claim's metric over the runs of one scheme row.
fn measure(claim: &Claim, label: &str, runs: &ResultsTable, ids: &mut Vec<String>) -> Result<Option<f64>> {
    let (id, step, outcome) = (runs.column("run_id")?, runs.column("macro_step_s")?, runs.column("outcome")?);
    let value = match claim.metric.as_str() {
        "diverged" => outcome,
        "diverged_at_s" => runs.column("outcome_at_s")?,
        metric => runs.column(metric)?,
    };
    let mut pairs = Vec::new();
    for row in runs.rows_where(runs.column("label")?, label) {
        if !claim.is_about(runs.number(row, step)) {
            continue;
        }
        ids.push(runs.text(row, id).to_owned());
        let number = match claim.metric.as_str() {
            "diverged" => f64::from(runs.text(row, value) == "diverged"),
            _ => runs.number(row, value),
        };
        if !number.is_nan() {
            pairs.push((runs.number(row, step), number));
        }
    }
    Ok(claim.statistic.of(pairs))
}

impl Statistic {
    /// Of pairs (macro step, value).
    fn of(self, pairs: Vec<(f64, f64)>) -> Option<f64> {
        let values: Vec<f64> = pairs.iter().map(|(_, value)| *value).collect();
        match self {
            _ if values.is_empty() => None,
            Statistic::Median => median(values),
            Statistic::Min => values.into_iter().reduce(f64::min),
            Statistic::Max => values.into_iter().reduce(f64::max),
            Statistic::Mean => Some(values.iter().sum::<f64>() / values.len() as f64),
            Statistic::Order => {
                let mut steps: Vec<f64> = pairs.iter().map(|(step, _)| *step).collect();
                steps.dedup();
                let of_step = |step: f64| pairs.iter().filter(|pair| pair.0 == step).map(|pair| pair.1).collect();
                let points: Vec<(f64, f64)> =
                    steps.into_iter().filter_map(|step| Some((step, median(of_step(step))?))).collect();
                order_of_convergence(&points)
            }
        }
    }
}

/// Writes checked claims to `claims.csv`.
///
/// # Errors
/// [`Error::File`].
pub fn write_claims(path: &Path, claims: &[CheckedClaim]) -> Result<()> {
    rimbench_results::atomic_file::write_atomically(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        for claim in claims {
            writer.serialize(claim)?;
        }
        writer.flush()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_over_phases_and_steps() {
        let pairs = vec![(1.0, 2.0), (1.0, 4.0), (2.0, 6.0), (2.0, 6.0), (2.0, 60.0)];
        assert_eq!(Statistic::Median.of(pairs.clone()), Some(6.0));
        assert_eq!(Statistic::Max.of(pairs.clone()), Some(60.0));
        approx::assert_relative_eq!(Statistic::Order.of(pairs).unwrap(), 1.0, epsilon = 1e-12);
        assert_eq!(Statistic::Min.of(Vec::new()), None);
    }

    #[test]
    fn an_expectation_is_a_comparison_or_an_error() {
        assert_eq!(Expectation::try_from(">= 2".to_owned()), Ok(Expectation { at_least: true, bound: 2.0 }));
        assert!(Expectation::try_from("about 2".to_owned()).unwrap_err().contains("valid"));
    }
}
