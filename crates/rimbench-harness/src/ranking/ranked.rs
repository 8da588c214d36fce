//! Ranks, scores and how sure they are, and the tables of them.

use super::entrants::{CHARGE, Entrant, Outcome, PROBLEM};
use crate::experiment::Verdict;
use crate::files::make_folder;
use rimbench_core::error::Result;
use rimbench_core::schemes::InformationClass;
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums;
use rimbench_statistics::{Pool, Rank, bootstrap_interval, ranks};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Shift of the geometric mean, so that errors which are all but zero do not decide it.
const SHIFT: f64 = 1e-3;

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
    /// Rows that lack problems.
    pub unranked: Vec<Unranked>,
    /// Claims.
    pub claims: Vec<CheckedRankClaim>,
    /// Problems, and cases they are of.
    pub problems: usize,
    /// Cases.
    pub cases: usize,
}

impl Ranked {
    /// Writes `ranking.csv` and `claims.csv` into a folder, with their checksums.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File).
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

pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Ranks who has all problems; returns also what every row has, in logarithms, by witness.
pub(super) fn rank(entrants: BTreeMap<String, Entrant>) -> (Ranked, BTreeMap<String, Vec<f64>>) {
    let problems: BTreeSet<Vec<String>> =
        entrants.values().flat_map(|entrant| entrant.outcomes.keys().cloned()).collect();
    let cases: BTreeSet<&String> = problems.iter().map(|problem| &problem[0]).collect();
    let cases = cases.len();
    // Cases are drawn, or phases where there is one case.
    let witness = |problem: &[String]| problem[if cases > 1 { 0 } else { PROBLEM.len() - 1 }].clone();
    let (mut unranked, mut values, mut groups) = (Vec::new(), BTreeMap::new(), BTreeMap::<_, Vec<String>>::new());
    for (name, entrant) in &entrants {
        let lacks = problems.iter().filter(|problem| !entrant.outcomes.contains_key(*problem)).count();
        if lacks > 0 {
            unranked.push(Unranked { label: name.clone(), why: format!("lacks {lacks} problems") });
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
    label: &str,
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
    let [exchanges, steps] = entrant.work.clone().map(|work| Pool::of(work).median());
    RankedRow {
        class: class.to_string(),
        tuned_on: entrant.tuned_on.iter().cloned().collect::<Vec<_>>().join(" "),
        rank: rank.first,
        rank_last: rank.last,
        label: label.to_owned(),
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
