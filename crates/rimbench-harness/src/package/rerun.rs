//! Some runs of a package once more: what another machine computed, held against what this one does.

use crate::execution::{Job, Shard, run_job};
use crate::experiment::PlannedRun;
use crate::results::{plan_header, runs_header};
use crate::stock::Stock;
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::ResultsTable;
use std::path::Path;

/// A cell that came out differently.
#[derive(Debug, Clone, PartialEq)]
pub struct Differing {
    /// Column of `runs.csv`.
    pub column: String,
    /// What the package says.
    pub stored: String,
    /// What came out now.
    pub found: String,
}

/// One run that was computed once more.
#[derive(Debug, Clone)]
pub struct Rerun {
    /// Its id.
    pub run_id: String,
    /// Scheme row.
    pub label: String,
    /// Macro step, s.
    pub macro_step_s: f64,
    /// What differs; nothing where every cell is the same to the letter.
    pub differing: Vec<Differing>,
}

/// Computes `count` runs of the results in `folder` once more, those with the smallest ids (hashes, so that cases, schemes and steps
/// are mixed), and compares every cell that does not depend on the machine. Runs that ended because they took too long say nothing and are left out. `job` is that of a folder of its own, empty.
///
/// # Errors
/// Those of [`run_job`].
pub fn rerun_sample(job: Job<'_>, planned: &[PlannedRun], folder: &Path, count: usize) -> Result<Vec<Rerun>> {
    let runs = ResultsTable::read(&folder.join("runs.csv"))?;
    let id = runs.column("run_id")?;
    let outcome = runs.column("outcome")?;
    let row_of = |run: &PlannedRun| (0..runs.len()).find(|&row| runs.text(row, id) == run.id);
    let mut sample: Vec<(usize, usize)> = planned
        .iter()
        .enumerate()
        .filter_map(|(place, run)| Some((place, row_of(run)?)))
        .filter(|&(_, row)| runs.text(row, outcome) != "timeout")
        .collect();
    sample.sort_by_key(|&(place, _)| &planned[place].id);
    sample.truncate(count);
    let (all, settings) = (runs_header(planned), plan_header(planned).len());
    // The last two cells are the wall limit and the trace.
    let compared = settings..all.len() - 2;
    let mut reruns = Vec::new();
    for (place, row) in sample {
        let run = &planned[place];
        run_job(Job { shard: Some(Shard::Places { first: place, last: place }), ..job }, &|_| (), StopFlag::never())?;
        let stock = Stock::open(job.folder, job.experiment, planned)?;
        let record = stock.store.read(&run.id)?;
        let record = record.ok_or_else(|| Error::file(job.folder, format!("record {} has gone", run.id)))?;
        let mut cells = csv::ReaderBuilder::new().has_headers(false).from_reader(record.findings.as_bytes());
        let cells = cells.records().next().transpose().map_err(|error| Error::file(job.folder, error))?;
        let found = cells.unwrap_or_default();
        let pairs = compared.clone().map(|column| (column, found.get(column - settings).unwrap_or_default()));
        let differing =
            pairs.filter(|&(column, found)| runs.text(row, column) != found).map(|(column, found)| Differing {
                column: all[column].to_owned(),
                stored: runs.text(row, column).to_owned(),
                found: found.to_owned(),
            });
        reruns.push(Rerun {
            run_id: run.id.clone(),
            label: run.label.clone(),
            macro_step_s: run.spec.macro_step,
            differing: differing.collect(),
        });
    }
    Ok(reruns)
}
