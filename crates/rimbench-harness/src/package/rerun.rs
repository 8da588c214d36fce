//! Some runs of a package once more: what another machine computed, held against what this one does.

use crate::execution::{Job, Shard, run_job};
use crate::experiment::PlannedRun;
use crate::files::read_text;
use crate::references::obtain_reference;
use crate::results::{plan_header, runs_header, write_references};
use crate::stock::Stock;
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums::sha256;
use rimbench_results::results_table::ResultsTable;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// A cell that came out differently.
#[derive(Debug, Clone, PartialEq)]
pub struct Differing {
    /// Column of `runs.csv`, or the table whose row it is.
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

/// Computes some runs of the results in `folder` that are `asked` for once more, as many as `count`, chosen by `seed`, and compares every cell of `runs.csv` that does not
/// depend on the machine, and what `reference.csv` and `parameters.csv` say of them; of what failed as a subsystem not the words. Runs that ended because they took longer than they
/// may say nothing and are left out. `job` is that of a folder of its own, empty.
///
/// # Errors
/// Those of [`run_job`]; [`Error::Stopped`] if `stop` was raised before all were done.
pub fn rerun_sample(
    job: Job<'_>,
    planned: &[PlannedRun],
    asked: impl Fn(&PlannedRun) -> bool,
    folder: &Path,
    (count, seed): (usize, u64),
    stop: StopFlag<'_>,
) -> Result<Vec<Rerun>> {
    let runs = ResultsTable::read(&folder.join("runs.csv"))?;
    let (id, outcome) = (runs.column("run_id")?, runs.column("outcome")?);
    let rows: HashMap<&str, usize> = (0..runs.len()).map(|row| (runs.text(row, id), row)).collect();
    // Only what was given a limit can have reached it.
    let says_nothing =
        |run: &PlannedRun, row: usize| run.spec.wall_limit.is_some() && runs.text(row, outcome) == "timeout";
    let mut sample: Vec<(usize, usize)> = planned
        .iter()
        .enumerate()
        .filter(|(_, run)| asked(run))
        .filter_map(|(place, run)| Some((place, *rows.get(run.id.as_str())?)))
        .filter(|&(place, row)| !says_nothing(&planned[place], row))
        .collect();
    // Nobody who writes a package can know which rows are looked at.
    sample.sort_by_cached_key(|&(place, _)| sha256(format!("{seed} {}", planned[place].id)));
    sample.truncate(count);
    let (all, settings) = (runs_header(planned), plan_header(planned).len());
    // The last two cells are the wall limit and the trace.
    let compared = settings..all.len() - 2;
    let reason = runs.column("reason")?;
    for &(place, _) in &sample {
        run_job(Job { shard: Some(Shard::Places { first: place, last: place }), ..job }, &|_| (), stop)?;
        // What was stopped has no record.
        if stop.check().is_err() {
            return Err(Error::Stopped);
        }
    }
    let stock = Stock::open(job.folder, job.experiment, planned)?;
    let mut reruns = Vec::new();
    for (place, row) in sample {
        let run = &planned[place];
        let record = stock.store.get(&run.id);
        let record = record.ok_or_else(|| Error::file(job.folder, format!("record {} has gone", run.id)))?;
        let mut cells = csv::ReaderBuilder::new().has_headers(false).from_reader(record.findings.as_bytes());
        let cells = cells.records().next().transpose().map_err(|error| Error::file(job.folder, error))?;
        let found = cells.unwrap_or_default();
        // In which words a program of its own fails may depend on what arrives first; that it fails, and when, does not.
        let same_failure =
            [runs.text(row, outcome), found.get(outcome - settings).unwrap_or_default()] == ["subsystem-failed"; 2];
        let columns = compared.clone().filter(|&column| !(same_failure && column == reason));
        let pairs = columns.map(|column| (column, found.get(column - settings).unwrap_or_default()));
        let differing =
            pairs.filter(|&(column, found)| runs.text(row, column) != found).map(|(column, found)| Differing {
                column: all[column].to_owned(),
                stored: runs.text(row, column).to_owned(),
                found: found.to_owned(),
            });
        let mut differing: Vec<Differing> = differing.collect();
        differing.extend(differing_tables(job, run, folder)?);
        reruns.push(Rerun {
            run_id: run.id.clone(),
            label: run.label.clone(),
            macro_step_s: run.spec.macro_step,
            differing,
        });
    }
    Ok(reruns)
}

/// Rows of the tables beside the runs that do not come out again for a run: its parameters and its reference.
fn differing_tables(job: Job<'_>, run: &PlannedRun, folder: &Path) -> Result<Vec<Differing>> {
    // A reference that took too long has no rows.
    let reference = match obtain_reference(&run.spec, job.cache, StopFlag::never()) {
        Err(Error::Overdue { .. }) => None,
        reference => Some(reference?),
    };
    write_references(job.folder, std::iter::once(Ok((&run.spec, reference))), None)?;
    let mut differing = Vec::new();
    for name in ["parameters.csv", "reference.csv"] {
        let [stored, found] = [folder, job.folder].map(|folder| read_text(&folder.join(name)));
        let (stored, found) = (stored?, found?);
        let known: HashSet<&str> = stored.lines().collect();
        let missing = found.lines().filter(|line| !known.contains(line));
        differing.extend(missing.map(|line| Differing {
            column: name.to_owned(),
            stored: "no such row".to_owned(),
            found: line.to_owned(),
        }));
    }
    Ok(differing)
}
