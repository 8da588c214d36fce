//! The files of an experiment.
//!
//! ```text
//! runs.csv        one row per run: what determines it, outcome, metrics, counters; deterministic
//! cost.csv        one row per run: wall time, latency of macro steps; machine-dependent
//! provenance.csv  one row per run: revision, lock file, compiler, processor, load
//! parameters.csv  every parameter of every case, resolved
//! reference.csv   uncertainty and observed order of the reference, per column
//! traces/         one file per run, and the reference, where the experiment asks for them
//! records/        the store (see [`Store`]); not a result
//! ```

use super::experiment::PlannedRun;
use super::provenance::{self, Provenance};
use super::store::{Record, Store};
use rimbench_cases::runs::{EvaluatedRun, Fact, Reference};
use rimbench_core::cosim::{Outcome, Trajectory};
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use std::io::Write;
use std::path::Path;

/// Columns of `runs.csv`: id and label, what determines a run, what was found.
pub(super) fn runs_header(planned: &[PlannedRun]) -> Vec<&'static str> {
    let facts = planned.first().map(|run| run.spec.facts()).unwrap_or_default();
    let mut header = vec!["run_id", "label"];
    header.extend(facts.iter().chain(&nothing_found().findings()).map(|fact| fact.name));
    header.push("trace");
    header
}

/// Columns of `cost.csv`.
fn cost_header() -> Vec<&'static str> {
    let mut header = vec!["run_id", "label", "macro_step_s", "phase"];
    header.extend(nothing_found().costs().iter().map(|fact| fact.name));
    header
}

/// A run of which nothing is known, for the names of what is found.
fn nothing_found() -> EvaluatedRun {
    EvaluatedRun::not_evaluated(Outcome::Completed)
}

/// The rows of one run.
pub(super) fn record(planned: &PlannedRun, run: &EvaluatedRun, provenance: &Provenance, traced: bool) -> Record {
    let (id, label, spec) = (&planned.id, &planned.label, &planned.spec);
    let cells = |facts: Vec<Fact>| facts.into_iter().map(|fact| fact.cell());
    let mut runs = vec![id.clone(), label.clone()];
    runs.extend(cells(spec.facts()).chain(cells(run.findings())));
    runs.push(if traced { format!("{id}.csv") } else { String::new() });
    let mut cost = vec![id.clone(), label.clone(), number(spec.macro_step), number(spec.phase)];
    cost.extend(cells(run.costs()));
    Record { run: row(&runs), cost: row(&cost), provenance: row(&provenance.row(id)) }
}

/// Writes `runs.csv`, `cost.csv` and `provenance.csv` from the store, in the order of the plan, one row at a time.
///
/// # Errors
/// [`Error::File`] naming the file.
pub(super) fn write_tables(folder: &Path, planned: &[PlannedRun], store: &Store) -> Result<()> {
    // All three at once: reading and checking a record takes longer than writing its rows.
    let write = |runs: &mut dyn Write, cost: &mut dyn Write, provenance: &mut dyn Write| -> std::io::Result<()> {
        writeln!(runs, "{}", row(&runs_header(planned)))?;
        writeln!(cost, "{}", row(&cost_header()))?;
        writeln!(provenance, "{}", row(&provenance::HEADER))?;
        for PlannedRun { id, .. } in planned {
            let record = store.read(id).map_err(std::io::Error::other)?;
            let record = record.ok_or_else(|| std::io::Error::other(format!("record {id} has gone")))?;
            writeln!(runs, "{}", record.run)?;
            writeln!(cost, "{}", record.cost)?;
            writeln!(provenance, "{}", record.provenance)?;
        }
        Ok(())
    };
    let [runs, cost, provenance] = ["runs.csv", "cost.csv", "provenance.csv"].map(|name| folder.join(name));
    write_atomically(&runs, |runs| {
        let of_machine = write_atomically(&cost, |cost| {
            write_atomically(&provenance, |provenance| write(runs, cost, provenance)).map_err(std::io::Error::other)
        });
        of_machine.map_err(std::io::Error::other)
    })
}

/// Writes `parameters.csv`, `reference.csv` and the traces of the references, one reference at a time.
///
/// # Errors
/// [`Error::File`] naming the file; whatever makes a reference fail.
pub(super) fn write_references<'a>(
    folder: &Path,
    references: impl Iterator<Item = Result<(&'a PlannedRun, Reference)>>,
    trace_every_s: Option<f64>,
) -> Result<()> {
    let mut parameters = vec![row(&["case", "set", "parameter", "value", "unit", "source"])];
    let mut columns = vec![row(&["case", "set", "column", "rms_uncertainty", "observed_order", "finest_step_s"])];
    for (index, found) in references.enumerate() {
        let (run, reference) = found?;
        let (case, set) = (&*run.spec.case.name, run.spec.parameters.changed());
        for (parameter, value) in run.spec.parameters.iter() {
            let value = value.to_string();
            parameters.push(row(&[case, &set, &parameter.name, &value, &parameter.unit, &parameter.source]));
        }
        for (column, name) in reference.trajectory.columns().iter().enumerate().skip(1) {
            let (uncertainty, order) = (number(reference.uncertainty[column]), number(reference.order[column]));
            columns.push(row(&[case, &set, name, &uncertainty, &order, &number(reference.step)]));
        }
        if let Some(every) = trace_every_s {
            let name = if index == 0 { "reference.csv".to_owned() } else { format!("reference-{}.csv", index + 1) };
            write_trace(folder, &name, &reference.trajectory, every)?;
        }
    }
    for (name, rows) in [("parameters.csv", parameters), ("reference.csv", columns)] {
        write_atomically(&folder.join(name), |file| rows.iter().try_for_each(|row| writeln!(file, "{row}")))?;
    }
    Ok(())
}

/// Writes a trajectory to the folder's traces, thinned to one row per `every` seconds; first and last rows always stand.
///
/// # Errors
/// [`Error::File`] naming the file.
pub(super) fn write_trace(folder: &Path, name: &str, trajectory: &Trajectory, every: f64) -> Result<()> {
    let traces = folder.join("traces");
    std::fs::create_dir_all(&traces).map_err(|error| Error::file(&traces, format!("cannot be made: {error}")))?;
    write_atomically(&traces.join(name), |file| {
        let mut table = csv::Writer::from_writer(file);
        table.write_record(trajectory.columns())?;
        let mut next = 0_u64;
        let last = trajectory.len().saturating_sub(1);
        for (index, row) in trajectory.rows().enumerate() {
            // Slack for times that are multiples of `every` up to round-off.
            if row[0] + 1e-9 * every < next as f64 * every && index != last {
                continue;
            }
            next = (row[0] / every + 1e-9).floor() as u64 + 1;
            table.write_record(row.iter().map(|value| number(*value)))?;
        }
        table.flush()
    })
}

/// Copies the trace of a run from the results folder of a shard, if it has one.
///
/// # Errors
/// [`Error::File`] naming the file.
pub(super) fn copy_trace(from: &Path, to: &Path, id: &str) -> Result<()> {
    let name = format!("{id}.csv");
    let Ok(content) = std::fs::read(from.join("traces").join(&name)) else { return Ok(()) };
    let traces = to.join("traces");
    std::fs::create_dir_all(&traces).map_err(|error| Error::file(&traces, format!("cannot be made: {error}")))?;
    write_atomically(&traces.join(&name), |file| file.write_all(&content))
}

/// One CSV row without its line end.
fn row<T: AsRef<[u8]>>(cells: &[T]) -> String {
    let mut writer = csv::WriterBuilder::new().from_writer(Vec::new());
    // Writing to memory cannot fail.
    let bytes = writer.write_record(cells).ok().and_then(|()| writer.into_inner().ok()).unwrap_or_default();
    String::from_utf8_lossy(&bytes).trim_end_matches('\n').to_owned()
}

/// Shortest text that reads back to the same bits; `inf` and `NaN` where it is so.
fn number(value: f64) -> String {
    format!("{value:?}")
}
