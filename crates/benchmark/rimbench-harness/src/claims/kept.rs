//! What can be said of claims without the rows they rest on: whether what is kept fits together.

use super::witnesses::OfFailed;
use crate::experiment::{Claim, Experiment, Statistic, Witnesses};
use rimbench_core::error::{Error, Result};
use rimbench_results::claims::{CheckedClaim, read_claims};
use rimbench_results::kept::{Digest, SUMMARY_METRICS, SummaryRow, read_summary};
use rimbench_results::selection::ALL;
use rimbench_runs::catalogue::Catalogue;
use rimbench_statistics::{PairedRatios, PairedRun, Pool};
use std::path::{Path, PathBuf};

/// The group whose claims stand together.
const GROUP: &str = "paper";

/// Relative difference that six written digits explain, of a ratio of two of them as well.
const ROUNDING: f64 = 3e-5;

/// Claims as they were last measured.
#[derive(Debug)]
pub struct KeptClaims {
    /// The claims, in the order of the experiment.
    pub claims: Vec<CheckedClaim>,
    /// How many of them the summary says as well.
    pub said_by_summary: usize,
}

/// Checks the `claims.csv` that is kept of an experiment against the experiment file and against its summary, which
/// must be that of its digest, and the digest of the experiment's plan, where the machine has what that needs. Each
/// verdict must follow from what was measured; claims about other statistics than a median, or about what failed runs
/// had come to, need the rows.
///
/// # Errors
/// [`Error::File`] for a file that is missing, damaged, or of another numerics version; for runs or claims that are not
/// those of the experiment, and for a number that is not that of the summary.
pub fn check_kept_claims(experiment: &Experiment, catalogue: &Catalogue, folder: &Path) -> Result<KeptClaims> {
    let summary = read_summary(folder)?;
    let digest = Digest::read(folder)?;
    match experiment.plan_at_first_draw(catalogue, false) {
        Ok(planned) => digest.check_plan(folder, planned.len(), &experiment.sum_at_first_draw(&planned))?,
        // What needs something that is not on every machine has no plan where that is not.
        Err(_) if experiment.needs.lacking().is_some() => {}
        Err(error) => return Err(error),
    }
    let mut kept = KeptClaims { claims: Vec::new(), said_by_summary: 0 };
    let Some((path, written)) = written_claims(experiment, folder)? else { return Ok(kept) };
    let wrong = |message: String| Err(Error::file(&path, format!("{message}: {}", remedy(experiment))));
    for (claim, mut checked) in experiment.claims().iter().zip(written) {
        if checked.expected != claim.expect.to_string() {
            let file = experiment.path().display();
            return wrong(format!("expects something else of `{}` than {file}", claim.id));
        }
        checked.finding = claim.finding;
        let refutable = [false, true].map(|other| claim.of_failed(other) == OfFailed::Against).contains(&true);
        let verdicts = [false, checked.failed > 0 && refutable].map(|refuted| claim.verdict(checked.measured, refuted));
        if !verdicts.contains(&checked.verdict) {
            return wrong(format!(
                "says {} of `{}`, which does not follow from what was measured",
                checked.verdict, claim.id
            ));
        }
        if let Some((expected, failed)) = claim.said_by(&summary) {
            let far = |measured: f64| (measured - expected).abs() > ROUNDING * expected.abs();
            if let Some(measured) = checked.measured.filter(|measured| far(*measured)) {
                return wrong(format!("measured {measured} for `{}`, and the summary says {expected}", claim.id));
            }
            if checked.failed != failed {
                let found = checked.failed;
                return wrong(format!(
                    "says that {found} runs of `{}` failed, and the summary says {failed}",
                    claim.id
                ));
            }
            kept.said_by_summary += 1;
        }
        kept.claims.push(checked);
    }
    Ok(kept)
}

/// Checks that the claims that are written of an experiment, if any are, are those that its rows give.
///
/// # Errors
/// [`Error::File`] naming the first that is not.
pub(super) fn check_written(experiment: &Experiment, folder: &Path, measured: &[CheckedClaim]) -> Result<()> {
    if !path_of_claims(folder).is_file() {
        return Ok(());
    }
    let Some((path, written)) = written_claims(experiment, folder)? else { return Ok(()) };
    for (own, written) in measured.iter().zip(written) {
        // `finding` and ids are those of the experiment file and of the rows, no part of the table.
        let same = CheckedClaim { finding: own.finding, run_ids: own.run_ids.clone(), ..written };
        if same != *own {
            let message = format!("says something else of `{}` than the rows: {}", own.id, remedy(experiment));
            return Err(Error::file(path, message));
        }
    }
    Ok(())
}

/// Where claims are written: those of a group that is run as a whole stand together.
fn path_of_claims(folder: &Path) -> PathBuf {
    let group = folder.parent().filter(|group| group.ends_with(GROUP));
    group.unwrap_or(folder).join("claims.csv")
}

/// Reads the claims that are written of an experiment, which must be those that it makes; none if it makes none.
fn written_claims(experiment: &Experiment, folder: &Path) -> Result<Option<(PathBuf, Vec<CheckedClaim>)>> {
    if experiment.claims().is_empty() {
        return Ok(None);
    }
    let path = path_of_claims(folder);
    let mut written = read_claims(&path)?;
    written.retain(|claim| claim.experiment == experiment.name());
    let made = experiment.claims().iter().map(|claim| &claim.id);
    if !written.iter().map(|claim| &claim.id).eq(made) {
        let message = format!("holds other claims than {}: {}", experiment.path().display(), remedy(experiment));
        return Err(Error::file(path, message));
    }
    Ok(Some((path, written)))
}

/// What writes the claims of an experiment.
fn remedy(experiment: &Experiment) -> String {
    match &*experiment.group() {
        GROUP => "`rimbench reproduce` writes it".to_owned(),
        _ => format!("`rimbench reproduce --everything --only {}` writes it", experiment.full_name()),
    }
}

impl Claim {
    /// What the summary says of it, with the number of runs that failed: where it is about the median of the completed
    /// runs of one row, or about ratios of two rows of which no run failed.
    fn said_by(&self, summary: &[SummaryRow]) -> Option<(f64, usize)> {
        let metric = SUMMARY_METRICS.iter().position(|name| *name == self.metric.name())?;
        // A summary pools drawn settings: medians of single problems are not in it.
        let is_pooled = summary.iter().any(|row| row.worst.is_some());
        // It holds medians with their sign.
        let counts = self.above.is_some() || self.within.is_some() || self.witnesses == Some(Witnesses::All);
        let other = self.at_equal.is_some() || self.is_by_magnitude() || counts;
        if self.statistic != Statistic::Median || other || is_pooled {
            return None;
        }
        let is = |text: &str, wanted: &Option<String>| {
            wanted.as_deref().is_none_or(|wanted| wanted == ALL || wanted == text)
        };
        let step = |row: &SummaryRow| row.keys[3].parse().ok();
        let is_asked = |row: &&SummaryRow| {
            let [case, set, label, ..] = &row.keys;
            let is_of_row = *label == self.scheme || Some(label) == self.relative_to.as_ref();
            is_of_row && is(case, &self.case) && is(set, &self.set) && step(row).is_some_and(|step| self.is_about(step))
        };
        let rows: Vec<&SummaryRow> = summary.iter().filter(is_asked).collect();
        let median = |row: &SummaryRow| row.quartiles[metric][1];
        if self.relative_to.is_none() {
            let [only] = rows[..] else { return None };
            return Some((median(only), only.failed)).filter(|(median, _)| !median.is_nan());
        }
        let says_less = |row: &&SummaryRow| !row.keys[4].is_empty() || row.failed + row.no_answer > 0;
        if rows.iter().any(says_less) {
            return None;
        }
        let runs = rows.iter().map(|row| PairedRun {
            problem: [&row.keys[0], &row.keys[1]],
            macro_step: step(row).unwrap_or(f64::NAN),
            is_other: row.keys[2] != self.scheme,
            error: median(row),
            floor: f64::NAN,
        });
        let ratio = Pool::of(PairedRatios::of(runs).ratios).median()?;
        Some((ratio, 0)).filter(|(ratio, _)| ratio.is_finite())
    }
}
