//! Which scheme row has least error over the cases, of those that know as much of the other side: a table made of kept
//! summaries.
//!
//! A problem is a case with its parameters at a macro step. On each of them a row has an error over its phases: the
//! median rms force error over the reference's peak, at most 1, of the runs that completed, and 1 of those that failed,
//! which are worth no more than no force at all. Runs that gave no answer (they took too long, or could not be begun)
//! are not charged: a problem to which a row has no answer is left out for all, and a row without any in some case is not
//! ranked.
//!
//! ```text
//! score = exp(mean over cases of the mean over its problems of the mean over runs of ln(e + s)) − s          s = 0.1 % of the peak
//! ```
//! A row is surely better than another where the 95 % interval of the ratio of their errors lies below one. Cases are
//! drawn, the same for both, so that what is hard for all tells none apart. Pairs are asked one by one, with no
//! allowance for their number: of twenty pairs that are equal in truth, one is told apart. Source: Goldstein,
//! Spiegelhalter: League tables and their limitations, J. R. Stat. Soc. A 159 (1996).

use super::experiment::{Experiment, Verdict, check_claim_id};
use super::files::make_folder;
use rimbench_cases::catalogue::Catalogue;
use rimbench_core::error::{Error, Result};
use rimbench_core::schemes::InformationClass;
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums;
use rimbench_results::input::read_text;
use rimbench_results::kept::{SUMMARY_METRICS, SummaryRow, read_summary};
use rimbench_results::text_place::said_at;
use rimbench_statistics::bootstrap_interval;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

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

/// That one row, by its label, is surely better than another.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct RankClaim {
    id: String,
    text: String,
    row: String,
    ahead_of: String,
    #[serde(skip_serializing)]
    finding: Verdict,
}

/// A claim with the ratio of the errors of its rows, a geometric mean over cases, the 95 % interval of that, verdict
/// and finding.
type Measured<'a> = (&'a RankClaim, f64, [Option<f64>; 2], Verdict, Verdict);

/// A row of the table, with what the summaries say of it.
#[derive(Debug, Default)]
struct Row {
    label: String,
    class: Option<InformationClass>,
    /// Cases that its gain was chosen on, if any.
    tuned_on: BTreeSet<String>,
    /// By problem: mean of ln(e + s) over the runs.
    values: BTreeMap<[String; 3], f64>,
    runs: usize,
    failed: usize,
    /// Mean of ln(e + s), case by case.
    by_case: Vec<f64>,
    score: f64,
    /// One more than the number of rows that are surely better, and all rows but those that are surely worse.
    rank: [usize; 2],
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
        let checked = ranking.claims.iter().try_for_each(|claim| check_claim_id(&claim.id));
        checked.map_err(|error| Error::file(path, error))?;
        if let Some(RankClaim { id, row, .. }) = ranking.claims.iter().find(|claim| claim.row == claim.ahead_of) {
            return Err(Error::file(path, format!("claim `{id}`: `{row}` is ahead of itself; valid: another row")));
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

    /// Ranks the rows of its experiments, whose summaries lie below `results`; writes `ranking.csv` and `claims.csv`
    /// with their checksums to the folder `out`. Returns ids of claims that come out otherwise than was recorded.
    ///
    /// # Errors
    /// [`Error::File`] for experiments and summaries that are not there or not as they were written, and for claims
    /// about rows that are not ranked.
    pub fn write(self, catalogue: &Catalogue, results: &Path, out: &Path) -> Result<Vec<String>> {
        let mut rows: BTreeMap<String, Row> = BTreeMap::new();
        for file in self.experiments() {
            let experiment = Experiment::read(&file)?;
            for run in experiment.plan_at_first_draw(catalogue, false)? {
                let row = rows.entry(run.label).or_default();
                // Control of the macro step takes steps again, whatever the scheme.
                let controlled = run.spec.step_control.map(|_| InformationClass::Repetition);
                row.class = row.class.max(controlled).max(Some(InformationClass::of(&run.spec.scheme)));
                // A gain that is not the default was chosen on something.
                let usual = run.spec.scheme.gain.as_ref().map(|gain| gain.default);
                if run.spec.gain.is_some() && run.spec.gain != usual {
                    row.tuned_on.insert(run.spec.case.name.to_string());
                }
            }
            for summary in read_summary(&experiment.results_folder(results))? {
                if let Some(row) = rows.get_mut(&summary.keys[2]) {
                    row.enter(&summary);
                }
            }
        }
        let rows = ranked(rows);
        let claims = self.claims.iter().map(|claim| self.measured(claim, &rows)).collect::<Result<Vec<_>>>()?;
        make_folder(out)?;
        let header = "class,tuned_on,rank,rank_last,label,score,score_low,score_high,problems,runs,failed";
        write_table(&out.join("ranking.csv"), header, rows.iter().map(Row::cells))?;
        let header = "id,text,row,ahead_of,measured,low,high,verdict,finding";
        write_table(&out.join("claims.csv"), header, claims.iter())?;
        checksums::write(out, ["ranking.csv", "claims.csv"].map(str::to_owned))?;
        let differs = |(.., verdict, finding): &&Measured<'_>| *finding != Verdict::NotMeasured && finding != verdict;
        Ok(claims.iter().filter(differs).map(|(claim, ..)| claim.id.clone()).collect())
    }

    fn measured<'a>(&self, claim: &'a RankClaim, rows: &[Row]) -> Result<Measured<'a>> {
        let named = |label: &String| {
            rows.iter().find(|row| row.label == *label).ok_or_else(|| {
                let error = Error::unknown("row of a claim", label, rows.iter().map(|row| &*row.label));
                Error::file(&self.path, format!("claim `{}`: {error}", claim.id))
            })
        };
        let (measured, interval) = ratio(&named(&claim.row)?.by_case, &named(&claim.ahead_of)?.by_case);
        let verdict = match interval[1] {
            None => Verdict::NotMeasured,
            Some(high) if high < 1.0 => Verdict::Reproduced,
            Some(_) => Verdict::NotReproduced,
        };
        Ok((claim, measured, interval, verdict, claim.finding))
    }
}

impl Row {
    fn enter(&mut self, summary: &SummaryRow) {
        let answers = summary.completed + summary.failed;
        let metric = SUMMARY_METRICS.iter().position(|metric| *metric == "force_error_rms_of_peak");
        let median = metric.map_or(f64::NAN, |metric| summary.quartiles[metric][1]);
        // A completed run without an error is worth no more than a failure.
        let error = if median.is_nan() { CHARGE } else { median.min(CHARGE) };
        if answers > 0 {
            let [completed, failed] = [summary.completed, summary.failed].map(|count| count as f64 / answers as f64);
            let value = completed * libm::log(error + SHIFT) + failed * libm::log(CHARGE + SHIFT);
            let [case, set, _, step, _] = summary.keys.clone();
            // One row that was run several ways on a problem has the worst of them: none was chosen beforehand.
            let known = self.values.entry([case, set, step]).or_insert(value);
            *known = known.max(value);
        }
        self.runs += answers;
        self.failed += summary.failed;
    }

    fn cells(&self) -> impl Serialize {
        let Row { label, class, tuned_on, rank, score, .. } = self;
        let tuned_on = tuned_on.iter().cloned().collect::<Vec<_>>().join(" ");
        let interval = interval(&self.by_case, as_error);
        let counts = [self.values.len(), self.runs, self.failed];
        (class.map(|class| class.to_string()), tuned_on, *rank, label.clone(), *score, interval, counts)
    }
}

/// Rows that have an answer in all cases, by class, untuned before tuned, by score over the problems to which all of
/// them have one.
fn ranked(mut rows: BTreeMap<String, Row>) -> Vec<Row> {
    let of = |row: &Row| row.values.keys().map(|[case, ..]| case.clone()).collect::<BTreeSet<_>>();
    let cases: BTreeSet<_> = rows.values().flat_map(of).collect();
    rows.retain(|_, row| of(row) == cases);
    let answered = |problem: &[String; 3]| rows.values().all(|row| row.values.contains_key(problem));
    let problems: BTreeSet<_> =
        rows.values().flat_map(|row| row.values.keys()).filter(|own| answered(own)).cloned().collect();
    let mut groups = BTreeMap::<_, Vec<Row>>::new();
    for (label, mut row) in rows.into_iter().filter(|_| !problems.is_empty()) {
        row.values.retain(|problem, _| problems.contains(problem));
        let mut of_case: BTreeMap<&String, Vec<f64>> = BTreeMap::new();
        row.values.iter().for_each(|([case, ..], value)| of_case.entry(case).or_default().push(*value));
        row.by_case = of_case.values().map(|own| mean(own)).collect();
        row.score = as_error(mean(&row.by_case));
        row.label = label;
        groups.entry((row.class, !row.tuned_on.is_empty())).or_default().push(row);
    }
    groups.values_mut().for_each(|group| {
        let ranks = ranks(&group.iter().map(|row| &*row.by_case).collect::<Vec<_>>());
        group.iter_mut().zip(ranks).for_each(|(row, rank)| row.rank = rank);
        group.sort_by(|a, b| a.score.total_cmp(&b.score).then_with(|| a.label.cmp(&b.label)));
    });
    groups.into_values().flatten().collect()
}

/// First and last rank of each row of values, one per case, of which less is better.
fn ranks(rows: &[&[f64]]) -> Vec<[usize; 2]> {
    let is_better = |a: &[f64], b: &[f64]| ratio(a, b).1[1].is_some_and(|high| high < 1.0);
    let better: Vec<Vec<bool>> = rows.iter().map(|a| rows.iter().map(|b| is_better(a, b)).collect()).collect();
    let ahead = |of: usize| better.iter().filter(|row| row[of]).count();
    let behind = |of: usize| better[of].iter().filter(|is| **is).count();
    (0..rows.len()).map(|row| [1 + ahead(row), rows.len() - behind(row)]).collect()
}

/// Ratio of errors that are given as logarithms, case by case, a geometric mean, and its interval.
fn ratio(a: &[f64], b: &[f64]) -> (f64, [Option<f64>; 2]) {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    (libm::exp(mean(&differences)), interval(&differences, libm::exp))
}

/// 95 % interval of a function of the mean over cases, which are drawn; none of a single case.
fn interval(values: &[f64], of: impl Fn(f64) -> f64) -> [Option<f64>; 2] {
    let cases: Vec<Vec<f64>> = values.iter().map(|value| vec![*value]).collect();
    let interval = bootstrap_interval(&cases, |drawn| Some(of(mean(&drawn))));
    [0, 1].map(|end| interval.map(|ends| ends[end]))
}

/// Turns a mean of ln(e + s) into an error.
fn as_error(mean: f64) -> f64 {
    libm::exp(mean) - SHIFT
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn write_table<T: Serialize>(path: &Path, header: &str, rows: impl Iterator<Item = T> + Clone) -> Result<()> {
    write_atomically(path, |file| {
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(file);
        writer.write_record(header.split(','))?;
        rows.clone().try_for_each(|row| writer.serialize(row))?;
        writer.flush()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(cases: &[(&str, [usize; 3], f64)]) -> Row {
        let mut row = Row::default();
        for (case, [completed, failed, no_answer], median) in cases {
            let keys = [case, "", "label", "0.001", ""].map(str::to_owned);
            let (runs, quartiles) = (completed + failed + no_answer, [[*median; 3]; SUMMARY_METRICS.len()]);
            let [completed, failed, no_answer] = [*completed, *failed, *no_answer];
            row.enter(&SummaryRow {
                keys,
                runs,
                completed,
                failed,
                no_answer,
                usable: completed,
                quartiles,
                worst: None,
            });
        }
        row
    }

    #[test]
    fn failures_are_charged_and_what_gave_no_answer_is_not() {
        let all = |counts| row(&["a", "b", "c", "d"].map(|case| (case, counts, 0.01)));
        let lacking = row(&[("a", [2, 0, 0], 1e-9), ("b", [0, 0, 2], f64::NAN)]);
        let rows =
            [("good", all([2, 0, 0])), ("fails", all([1, 1, 0])), ("slow", all([1, 0, 1])), ("lacking", lacking)];
        let rows = ranked(rows.map(|(label, row)| (label.to_owned(), row)).into());
        let found: Vec<_> = rows.iter().map(|row| (&*row.label, row.rank[0], row.failed)).collect();
        assert_eq!(found, [("good", 1, 0), ("slow", 1, 0), ("fails", 3, 4)]);
        // Half of the runs at 1 % and half at the peak: √(0.011 · 1.001) − 0.001.
        approx::assert_relative_eq!(rows[2].score, (0.011_f64 * 1.001).sqrt() - 1e-3, max_relative = 1e-12);
        approx::assert_relative_eq!(rows[1].score, 0.01, max_relative = 1e-12);
    }

    #[test]
    fn a_macro_step_that_one_row_cannot_take_is_left_out_for_all() {
        let at = |steps: &[(&str, f64)]| {
            let mut row = row(&[("a", [1, 0, 0], 0.1)]);
            row.values = steps.iter().map(|(step, value)| (["a", "", step].map(str::to_owned), *value)).collect();
            row
        };
        let (few, all) = (at(&[("0.001", -4.0)]), at(&[("0.001", -5.0), ("0.002", -1.0)]));
        let rows = ranked([("few", few), ("all", all)].map(|(label, row)| (label.to_owned(), row)).into());
        let found: Vec<_> = rows.iter().map(|row| (&*row.label, row.values.len())).collect();
        assert_eq!(found, [("all", 1), ("few", 1)]);
    }

    #[test]
    fn who_is_better_in_every_case_is_ahead_and_equals_share_a_rank() {
        let (low, high): (&[f64], &[f64]) = (&[1.0, 2.0, 3.0, 4.0], &[1.1, 2.1, 3.1, 4.1]);
        let mixed: &[f64] = &[0.5, 2.5, 2.5, 4.5];
        assert_eq!(ranks(&[low, high]), [[1, 1], [2, 2]]);
        assert_eq!(ranks(&[high, low]), [[2, 2], [1, 1]]);
        // In the middle of three: told from neither, although the others are told apart.
        assert_eq!(ranks(&[low, mixed, high]), [[1, 2], [1, 3], [2, 3]]);
        assert_eq!(ranks(&[low, low]), [[1, 2], [1, 2]]);
        assert_eq!(ranks(&[&[1.0], &[9.0]]), [[1, 2], [1, 2]], "one case proves nothing");
        // What is hard for all: with unpaired cases the spread would hide a difference that every case shows.
        let hard: Vec<f64> = (0..12).map(|case| f64::from(case) * 10.0).collect();
        let less: Vec<f64> = hard.iter().enumerate().map(|(case, value)| value - 0.1 - 0.01 * case as f64).collect();
        assert_eq!(ranks(&[&hard, &less]), [[2, 2], [1, 1]]);
    }
}
