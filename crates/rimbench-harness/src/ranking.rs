//! The ranking: which scheme row has least error over the cases, of those that know as much of the other side. A table made of
//! the summaries that are kept.
//!
//! A problem is a case with its parameters at a macro step. On each of them a row has an error over its phases: the median rms force error
//! over the reference's peak, at most 1, of the runs that completed, and 1 of those that failed, which are worth no more than no force at
//! all. Runs that gave no answer (they took too long, or could not be begun) are not charged; a row that has no answer to a problem lacks
//! it and is not ranked.
//!
//! ```text
//! score = exp(mean over cases of the mean over its problems of the mean over runs of ln(e + s)) − s          s = 0.1 % of the peak
//! ```
//! Ranks are those of [`ranks`]: cases are drawn.

use super::experiment::{Experiment, Verdict};
use super::files::make_folder;
use rimbench_cases::catalogue::Catalogue;
use rimbench_core::error::{Error, Result};
use rimbench_core::schemes::InformationClass;
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums;
use rimbench_results::input::read_text;
use rimbench_results::kept::{SUMMARY_METRICS, SummaryRow, read_summary};
use rimbench_results::text_place::said_at;
use rimbench_statistics::{bootstrap_interval, ranks};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What is compared.
const ERROR: &str = "force_error_rms_of_peak";

/// Error that a failure is charged, and the most that any error counts.
const CHARGE: f64 = 1.0;

/// The shift of the logarithm.
const SHIFT: f64 = 1e-3;

/// A ranking file as it is written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ranking {
    /// What the ranking answers, in words.
    pub question: String,
    /// Experiment files, relative to this one.
    experiments: Vec<PathBuf>,
    #[serde(default)]
    claims: Vec<RankClaim>,
    #[serde(skip)]
    path: PathBuf,
}

/// That one row is surely better than another of its group; with what came out.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct RankClaim {
    id: String,
    text: String,
    /// Label of the row.
    row: String,
    /// Label of the other.
    ahead_of: String,
    /// Ratio of the errors, a geometric mean over cases.
    #[serde(skip_deserializing)]
    measured: Option<f64>,
    /// 95 % interval of that.
    #[serde(skip_deserializing)]
    low: Option<f64>,
    #[serde(skip_deserializing)]
    high: Option<f64>,
    /// Reproduced where the whole interval is below 1.
    #[serde(skip_deserializing, default = "not_measured")]
    verdict: Verdict,
    finding: Verdict,
}

fn not_measured() -> Verdict {
    Verdict::NotMeasured
}

/// A row of the table.
#[derive(Debug, Clone, Serialize)]
struct RankedRow {
    class: String,
    /// Cases that its gain was chosen on, if any.
    tuned_on: String,
    rank: usize,
    rank_last: usize,
    label: String,
    score: f64,
    score_low: Option<f64>,
    score_high: Option<f64>,
    problems: usize,
    runs: usize,
    failed: usize,
}

/// A row before it is ranked.
#[derive(Debug, Clone)]
struct RowTally {
    class: InformationClass,
    tuned_on: BTreeSet<String>,
    /// By problem: mean of ln(e + s) over the runs.
    values: BTreeMap<[String; 3], f64>,
    runs: usize,
    failed: usize,
}

impl Ranking {
    /// Reads a ranking file.
    ///
    /// # Errors
    /// [`Error::File`] with path, line and what is wrong; unknown keys are errors.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(path, &read_text(path)?)
    }

    /// Reads the text of a ranking file; `path` is what its experiments are relative to, and what errors name.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let wrong = |error: toml::de::Error| {
            Error::file(path, format!("is no ranking: {}", said_at(text, error.span(), error.message())))
        };
        let mut ranking: Ranking = toml::from_str(text).map_err(wrong)?;
        path.clone_into(&mut ranking.path);
        if ranking.experiments.is_empty() {
            return Err(Error::file(path, "experiments = [] is not valid; valid: at least one experiment file"));
        }
        let mut ids = BTreeSet::new();
        match ranking.claims.iter().find(|claim| !ids.insert(&claim.id)) {
            Some(twice) => Err(Error::file(path, format!("two claims have the id `{}`", twice.id))),
            None => Ok(ranking),
        }
    }

    /// Returns the experiment files.
    pub fn experiments(&self) -> Vec<PathBuf> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        self.experiments.iter().map(|file| folder.join(file)).collect()
    }

    /// Ranks the rows of its experiments, which `read` reads and whose summaries lie below `results`; writes `ranking.csv` and `claims.csv`
    /// with their checksums to `ranking` there. Returns ids of claims that come out otherwise than was recorded.
    ///
    /// # Errors
    /// Those of `read`; [`Error::File`] for summaries that are not there or not as they were written; for claims about rows that are not
    /// ranked, or not in one group.
    pub fn write(
        self,
        catalogue: &Catalogue,
        results: &Path,
        read: impl Fn(&Path) -> Result<Experiment>,
    ) -> Result<Vec<String>> {
        let mut tallies: BTreeMap<String, RowTally> = BTreeMap::new();
        for file in self.experiments() {
            let experiment = read(&file)?;
            for run in experiment.plan(catalogue, false)? {
                // Control of the macro step takes steps again, whatever the scheme.
                let controlled = run.spec.step_control.is_some();
                let class = InformationClass::of(&run.spec.scheme);
                let class = if controlled { class.max(InformationClass::Repetition) } else { class };
                let tally = tallies.entry(run.label).or_insert_with(|| RowTally::new(class));
                tally.class = tally.class.max(class);
                // A gain that is not the default was chosen on something.
                let usual = run.spec.scheme.gain.as_ref().map(|gain| gain.default);
                if run.spec.gain.is_some() && run.spec.gain != usual {
                    tally.tuned_on.insert(run.spec.case.name.to_string());
                }
            }
            for row in read_summary(&experiment.results_folder(results))? {
                if let Some(tally) = tallies.get_mut(&row.keys[2]) {
                    tally.enter(&row);
                }
            }
        }
        let (rows, values) = ranked(&tallies);
        let claims =
            self.claims.iter().map(|claim| self.measured(claim, &rows, &values)).collect::<Result<Vec<_>>>()?;
        let folder = results.join("ranking");
        make_folder(&folder)?;
        write_rows(&folder.join("ranking.csv"), &rows)?;
        write_rows(&folder.join("claims.csv"), &claims)?;
        checksums::write(&folder, ["ranking.csv", "claims.csv"].map(str::to_owned))?;
        let differs = |claim: &RankClaim| claim.finding != Verdict::NotMeasured && claim.finding != claim.verdict;
        Ok(claims.into_iter().filter(differs).map(|claim| claim.id).collect())
    }

    fn measured(
        &self,
        claim: &RankClaim,
        rows: &[RankedRow],
        values: &BTreeMap<String, Vec<f64>>,
    ) -> Result<RankClaim> {
        let named = |label: &str| {
            rows.iter().find(|row| row.label == label).ok_or_else(|| {
                let error = Error::unknown("row of a claim", label, rows.iter().map(|row| row.label.as_str()));
                Error::file(&self.path, format!("claim `{}`: {error}", claim.id))
            })
        };
        let [one, other] = [named(&claim.row)?, named(&claim.ahead_of)?];
        if (&one.class, one.tuned_on.is_empty()) != (&other.class, other.tuned_on.is_empty()) {
            let RankClaim { id, row, ahead_of, .. } = claim;
            let why = "being of different classes, or one of them tuned";
            let message = format!("claim `{id}`: `{row}` and `{ahead_of}` are not ranked together, {why}");
            return Err(Error::file(&self.path, message));
        }
        let differences = values[&one.label].iter().zip(&values[&other.label]);
        let differences: Vec<Vec<f64>> = differences.map(|(a, b)| vec![a - b]).collect();
        let ratio = |values: Vec<f64>| mean(&values).map(libm::exp);
        let interval = bootstrap_interval(&differences, ratio);
        let verdict = match interval {
            None => Verdict::NotMeasured,
            Some([_, high]) if high < 1.0 => Verdict::Reproduced,
            Some(_) => Verdict::NotReproduced,
        };
        let [low, high] = [0, 1].map(|end| interval.map(|ends| ends[end]));
        Ok(RankClaim { measured: ratio(differences.concat()), low, high, verdict, ..claim.clone() })
    }
}

impl RowTally {
    fn new(class: InformationClass) -> Self {
        RowTally { class, tuned_on: BTreeSet::new(), values: BTreeMap::new(), runs: 0, failed: 0 }
    }

    fn enter(&mut self, row: &SummaryRow) {
        let answers = row.completed + row.failed;
        let metric = SUMMARY_METRICS.iter().position(|metric| *metric == ERROR);
        let median = metric.map_or(f64::NAN, |metric| row.quartiles[metric][1]);
        // A completed run without an error is worth no more than a failure.
        let error = if median.is_nan() { CHARGE } else { median.min(CHARGE) };
        if answers > 0 {
            let [completed, failed] = [row.completed, row.failed].map(|count| count as f64 / answers as f64);
            let value = completed * libm::log(error + SHIFT) + failed * libm::log(CHARGE + SHIFT);
            let [case, set, _, step, _] = row.keys.clone();
            // One row that was run several ways on a problem has the worst of them: none was chosen beforehand.
            let known = self.values.entry([case, set, step]).or_insert(value);
            *known = known.max(value);
        }
        self.runs += answers;
        self.failed += row.failed;
    }
}

/// Rows that have an answer to all problems, by class, untuned before tuned, by score; and what each has, in logarithms, by case.
fn ranked(tallies: &BTreeMap<String, RowTally>) -> (Vec<RankedRow>, BTreeMap<String, Vec<f64>>) {
    let problems: BTreeSet<&[String; 3]> = tallies.values().flat_map(|tally| tally.values.keys()).collect();
    let mut groups = BTreeMap::<_, Vec<(&String, &RowTally, Vec<f64>)>>::new();
    for (label, tally) in tallies.iter().filter(|(_, tally)| tally.values.len() == problems.len()) {
        let mut of_case: BTreeMap<&String, Vec<f64>> = BTreeMap::new();
        tally.values.iter().for_each(|([case, ..], value)| of_case.entry(case).or_default().push(*value));
        let values = of_case.values().filter_map(|own| mean(own)).collect();
        groups.entry((tally.class, !tally.tuned_on.is_empty())).or_default().push((label, tally, values));
    }
    let score = |values: Vec<f64>| mean(&values).map(|mean| libm::exp(mean) - SHIFT);
    let (mut rows, mut by_label) = (Vec::new(), BTreeMap::new());
    for ((class, _), group) in groups {
        let all: Vec<Vec<f64>> = group.iter().map(|(.., values)| values.clone()).collect();
        let begin = rows.len();
        for ((label, tally, values), rank) in group.into_iter().zip(ranks(&all)) {
            let cases: Vec<Vec<f64>> = values.iter().map(|value| vec![*value]).collect();
            let interval = bootstrap_interval(&cases, score);
            rows.push(RankedRow {
                class: class.to_string(),
                tuned_on: tally.tuned_on.iter().cloned().collect::<Vec<_>>().join(" "),
                rank: rank.first,
                rank_last: rank.last,
                label: label.clone(),
                score: score(values.clone()).unwrap_or(CHARGE),
                score_low: interval.map(|[low, _]| low),
                score_high: interval.map(|[_, high]| high),
                problems: problems.len(),
                runs: tally.runs,
                failed: tally.failed,
            });
            by_label.insert(label.clone(), values);
        }
        rows[begin..].sort_by(|a, b| a.score.total_cmp(&b.score).then_with(|| a.label.cmp(&b.label)));
    }
    (rows, by_label)
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn write_rows<T: Serialize>(path: &Path, rows: &[T]) -> Result<()> {
    write_atomically(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        rows.iter().try_for_each(|row| writer.serialize(row))?;
        writer.flush()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(case: &str, [completed, failed, no_answer]: [usize; 3], median: f64) -> SummaryRow {
        let mut quartiles = [[f64::NAN; 3]; SUMMARY_METRICS.len()];
        quartiles[1][1] = median;
        let keys = [case, "", "label", "0.001", ""].map(str::to_owned);
        SummaryRow { keys, runs: completed + failed + no_answer, completed, failed, no_answer, quartiles, worst: None }
    }

    fn tally(rows: &[SummaryRow]) -> RowTally {
        let mut tally = RowTally::new(InformationClass::Samples);
        rows.iter().for_each(|row| tally.enter(row));
        tally
    }

    #[test]
    fn failures_are_charged_and_what_gave_no_answer_is_not() {
        let cases = ["a", "b", "c", "d"];
        let all = |counts, error| tally(&cases.map(|case| row(case, counts, error)));
        let lacking = tally(&[row("a", [2, 0, 0], 1e-9), row("b", [0, 0, 2], f64::NAN)]);
        let tallies = [
            ("good", all([2, 0, 0], 0.01)),
            ("fails", all([1, 1, 0], 0.01)),
            ("slow", all([1, 0, 1], 0.01)),
            ("lacking", lacking),
        ];
        let tallies = tallies.map(|(label, tally)| (label.to_owned(), tally)).into();
        let (rows, _) = ranked(&tallies);
        let found: Vec<(&str, usize, usize)> =
            rows.iter().map(|row| (row.label.as_str(), row.rank, row.failed)).collect();
        assert_eq!(found, [("good", 1, 0), ("slow", 1, 0), ("fails", 3, 4)]);
        // Half of the runs at 1 % and half at the peak: √(0.011 · 1.001) − 0.001.
        approx::assert_relative_eq!(rows[2].score, (0.011_f64 * 1.001).sqrt() - 1e-3, max_relative = 1e-12);
        approx::assert_relative_eq!(rows[1].score, 0.01, max_relative = 1e-12);
    }
}
