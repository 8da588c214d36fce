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
//!
//! Beside its own experiments it ranks entries of others, by the same rows of `summary.csv`: those of the closed division
//! that have all problems of the experiments' rows. Each row also has its place under five other rules ([`RULES`]).

use super::experiment::{Experiment, Verdict, check_claim_id};
use super::open::{Division, ENTRY, Entry};
use rimbench_core::error::{Error, Result};
use rimbench_core::schemes::InformationClass;
use rimbench_results::atomic_file::{check_writable_folder, write_atomically};
use rimbench_results::checksums;
use rimbench_results::input::read_text;
use rimbench_results::kept::{SUMMARY_METRICS, SummaryRow, read_summary};
use rimbench_results::results_table::read_table;
use rimbench_results::text_place::said_at;
use rimbench_runs::catalogue::Catalogue;
use rimbench_statistics::interval_of_mean;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Error that a failure is charged, and the most that any error counts.
const CHARGE: f64 = 1.0;

/// The shift of the logarithm.
const SHIFT: f64 = 1e-3;

/// Names of columns of places under other rules: errors over the peak at the event, errors of the position over the
/// case's own scale, failures and errors charged with 0.3 at most, ten times the shift, completed runs alone.
pub const RULES: [&str; 5] = ["by_event_peak", "by_position", "by_charge_0_3", "by_shift_1_percent", "by_completed"];

/// Name of the file with the peaks of the problems, in the folder of the ranking's results.
pub const PROBLEMS: &str = "problems.csv";

/// A ranking file as it is written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ranking {
    /// What the ranking answers, in words.
    pub question: String,
    /// Experiment files, relative to this one.
    #[serde(default)]
    experiments: Vec<PathBuf>,
    /// Folders of entries, relative to this file; `*` at the end stands for all folders there with an entry.
    #[serde(default)]
    entries: Vec<PathBuf>,
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

/// What comes of a ranking besides its files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ranked {
    /// Claims that come out otherwise than was recorded, by their ids.
    pub differing: Vec<String>,
    /// Entries that are not ranked, each in a sentence.
    pub notes: Vec<String>,
}

/// What rows of the benchmark's own authors are marked with.
const AUTHORS: &str = "authors";

/// A row of the table, with what the summaries say of it.
#[derive(Debug, Default)]
struct Row {
    label: String,
    class: Option<InformationClass>,
    /// Cases that its gain was chosen on, if any.
    tuned_on: BTreeSet<String>,
    /// Whether it is of the authors of the benchmark, or of others.
    by: &'static str,
    /// By problem: mean of ln(e + s) over the runs, and the same under each of [`RULES`].
    values: BTreeMap<[String; 3], [f64; 1 + RULES.len()]>,
    runs: usize,
    failed: usize,
    /// Mean of ln(e + s), case by case.
    by_case: Vec<f64>,
    score: f64,
    /// One more than the number of rows that are surely better, and all rows but those that are surely worse.
    rank: [usize; 2],
    /// Scores under each of [`RULES`], and places by them.
    others: [(f64, usize); RULES.len()],
}

/// What a case's errors are related to besides the peak: peak over that at the event, and scale of the position, m.
type Scales = BTreeMap<String, [f64; 2]>;

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
        if ranking.experiments.is_empty() && ranking.entries.is_empty() {
            let message = "experiments = [] is not valid; valid: at least one experiment file, or a folder of an entry";
            return Err(Error::file(path, message));
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

    /// Ranks the rows of its experiments, whose summaries lie below `results`, and its entries; writes `ranking.csv`,
    /// `open.csv` with the entries of the open division, and `claims.csv` with their checksums to the folder `out`.
    ///
    /// # Errors
    /// [`Error::File`] for experiments, entries and summaries that are not there or not as they were written, and for
    /// claims about rows that are not ranked.
    pub fn write(self, catalogue: &Catalogue, results: &Path, out: &Path) -> Result<Ranked> {
        let scales = scales(catalogue, &results.join("ranking").join(PROBLEMS))?;
        let mut rows: BTreeMap<String, Row> = BTreeMap::new();
        for file in self.experiments() {
            let experiment = Experiment::read(&file)?;
            for run in experiment.plan_at_first_draw(catalogue, false)? {
                let row = rows.entry(run.label).or_insert(Row { by: AUTHORS, ..Row::default() });
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
                    row.enter(&summary, &scales);
                }
            }
        }
        let (mut entered, mut open, mut notes) = (BTreeMap::new(), BTreeMap::new(), Vec::new());
        for folder in self.entries()? {
            let entry = Entry::read(&folder)?;
            let by = if entry.of_the_benchmark { AUTHORS } else { "others" };
            let tuned_on = entry.tuned_on.clone();
            let mut row = Row { by, tuned_on, class: Some(entry.class()?), ..Row::default() };
            entry.summary(&folder)?.iter().for_each(|summary| row.enter(summary, &scales));
            let into = if entry.division == Division::Closed { &mut entered } else { &mut open };
            if rows.contains_key(&entry.name) || into.insert(entry.name.clone(), row).is_some() {
                let message = format!("name = \"{}\" is that of another row; valid: one of its own", entry.name);
                return Err(Error::file(folder.join(ENTRY), message));
            }
        }
        // What strangers leave out does not change what others are ranked by.
        let asked = common(&rows);
        let is_whole = |row: &Row| asked.iter().all(|problem| row.values.contains_key(problem));
        for (name, row) in entered {
            match is_whole(&row) {
                true => drop(rows.insert(name, row)),
                false => {
                    let missing = asked.iter().filter(|problem| !row.values.contains_key(*problem)).count();
                    notes.push(format!(
                        "{name} is not ranked: it has no answer to {missing} of {} problems",
                        asked.len()
                    ));
                }
            }
        }
        let (rows, open) = (ranked(rows), ranked(open));
        let claims = self.claims.iter().map(|claim| self.measured(claim, &rows)).collect::<Result<Vec<_>>>()?;
        check_writable_folder(out)?;
        let header = "class,tuned_on,rank,rank_last,label,score,score_low,score_high,problems,runs,failed,by";
        let header = format!("{header},{}", RULES.join(","));
        let mut files = vec!["ranking.csv", "claims.csv"];
        write_table(&out.join("ranking.csv"), &header, rows.iter().map(Row::cells))?;
        if !open.is_empty() {
            write_table(&out.join("open.csv"), &header, open.iter().map(Row::cells))?;
            files.push("open.csv");
        }
        let header = "id,text,row,ahead_of,measured,low,high,verdict,finding";
        write_table(&out.join("claims.csv"), header, claims.iter())?;
        checksums::write(out, files.into_iter().map(str::to_owned))?;
        let differs = |(.., verdict, finding): &&Measured<'_>| *finding != Verdict::NotMeasured && finding != verdict;
        let differing = claims.iter().filter(differs).map(|(claim, ..)| claim.id.clone()).collect();
        Ok(Ranked { differing, notes })
    }

    /// Folders of entries.
    fn entries(&self) -> Result<Vec<PathBuf>> {
        let mut found = Vec::new();
        for pattern in &self.entries {
            let folder = self.path.parent().unwrap_or(Path::new("")).join(pattern);
            if folder.file_name().is_none_or(|name| name != "*") {
                found.push(folder);
                continue;
            }
            let parent = folder.parent().unwrap_or(Path::new(""));
            let unreadable = |error: std::io::Error| {
                Error::file(&self.path, format!("entries: {}: cannot be read: {error}", parent.display()))
            };
            let own = std::fs::read_dir(parent).map_err(unreadable)?;
            let own = own.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>().map_err(unreadable)?;
            found.extend(own.into_iter().filter(|path| path.join(ENTRY).is_file()));
        }
        found.sort();
        Ok(found)
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
    fn enter(&mut self, summary: &SummaryRow, scales: &Scales) {
        let answers = summary.completed + summary.failed;
        let metric = |name| SUMMARY_METRICS.iter().position(|metric| *metric == name);
        let median = |name| metric(name).map_or(f64::NAN, |metric| summary.quartiles[metric][1]);
        let (median, position) = (median("force_error_rms_of_peak"), median("position_error_rms_m"));
        let [of_event, of_position] = scales.get(&summary.keys[0]).copied().unwrap_or([f64::NAN; 2]);
        if answers > 0 {
            let [completed, failed] = [summary.completed, summary.failed].map(|count| count as f64 / answers as f64);
            let value = |error: f64, charge: f64, shift: f64| {
                // A completed run without an error is worth no more than a failure.
                let error = if error.is_nan() { charge } else { error.min(charge) };
                completed * libm::log(error + shift) + failed * libm::log(charge + shift)
            };
            let known = |scale: f64, value: f64| if scale.is_nan() { f64::NAN } else { value };
            let values = [
                value(median, CHARGE, SHIFT),
                known(of_event, value(median * of_event, CHARGE, SHIFT)),
                known(of_position, value(position / of_position, CHARGE, SHIFT)),
                value(median, 0.3, SHIFT),
                value(median, CHARGE, 10.0 * SHIFT),
                if summary.completed > 0 { libm::log(median.min(CHARGE) + SHIFT) } else { f64::NAN },
            ];
            let [case, set, _, step, _] = summary.keys.clone();
            // One row that was run several ways on a problem has the worst of them: none was chosen beforehand.
            let known = self.values.entry([case, set, step]).or_insert(values);
            known.iter_mut().zip(values).for_each(|(known, value)| *known = known.max(value));
        }
        self.runs += answers;
        self.failed += summary.failed;
    }

    /// Means over the problems of each case under a rule, 0 for that of the ranking; those that say nothing left out.
    fn means(&self, rule: usize) -> Vec<f64> {
        let mut of_case: BTreeMap<&String, Vec<f64>> = BTreeMap::new();
        let told = self.values.iter().filter(|(_, values)| !values[rule].is_nan());
        told.for_each(|([case, ..], values)| of_case.entry(case).or_default().push(values[rule]));
        of_case.values().map(|own| mean(own)).collect()
    }

    fn cells(&self) -> impl Serialize {
        let Row { label, class, tuned_on, rank, score, by, .. } = self;
        let tuned_on = tuned_on.iter().cloned().collect::<Vec<_>>().join(" ");
        let interval = interval(&self.by_case, as_error);
        let counts = [self.values.len(), self.runs, self.failed];
        let class = class.map(|class| class.to_string());
        let others = self.others.map(|(score, place)| (!score.is_nan()).then_some(place));
        (class, tuned_on, *rank, label.clone(), *score, interval, counts, *by, others)
    }
}

/// Reads what errors are related to under other rules: peaks of the problems from a file, if it is there.
fn scales(catalogue: &Catalogue, peaks: &Path) -> Result<Scales> {
    let of_case = |case: &std::sync::Arc<rimbench_cases::cases::Case>| {
        (case.name.to_string(), [f64::NAN, case.scale.map_or(f64::NAN, |scale| scale.position_m)])
    };
    let mut scales: Scales = catalogue.cases().iter().map(of_case).collect();
    if peaks.is_file() {
        let table = read_table(peaks)?;
        let [case, ratio] = ["case", "peak_over_event_peak"].map(|name| table.column(name));
        let (case, ratio) = (case?, ratio?);
        for row in 0..table.len() {
            if let Some(scales) = scales.get_mut(table.text(row, case)) {
                scales[0] = table.number(row, ratio);
            }
        }
    }
    Ok(scales)
}

/// Cases in which any of these rows has an answer.
fn cases_of<'a>(rows: impl IntoIterator<Item = &'a Row>) -> BTreeSet<&'a str> {
    rows.into_iter().flat_map(|row| row.values.keys()).map(|[case, ..]| &**case).collect()
}

/// Problems to which all rows with an answer in each case have one.
fn common(rows: &BTreeMap<String, Row>) -> BTreeSet<[String; 3]> {
    let cases = cases_of(rows.values());
    let whole: Vec<&Row> = rows.values().filter(|row| cases_of([*row]) == cases).collect();
    let answered = |problem: &[String; 3]| whole.iter().all(|row| row.values.contains_key(problem));
    whole.iter().flat_map(|row| row.values.keys()).filter(|own| answered(own)).cloned().collect()
}

/// Rows that have an answer in all cases, by class, untuned before tuned, by score over the problems to which all of
/// them have one.
fn ranked(mut rows: BTreeMap<String, Row>) -> Vec<Row> {
    let problems = common(&rows);
    let cases: BTreeSet<String> = cases_of(rows.values()).into_iter().map(str::to_owned).collect();
    rows.retain(|_, row| cases_of([&*row]).into_iter().eq(&cases));
    let mut groups = BTreeMap::<_, Vec<Row>>::new();
    for (label, mut row) in rows.into_iter().filter(|_| !problems.is_empty()) {
        row.values.retain(|problem, _| problems.contains(problem));
        row.by_case = row.means(0);
        row.score = as_error(mean(&row.by_case));
        row.others = std::array::from_fn(|rule| (mean(&row.means(rule + 1)), 0));
        row.label = label;
        groups.entry((row.class, !row.tuned_on.is_empty())).or_default().push(row);
    }
    groups.values_mut().for_each(|group| {
        let ranks = ranks(&group.iter().map(|row| &*row.by_case).collect::<Vec<_>>());
        group.iter_mut().zip(ranks).for_each(|(row, rank)| row.rank = rank);
        for rule in 0..RULES.len() {
            let scores: Vec<f64> = group.iter().map(|row| row.others[rule].0).collect();
            for row in group.iter_mut() {
                let own = row.others[rule].0;
                row.others[rule].1 = 1 + scores.iter().filter(|score| **score < own).count();
            }
        }
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
    let interval = interval_of_mean(values, &of);
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
            row.enter(
                &SummaryRow { keys, runs, completed, failed, no_answer, usable: completed, quartiles, worst: None },
                &Scales::new(),
            );
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
            row.values = steps.iter().map(|(step, value)| (["a", "", step].map(str::to_owned), [*value; 6])).collect();
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
