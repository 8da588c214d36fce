//! Results that an experiment may rest on: every planned run once, with its settings, and every file as it was written,
//! or as what is beside it says.

use super::experiment::{Experiment, PlannedRun};
use super::folder::{Folder, pooled_sets};
use super::results::{plan_cells, plan_header};
use rimbench_core::error::{Error, Result};
use rimbench_results::budget::check_budget;
use rimbench_results::checksums::{self, CHECKSUMS};
use rimbench_results::kept::{Digest, check_summary};
use rimbench_results::run_table::{Run, RunTable};
use rimbench_runs::catalogue::Catalogue;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// How far files are trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Trust {
    /// This process has just written them, and another that finishes the same job at once may be replacing what it has
    /// measured.
    Fresh,
    /// As far as their checksums say that they are as they were written.
    Sealed,
    /// Not at all: what can be made of something else that is there is made, and compared.
    Nothing,
}

/// Reads the `runs.csv` of an experiment's results folder, which must hold the runs of its plan, or of its quick plan.
///
/// # Errors
/// [`Error::File`] with the counts of what is missing, unplanned, there twice or different; with the files that are not
/// as they were written; for results that were held against another reference.
pub(super) fn checked_runs(
    experiment: &Experiment,
    catalogue: &Catalogue,
    folder: &Path,
    trust: Trust,
) -> Result<RunTable> {
    let rows = folder.join("runs.csv");
    if !rows.exists() {
        let (file, usual) = (experiment.path().display(), experiment.results_folder("results".as_ref()));
        let out = if folder == usual { String::new() } else { format!(" --out {}", folder.display()) };
        return Err(Error::file(rows, format!("is not there: `rimbench run {file}{out}` makes it")));
    }
    let runs = RunTable::read(&rows)?;
    let (mut planned, mut quick) = (experiment.plan(catalogue, false)?, false);
    if let Err(incomplete) = check_rows(experiment, &planned, &runs) {
        if !experiment.has_quick_plan() {
            return Err(incomplete);
        }
        (planned, quick) = (experiment.plan(catalogue, true)?, true);
        check_rows(experiment, &planned, &runs).map_err(|_| incomplete)?;
    }
    // What was run here is sealed; of a checkout few files are kept, and a digest.
    let is_checkout = || !folder.join(CHECKSUMS).exists() && !folder.join("cost.csv").exists();
    match trust {
        Trust::Fresh => {}
        Trust::Nothing if is_checkout() => {}
        Trust::Sealed | Trust::Nothing => checksums::verify(folder)?,
    }
    let copy = Experiment::read_from_results(folder)?;
    if copy.reference_identity() != experiment.reference_identity() {
        let message = format!("was computed with another reference_step_s than {} has", experiment.path().display());
        return Err(Error::file(folder, format!("{message}: run the experiment again")));
    }
    if trust == Trust::Nothing {
        let digest = Digest::of_this_version(folder)?;
        digest.check_rows(folder)?;
        digest.check_plan(folder, planned.len(), &experiment.sum_of_plan(catalogue, &planned, quick)?)?;
        check_summary(folder, &runs, &pooled_sets(&planned))?;
        if let Some(budgets) = experiment.budgets() {
            check_budget(folder, &runs, budgets, &pooled_sets(&planned))?;
        }
        if folder.join("records").is_dir() {
            Folder::check(folder, experiment, &planned)?;
        }
    }
    Ok(runs)
}

/// Ids that several runs of a plan have, under different labels.
fn twins(planned: &[PlannedRun]) -> HashSet<&str> {
    let mut seen = HashSet::new();
    planned.iter().map(|run| run.id.as_str()).filter(|id| !seen.insert(*id)).collect()
}

/// Holds the rows against the plan, whatever their order.
fn check_rows(experiment: &Experiment, planned: &[PlannedRun], table: &RunTable) -> Result<()> {
    let header = plan_header(planned);
    // Behind id and label.
    let settings: Vec<usize> = header[2..].iter().map(|name| table.setting(name)).collect::<Result<_>>()?;
    // By id, and label where one run has several; another label is told as such.
    let several: HashSet<&str> = twins(planned);
    let key = |id, label| (id, if several.contains(id) { label } else { "" });
    let mut rows: HashMap<(&str, &str), Vec<&Run>> = HashMap::new();
    for run in table.runs() {
        rows.entry(key(&*run.id, &*run.label)).or_default().push(run);
    }
    let (mut found, mut different) = (0, 0);
    let mut twice = 0;
    for run in planned {
        let Some(own) = rows.remove(&key(run.id.as_str(), run.label.as_str())) else { continue };
        found += 1;
        twice += own.len() - 1;
        let cells = plan_cells(run, &header);
        let is_set = |own: &Run| settings.iter().zip(&cells[2..]).all(|(&place, cell)| *own.settings[place] == **cell);
        let same = |own: &&Run| *own.label == *run.label && is_set(own);
        different += usize::from(!own.iter().all(same));
    }
    let unplanned: usize = rows.values().map(Vec::len).sum();
    let missing = planned.len() - found;
    if missing + unplanned + twice + different == 0 {
        return Ok(());
    }
    let counts = [
        (missing, "missing"),
        (unplanned, "not planned"),
        (twice, "there twice"),
        (different, "with another label or other settings"),
    ];
    let counts = counts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}"));
    let message = format!(
        "does not hold the runs of {}: {} planned, {found} found; {}: run the experiment again",
        experiment.path().display(),
        planned.len(),
        counts.collect::<Vec<_>>().join(", ")
    );
    Err(Error::file(table.path(), message))
}
