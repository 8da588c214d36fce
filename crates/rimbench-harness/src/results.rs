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

use super::evaluation::{COUNTERS, EvaluatedRun};
use super::experiment::PlannedRun;
use super::provenance::{self, Provenance};
use super::reference::Reference;
use super::store::{Record, Store};
use rimbench_cases::metrics::METRICS;
use rimbench_core::cosim::{Latency, Trajectory};
use rimbench_core::error::{Error, Result};
use rimbench_core::schemes::{ContactChoice, SchemeOptions};
use rimbench_results::atomic_file::write_atomically;
use std::io::Write;
use std::path::Path;
use std::sync::LazyLock;

/// What determines a run and how it ended; metrics and counters follow.
const FACTS: [&str; 22] = [
    "run_id",
    "case",
    "set",
    "label",
    "scheme",
    "sequence",
    "force_return",
    "mechanics_steps",
    "redundancy",
    "model_motion",
    "solver",
    "macro_step_s",
    "step_control",
    "step_tolerance",
    "min_macro_step_s",
    "phase",
    "micro_step_s",
    "duration_s",
    "outcome",
    "outcome_at_s",
    "reason",
    "ended_at_s",
];

const COST_HEADER: [&str; 10] = [
    "run_id",
    "label",
    "macro_step_s",
    "phase",
    "wall_s",
    "real_time_factor",
    "latency_p50_s",
    "latency_p99_s",
    "latency_max_s",
    "missed_deadlines",
];

/// Columns of `runs.csv`.
pub(super) static RUNS_HEADER: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let mut header = FACTS.to_vec();
    header.extend(METRICS.iter().map(|metric| metric.name));
    header.extend(["reference_force_uncertainty_n", "reference_position_uncertainty_m"]);
    header.extend(COUNTERS);
    header.push("trace");
    header
});

/// Motion of the model and, where not all of them take part, the choice of contacts.
fn model_motion(options: &SchemeOptions) -> String {
    match options.contacts {
        ContactChoice::All => options.motion.to_string(),
        contacts => format!("{} contacts={contacts}", options.motion),
    }
}

/// The rows of one run.
pub(super) fn record(planned: &PlannedRun, run: &EvaluatedRun, provenance: &Provenance, traced: bool) -> Record {
    let (id, spec) = (planned.id.as_str(), &planned.spec);
    let mechanics_steps = if spec.mechanics_steps == 0 { "all".to_owned() } else { spec.mechanics_steps.to_string() };
    let mut facts = vec![
        id.to_owned(),
        spec.case.name.to_owned(),
        planned.set.clone(),
        planned.label.clone(),
        spec.scheme.name.to_owned(),
        spec.sequence.to_string(),
        spec.force_return.to_string(),
        mechanics_steps,
        spec.options.redundancy.to_string(),
        model_motion(&spec.options),
        spec.solver.name.to_owned(),
        number(spec.macro_step),
        spec.step_control.to_string(),
        optional(spec.step_control.rule().map(|rule| rule.tolerance)),
        optional(spec.step_control.rule().map(|rule| rule.shortest)),
        number(spec.phase),
        number(spec.micro_step),
        number(spec.duration),
        run.outcome.name().to_owned(),
        optional(run.outcome.at_s()),
        run.outcome.reason(),
        number(run.ended_at_s),
    ];
    facts.extend(run.metrics.iter().copied().map(optional));
    facts.extend(run.reference_uncertainty.map(optional));
    facts.extend(run.counters.iter().map(u64::to_string));
    facts.push(if traced { format!("{id}.csv") } else { String::new() });
    let latency = |of: fn(&Latency) -> f64| optional(run.latency.as_ref().map(of));
    let cost = [
        id.to_owned(),
        planned.label.clone(),
        number(spec.macro_step),
        number(spec.phase),
        number(run.wall.as_secs_f64()),
        number(run.real_time_factor()),
        latency(|latency| latency.p50_s),
        latency(|latency| latency.p99_s),
        latency(|latency| latency.max_s),
        run.latency.map(|latency| latency.missed_deadlines.to_string()).unwrap_or_default(),
    ];
    Record { run: row(&facts), cost: row(&cost), provenance: row(&provenance.row(id)) }
}

/// Writes `runs.csv`, `cost.csv` and `provenance.csv` from the store, in the order of the plan, one row at a time.
///
/// # Errors
/// [`Error::File`] naming the file.
pub(super) fn write_tables(folder: &Path, planned: &[PlannedRun], store: &Store) -> Result<()> {
    // All three at once: reading and checking a record takes longer than writing its rows.
    let write = |runs: &mut dyn Write, cost: &mut dyn Write, provenance: &mut dyn Write| -> std::io::Result<()> {
        writeln!(runs, "{}", row(&RUNS_HEADER))?;
        writeln!(cost, "{}", row(&COST_HEADER))?;
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
        let case = run.spec.case.name;
        for (parameter, value) in run.spec.parameters.iter() {
            let value = value.to_string();
            parameters.push(row(&[case, &run.set, parameter.name, &value, parameter.unit, parameter.source]));
        }
        for (column, name) in reference.trajectory.columns().iter().enumerate().skip(1) {
            let (uncertainty, order) = (number(reference.uncertainty[column]), number(reference.order[column]));
            columns.push(row(&[case, &run.set, name, &uncertainty, &order, &number(reference.step)]));
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

fn optional(value: Option<f64>) -> String {
    value.map(number).unwrap_or_default()
}
