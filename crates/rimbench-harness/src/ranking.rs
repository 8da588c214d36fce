//! The ranking: which scheme row has least error over the cases, of those that know as much of the other side.
//!
//! ```text
//! ranking file ─► result files of its experiments ┐
//!                 submissions that were checked   ┴─► rows by class and tuning ─► problems ─► cases ─► score, rank
//! ```
//! A problem is a case with its parameters, at a macro step and a phase, with the micro step, the duration and the integrators. On each
//! of them a row has an error, which is the rms force error over the reference's peak, at most 1: a force that is wrong by its peak is
//! worth no more than none, and what diverged, failed, took too long or could not be run at all is charged the same. So no row gets
//! better by leaving something out, and the score of a row does not depend on who else is there.
//!
//! ```text
//! score = exp(mean over cases of the mean over its problems of ln(e + s)) − s          s = 0.1 % of the peak
//! ```
//! Ranks are those of [`ranks`]: cases are drawn, or phases where there is one case.

use super::checked_results::checked_runs;
use super::claims::Verdict;
use super::experiment::Experiment;
use super::files::{make_folder, read_text};
use super::submission::Accepted;
use rimbench_cases::catalogue::Catalogue;
use rimbench_core::error::{Error, Result, said_at};
use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_core::schemes::InformationClass;
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums;
use rimbench_results::results_table::ResultsTable;
use rimbench_statistics::{Rank, bootstrap_interval, median, ranks};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What is compared.
const ERROR: &str = "force_error_rms_of_peak";

/// Error that a failure is charged, and the most that any error counts.
const CHARGE: f64 = 1.0;

/// Shift of the geometric mean, so that errors which are all but zero do not decide it.
const SHIFT: f64 = 1e-3;

/// Columns that make a problem; of the law of friction only where it is a column.
const PROBLEM: [&str; 9] = [
    "case",
    "set",
    "duration_s",
    "micro_step_s",
    "mechanics_integrator",
    "actuator_integrator",
    "friction_law",
    "macro_step_s",
    "phase",
];

/// Columns of what can be chosen for a scheme row. Within a row they are the same on every problem: otherwise it would be several rows,
/// each where it is best.
pub(super) const OPTIONS: [&str; 13] = [
    "scheme",
    "sequence",
    "force_return",
    "mechanics_steps",
    "redundancy",
    "model_motion",
    "contact_detection",
    "contacts",
    "energy_return",
    "solver",
    "gain",
    "step_control",
    "step_tolerance",
];

/// The first of the [`OPTIONS`] in which two runs differ, and what it is in each.
pub(super) fn first_differing<'a>(one: &'a [String], other: &'a [String]) -> Option<(&'static str, &'a str, &'a str)> {
    let differs = |((option, one), other): ((&'static str, &'a String), &'a String)| {
        (one != other).then_some((option, one.as_str(), other.as_str()))
    };
    OPTIONS.into_iter().zip(one).zip(other).find_map(differs)
}

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

/// That one row is surely better than another of its group.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct RankClaim {
    id: String,
    text: String,
    /// Label of the row.
    row: String,
    /// Label of the other.
    ahead_of: String,
    finding: Verdict,
}

/// One row of the ranking, as `ranking.csv` has it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RankedRow {
    /// Class of information that it needs, by name.
    pub class: String,
    /// Cases that something of it was tuned on; empty if nothing was tuned.
    pub tuned_on: String,
    /// Who cannot be told from the best of its class is first.
    pub rank: usize,
    /// The worst that its rank may be.
    pub rank_last: usize,
    /// Label of the scheme row.
    pub label: String,
    /// Name of the submission; empty if it is one of this project's schemes.
    pub submission: String,
    /// Typical error, failures charged, of the peak force.
    pub score: f64,
    /// 95 % interval of it, by the bootstrap over cases.
    pub score_low: Option<f64>,
    /// Upper end of it.
    pub score_high: Option<f64>,
    /// Problems.
    pub problems: usize,
    /// Of these: diverged, failed, or took too long.
    pub failed: usize,
    /// Of these: could not be run, because the sides do not offer what it needs.
    pub skipped: usize,
    /// Exchanges per macro step that was asked for, median over the completed runs.
    pub exchanges_per_macro_step: Option<f64>,
    /// Steps of the mechanics, likewise.
    pub mechanics_steps_per_macro_step: Option<f64>,
}

/// A row that cannot be ranked, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unranked {
    /// Label of the scheme row.
    pub label: String,
    /// Name of the submission; empty if it is one of this project's schemes.
    pub submission: String,
    /// In words.
    pub why: String,
}

/// A claim with what was found.
#[derive(Debug, Clone, Serialize)]
pub struct CheckedRankClaim {
    /// Short name.
    pub id: String,
    /// In words.
    pub text: String,
    /// Label of the row.
    pub row: String,
    /// Label of the row that it should be ahead of.
    pub ahead_of: String,
    /// Error of the first over that of the second, both with the shift.
    pub measured: Option<f64>,
    /// 95 % interval of that.
    pub low: Option<f64>,
    /// Upper end of it.
    pub high: Option<f64>,
    /// Reproduced where the whole interval is below 1.
    pub verdict: Verdict,
    /// What was found when it was last looked at.
    pub finding: Verdict,
}

/// What came of a ranking.
#[derive(Debug, Clone)]
pub struct Ranked {
    /// Rows by class, untuned before tuned, by score.
    pub rows: Vec<RankedRow>,
    /// Rows that lack problems, or were computed by other numerics.
    pub unranked: Vec<Unranked>,
    /// Claims.
    pub claims: Vec<CheckedRankClaim>,
    /// Problems, and cases they are of.
    pub problems: usize,
    /// Cases.
    pub cases: usize,
}

/// One run of a row.
#[derive(Debug, Clone, Copy)]
struct Outcome {
    error: f64,
    failed: bool,
    skipped: bool,
}

/// What is known of a row before it is ranked.
#[derive(Debug, Clone)]
struct Entrant {
    class: InformationClass,
    tuned_on: BTreeSet<String>,
    outcomes: BTreeMap<Vec<String>, Outcome>,
    /// Its [`OPTIONS`], and the case of the run that has them; of runs on cases that it was not tuned on.
    options: Option<(Vec<String>, String)>,
    /// Per macro step, of completed runs: exchanges, steps of the mechanics.
    work: [Vec<f64>; 2],
}

/// Submission and label.
type Name = (String, String);

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
        let twice = |index: usize| ranking.claims[..index].iter().any(|earlier| earlier.id == ranking.claims[index].id);
        match (0..ranking.claims.len()).find(|&index| twice(index)) {
            Some(index) => Err(Error::file(path, format!("two claims have the id `{}`", ranking.claims[index].id))),
            None => Ok(ranking),
        }
    }

    /// Returns the experiment files.
    pub fn experiments(&self) -> Vec<PathBuf> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        self.experiments.iter().map(|file| folder.join(file)).collect()
    }

    /// Ranks the rows of its experiments, whose results lie below `results`, and those of submissions.
    ///
    /// # Errors
    /// [`Error::File`] for results that are not there, not whole, or not as they were written; for submissions that were held against
    /// other references; for claims about rows that are not ranked, or not in one group.
    pub fn rank(&self, catalogue: &Catalogue, results: &Path, submissions: &[Accepted]) -> Result<Ranked> {
        let mut entrants: BTreeMap<Name, Entrant> = BTreeMap::new();
        for file in self.experiments() {
            let experiment = Experiment::read(&file)?;
            let (runs, _) = checked_runs(&experiment, catalogue, &experiment.results_folder(results))?;
            if !experiment.reference_identity().is_empty() {
                let message = "has a reference_step_s of its own: only what is held against the cases' own references can be ranked";
                return Err(Error::file(file, message));
            }
            enter(&mut entrants, &runs, "", |row| of_catalogue(catalogue, &runs, row))?;
        }
        let mut older = Vec::new();
        for submission in submissions {
            // Digits of other numerics are not those of the rows beside them.
            if submission.numerics.as_deref() != Some(NUMERICS_VERSION.to_string().as_str()) {
                let by = submission.numerics.as_deref().unwrap_or("of a version that is not written down");
                let (label, submission) = (submission.name.clone(), submission.name.clone());
                older.push(Unranked { label, submission, why: format!("computed by numerics {by}; check it again") });
                continue;
            }
            for runs in &submission.runs {
                enter(&mut entrants, runs, &submission.name, |row| submission.entry(runs, row))?;
            }
        }
        let (mut ranked, values) = rank(entrants);
        ranked.unranked.append(&mut older);
        self.with_claims((ranked, values))
    }

    fn with_claims(&self, (mut ranked, values): (Ranked, BTreeMap<Name, Vec<f64>>)) -> Result<Ranked> {
        for claim in &self.claims {
            let named = |label: &str| {
                let row = ranked.rows.iter().find(|row| row.submission.is_empty() && row.label == label);
                row.ok_or_else(|| {
                    let own = ranked.rows.iter().filter(|row| row.submission.is_empty());
                    let error = Error::unknown("row of a claim", label, own.map(|row| row.label.as_str()));
                    Error::file(&self.path, format!("claim `{}`: {error}", claim.id))
                })
            };
            let [one, other] = [named(&claim.row)?, named(&claim.ahead_of)?];
            if (&one.class, one.tuned_on.is_empty()) != (&other.class, other.tuned_on.is_empty()) {
                let message = format!(
                    "claim `{}`: `{}` and `{}` are not ranked together, being of different classes, or one of them tuned",
                    claim.id, claim.row, claim.ahead_of
                );
                return Err(Error::file(&self.path, message));
            }
            let of = |row: &RankedRow| &values[&(row.submission.clone(), row.label.clone())];
            let differences: Vec<Vec<f64>> = of(one).iter().zip(of(other)).map(|(a, b)| vec![a - b]).collect();
            let ratio = |values: Vec<f64>| mean(&values).map(libm::exp);
            let measured = ratio(differences.concat());
            let interval = bootstrap_interval(&differences, ratio);
            let verdict = match interval {
                None => Verdict::NotMeasured,
                Some([_, high]) if high < 1.0 => Verdict::Reproduced,
                Some(_) => Verdict::NotReproduced,
            };
            ranked.claims.push(CheckedRankClaim {
                id: claim.id.clone(),
                text: claim.text.clone(),
                row: claim.row.clone(),
                ahead_of: claim.ahead_of.clone(),
                measured,
                low: interval.map(|[low, _]| low),
                high: interval.map(|[_, high]| high),
                verdict,
                finding: claim.finding,
            });
        }
        Ok(ranked)
    }
}

impl Ranked {
    /// Writes `ranking.csv` and `claims.csv` into a folder, with their checksums.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn write(&self, folder: &Path) -> Result<()> {
        make_folder(folder)?;
        write_rows(&folder.join("ranking.csv"), &self.rows)?;
        write_rows(&folder.join("claims.csv"), &self.claims)?;
        checksums::write(folder, ["ranking.csv", "claims.csv"].map(str::to_owned))
    }
}

fn write_rows<T: Serialize>(path: &Path, rows: &[T]) -> Result<()> {
    write_atomically(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        rows.iter().try_for_each(|row| writer.serialize(row))?;
        writer.flush()
    })
}

/// What a scheme of the catalogue needs, and what it was tuned on: a gain that is not the default was chosen by somebody on something.
fn of_catalogue(
    catalogue: &Catalogue,
    runs: &ResultsTable,
    row: usize,
) -> Result<Option<(InformationClass, BTreeSet<String>)>> {
    let scheme = catalogue.scheme(runs.text(row, runs.column("scheme")?))?;
    let gain = runs.number(row, runs.column("gain")?);
    let usual = scheme.gain.as_ref().is_none_or(|known| gain.is_nan() || gain == known.default);
    let tuned_on =
        if usual { BTreeSet::new() } else { BTreeSet::from([runs.text(row, runs.column("case")?).to_owned()]) };
    Ok(Some((class_of_run(InformationClass::of(scheme), runs, row)?, tuned_on)))
}

/// The class of a run: control of the macro step takes steps again, whatever the scheme.
pub(super) fn class_of_run(of_scheme: InformationClass, runs: &ResultsTable, row: usize) -> Result<InformationClass> {
    let controlled = runs.text(row, runs.column("step_control")?) != "none";
    Ok(if controlled { of_scheme.max(InformationClass::Repetition) } else { of_scheme })
}

/// Enters the runs of a table; `who` says class and tuning of a run, or that it is none of the submission's.
///
/// # Errors
/// [`Error::File`] for a row that has other options on one problem than on another, unless it was tuned on that case.
fn enter(
    entrants: &mut BTreeMap<Name, Entrant>,
    runs: &ResultsTable,
    submission: &str,
    who: impl Fn(usize) -> Result<Option<(InformationClass, BTreeSet<String>)>>,
) -> Result<()> {
    let problem: Vec<Option<usize>> = PROBLEM.iter().map(|name| runs.column(name).ok()).collect();
    let [label, outcome, error, step, duration] =
        ["label", "outcome", ERROR, "macro_step_s", "duration_s"].map(|name| runs.column(name));
    let (label, outcome, error, step, duration) = (label?, outcome?, error?, step?, duration?);
    let options = OPTIONS.map(|name| runs.column(name).ok());
    let counters = [runs.column("exchanges")?, runs.column("mechanics_micro_steps")?];
    for row in 0..runs.len() {
        let Some((class, tuned_on)) = who(row)? else { continue };
        // Where no column speaks of it the law is Coulomb's.
        let cell = |column: &Option<usize>| column.map_or("coulomb", |column| runs.text(row, column)).to_owned();
        let key: Vec<String> = problem.iter().map(cell).collect();
        let ended = runs.text(row, outcome);
        let value = runs.number(row, error);
        let error = if ended == "completed" && value.is_finite() { value.min(CHARGE) } else { CHARGE };
        let skipped = ended == "skipped";
        let failed = ended != "completed" && !skipped;
        let entrant =
            entrants.entry((submission.to_owned(), runs.text(row, label).to_owned())).or_insert_with(|| Entrant {
                class,
                tuned_on: BTreeSet::new(),
                outcomes: BTreeMap::new(),
                options: None,
                work: [Vec::new(), Vec::new()],
            });
        let case = &key[0];
        if !tuned_on.contains(case) {
            let own: Vec<String> =
                options.iter().map(|column| column.map_or("", |column| runs.text(row, column)).to_owned()).collect();
            let (known, there) = entrant.options.get_or_insert_with(|| (own.clone(), case.clone()));
            if let Some((option, was, is)) = first_differing(known, &own) {
                let message = format!(
                    "row `{}` has {option} = `{was}` on `{there}` and `{is}` on `{case}`: what is ranked under one label is the same \
                     everywhere",
                    runs.text(row, label)
                );
                return Err(Error::file(runs.path(), message));
            }
        }
        entrant.class = entrant.class.max(class);
        entrant.tuned_on.extend(tuned_on);
        // One row that was run several ways on a problem, as with several gains, has the worst of them: none was chosen beforehand.
        let known = entrant.outcomes.entry(key).or_insert(Outcome { error, failed, skipped });
        if error > known.error || failed {
            *known = Outcome { error, failed, skipped };
        }
        if ended == "completed" {
            let steps = (runs.number(row, duration) / runs.number(row, step)).max(1.0);
            for (work, &counter) in entrant.work.iter_mut().zip(&counters) {
                work.push(runs.number(row, counter) / steps);
            }
        }
    }
    Ok(())
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Ranks who has all problems; returns also what every row has, in logarithms, by witness.
fn rank(entrants: BTreeMap<Name, Entrant>) -> (Ranked, BTreeMap<Name, Vec<f64>>) {
    // What a submission has more is its own affair, and no reason for anybody to lack it.
    let own = |name: &Name| name.0.is_empty();
    let problems: BTreeSet<Vec<String>> = entrants
        .iter()
        .filter(|(name, _)| own(name))
        .flat_map(|(_, entrant)| entrant.outcomes.keys().cloned())
        .collect();
    let cases: BTreeSet<&String> = problems.iter().map(|problem| &problem[0]).collect();
    let cases = cases.len();
    // Cases are drawn, or phases where there is one case.
    let witness = |problem: &[String]| problem[if cases > 1 { 0 } else { PROBLEM.len() - 1 }].clone();
    let (mut unranked, mut values, mut groups) = (Vec::new(), BTreeMap::new(), BTreeMap::<_, Vec<Name>>::new());
    for (name, entrant) in &entrants {
        let lacks = problems.iter().filter(|problem| !entrant.outcomes.contains_key(*problem)).count();
        if lacks > 0 {
            let (submission, label) = name.clone();
            unranked.push(Unranked { label, submission, why: format!("lacks {lacks} problems") });
            continue;
        }
        let mut of_witness: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        for problem in &problems {
            let value = libm::log(entrant.outcomes[problem].error + SHIFT);
            of_witness.entry(witness(problem)).or_default().push(value);
        }
        values.insert(name.clone(), of_witness.values().filter_map(|own| mean(own)).collect::<Vec<f64>>());
        groups.entry((entrant.class, !entrant.tuned_on.is_empty())).or_default().push(name.clone());
    }
    let mut rows = Vec::new();
    for ((class, _), names) in groups {
        let of_group: Vec<Vec<f64>> = names.iter().map(|name| values[name].clone()).collect();
        let mut group: Vec<RankedRow> = names
            .iter()
            .zip(ranks(&of_group))
            .map(|(name, rank)| ranked_row(name, class, rank, &entrants[name], &values[name], &problems))
            .collect();
        group.sort_by(|a, b| a.score.total_cmp(&b.score).then_with(|| a.label.cmp(&b.label)));
        rows.extend(group);
    }
    (Ranked { rows, unranked, claims: Vec::new(), problems: problems.len(), cases }, values)
}

fn ranked_row(
    name: &Name,
    class: InformationClass,
    rank: Rank,
    entrant: &Entrant,
    values: &[f64],
    problems: &BTreeSet<Vec<String>>,
) -> RankedRow {
    let score = |values: Vec<f64>| mean(&values).map(|mean| libm::exp(mean) - SHIFT);
    let witnesses: Vec<Vec<f64>> = values.iter().map(|value| vec![*value]).collect();
    let interval = bootstrap_interval(&witnesses, score);
    let count = |is: fn(&Outcome) -> bool| problems.iter().filter(|problem| is(&entrant.outcomes[*problem])).count();
    let (submission, label) = name.clone();
    let [exchanges, steps] = entrant.work.clone().map(median);
    RankedRow {
        class: class.to_string(),
        tuned_on: entrant.tuned_on.iter().cloned().collect::<Vec<_>>().join(" "),
        rank: rank.first,
        rank_last: rank.last,
        label,
        submission,
        score: score(values.to_vec()).unwrap_or(CHARGE),
        score_low: interval.map(|[low, _]| low),
        score_high: interval.map(|[_, high]| high),
        problems: problems.len(),
        failed: count(|outcome| outcome.failed),
        skipped: count(|outcome| outcome.skipped),
        exchanges_per_macro_step: exchanges,
        mechanics_steps_per_macro_step: steps,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "label,case,set,scheme,mechanics_integrator,actuator_integrator,gain,macro_step_s,step_control,phase,\
                          micro_step_s,duration_s,outcome,force_error_rms_of_peak,exchanges,mechanics_micro_steps";

    /// Rows of label, case, phase, outcome, error.
    fn entered(rows: &[(&str, &str, &str, &str, &str)]) -> BTreeMap<Name, Entrant> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        let lines: Vec<String> = rows
            .iter()
            .map(|(label, case, phase, outcome, error)| {
                format!("{label},{case},,nepce,a,b,,0.001,none,{phase},1e-4,1.0,{outcome},{error},2000,1000\n")
            })
            .collect();
        std::fs::write(&path, format!("{HEADER}\n{}", lines.concat())).unwrap();
        let runs = ResultsTable::read(&path).unwrap();
        let mut entrants = BTreeMap::new();
        enter(&mut entrants, &runs, "", |_| Ok(Some((InformationClass::Samples, BTreeSet::new())))).unwrap();
        entrants
    }

    #[test]
    fn a_failure_counts_as_the_whole_peak_and_an_error_beyond_it_no_more() {
        let (ranked, _) = rank(entered(&[
            ("good", "a", "1.0", "completed", "0.01"),
            ("good", "b", "1.0", "completed", "0.01"),
            ("fails", "a", "1.0", "diverged", "0.0"),
            ("fails", "b", "1.0", "completed", "0.01"),
            ("wild", "a", "1.0", "completed", "1e9"),
            ("wild", "b", "1.0", "completed", "0.01"),
            ("absent", "a", "1.0", "skipped", ""),
            ("absent", "b", "1.0", "timeout", ""),
        ]));
        let scores: Vec<(&str, f64, usize, usize)> =
            ranked.rows.iter().map(|row| (row.label.as_str(), row.score, row.failed, row.skipped)).collect();
        assert_eq!(scores[0].0, "good");
        approx::assert_relative_eq!(scores[0].1, 0.01, max_relative = 1e-12);
        // √(0.011 · 1.001) − 0.001, whether it fails or is wrong beyond the peak.
        let half = (0.011_f64 * 1.001).sqrt() - 1e-3;
        assert_eq!([scores[1].0, scores[2].0], ["fails", "wild"]);
        approx::assert_relative_eq!(scores[1].1, half, max_relative = 1e-12);
        assert_eq!(scores[1].1, scores[2].1);
        assert_eq!([scores[1].2, scores[2].2], [1, 0]);
        assert_eq!((scores[3].0, scores[3].2, scores[3].3), ("absent", 1, 1));
        approx::assert_relative_eq!(scores[3].1, 1.0, max_relative = 1e-12);
        assert_eq!((ranked.problems, ranked.cases), (2, 2));
        assert_eq!(ranked.rows[0].exchanges_per_macro_step, Some(2.0));
    }

    #[test]
    fn who_lacks_a_problem_is_not_ranked_and_cases_weigh_the_same_whatever_their_number_of_problems() {
        let (ranked, values) = rank(entered(&[
            ("whole", "a", "1.0", "completed", "0.1"),
            ("whole", "a", "0.5", "completed", "0.1"),
            ("whole", "a", "0.2", "completed", "0.1"),
            ("whole", "b", "1.0", "completed", "0.001"),
            ("part", "a", "1.0", "completed", "0.001"),
        ]));
        assert_eq!(
            ranked.unranked,
            [Unranked { label: "part".into(), submission: String::new(), why: "lacks 3 problems".into() }]
        );
        approx::assert_relative_eq!(ranked.rows[0].score, (0.101_f64 * 0.002).sqrt() - 1e-3, max_relative = 1e-12);
        assert_eq!(values.len(), 1);
    }

    #[test]
    fn a_row_that_is_another_scheme_on_another_case_is_refused_unless_it_was_tuned_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        let row = |case: &str, control: &str| {
            format!("mine,{case},,nepce,a,b,,0.001,{control},1.0,1e-4,1.0,completed,0.1,2000,1000\n")
        };
        std::fs::write(&path, format!("{HEADER}\n{}{}", row("a", "none"), row("b", "energy-residual"))).unwrap();
        let runs = ResultsTable::read(&path).unwrap();
        let entered = |tuned_on: &[&str]| {
            let tuned_on: BTreeSet<String> = tuned_on.iter().map(|case| (*case).to_owned()).collect();
            enter(&mut BTreeMap::new(), &runs, "mine", |_| Ok(Some((InformationClass::Samples, tuned_on.clone()))))
        };
        let said = entered(&[]).unwrap_err().to_string();
        assert!(said.contains("row `mine` has step_control = `none` on `a` and `energy-residual` on `b`"), "{said}");
        entered(&["b"]).unwrap();
    }

    #[test]
    fn what_is_no_ranking_is_refused_with_its_place() {
        let good = "question = \"?\"\nexperiments = [\"a.toml\"]\n[[claims]]\nid = \"x\"\ntext = \"t\"\nrow = \"a\"\nahead_of = \"b\"\n\
                    finding = \"reproduced\"\n";
        Ranking::parse(Path::new("r.toml"), good).unwrap();
        let twice = format!("{good}{}", &good[good.find("[[claims]]").unwrap()..]);
        for (text, wanted) in [
            (good.replace("experiments", "experimens"), "line 2"),
            (good.replace("\"a.toml\"", ""), "at least one experiment file"),
            (good.replace("\"reproduced\"", "\"yes\""), "unknown variant `yes`"),
            (twice, "two claims have the id `x`"),
        ] {
            let said = Ranking::parse(Path::new("r.toml"), &text).unwrap_err().to_string();
            assert!(said.starts_with("r.toml: ") && said.contains(wanted), "{said}");
        }
    }
}
