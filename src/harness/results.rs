//! The files of an executed experiment.
//!
//! ```text
//! runs.csv        one row per run: what determines it, outcome, metrics, counters; deterministic
//! cost.csv        one row per run: wall time; machine-dependent
//! provenance.csv  one row per run: revision, lock file, compiler, processor
//! parameters.csv  every parameter of every case, resolved
//! reference.csv   uncertainty and observed order of the reference, per column
//! traces/         one file per run, and the reference, where the experiment asks for them
//! ```

use super::atomic_file::write_atomically;
use super::execution::{Executed, ExecutedRun};
use super::provenance::Provenance;
use crate::cosim::Trajectory;
use crate::error::{Error, Result};
use crate::metrics::METRICS;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// Writes all files of an executed experiment to `folder`.
///
/// # Errors
/// [`Error::File`] naming the file that cannot be written.
pub fn write_results(folder: &Path, executed: &Executed, provenance: &Provenance) -> Result<()> {
    let traces = folder.join("traces");
    let needed = if executed.experiment.trace_every_s.is_some() { &traces } else { folder };
    std::fs::create_dir_all(needed).map_err(|error| Error::file(needed, format!("cannot be made: {error}")))?;
    write_table(&folder.join("runs.csv"), |table| runs_table(table, executed))?;
    write_table(&folder.join("cost.csv"), |table| cost_table(table, executed))?;
    write_table(&folder.join("provenance.csv"), |table| provenance_table(table, executed, provenance))?;
    write_table(&folder.join("parameters.csv"), |table| parameters_table(table, executed))?;
    write_table(&folder.join("reference.csv"), |table| reference_table(table, executed))?;
    if let Some(every) = executed.experiment.trace_every_s {
        for run in &executed.runs {
            let path = traces.join(trace_name(run));
            write_table(&path, |table| trace_table(table, &run.evaluated.trajectory, every))?;
        }
        for (index, run) in distinct_references(executed).into_iter().enumerate() {
            let path = traces.join(reference_name(index));
            write_table(&path, |table| trace_table(table, &run.reference.trajectory, every))?;
        }
    }
    Ok(())
}

type Table<'a> = csv::Writer<&'a mut dyn Write>;

fn write_table(path: &Path, fill: impl FnOnce(&mut Table<'_>) -> csv::Result<()>) -> Result<()> {
    write_atomically(path, |file| {
        let mut table = csv::Writer::from_writer(file);
        fill(&mut table)?;
        table.flush()
    })
}

fn runs_table(table: &mut Table<'_>, executed: &Executed) -> csv::Result<()> {
    let mut header: Vec<String> = [
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
        "phase",
        "micro_step_s",
        "duration_s",
        "outcome",
        "outcome_at_s",
        "reason",
        "ended_at_s",
    ]
    .map(str::to_owned)
    .into();
    header.extend(METRICS.iter().map(|metric| metric.name.to_owned()));
    header.extend(["reference_force_uncertainty_n", "reference_position_uncertainty_m"].map(str::to_owned));
    if let Some(run) = executed.runs.first() {
        header.extend(run.evaluated.counters.iter().map(|(name, _)| (*name).to_owned()));
    }
    header.push("trace".to_owned());
    table.write_record(&header)?;
    for run in &executed.runs {
        let (spec, evaluated) = (&run.planned.spec, &run.evaluated);
        let mechanics_steps =
            if spec.mechanics_steps == 0 { "all".to_owned() } else { spec.mechanics_steps.to_string() };
        let mut row = vec![
            run.id.clone(),
            spec.case.name.to_owned(),
            run.planned.set.clone(),
            run.planned.label.clone(),
            spec.scheme.name.to_owned(),
            spec.sequence.to_string(),
            spec.force_return.to_string(),
            mechanics_steps,
            spec.options.redundancy.to_string(),
            spec.options.motion.to_string(),
            spec.solver.name.to_owned(),
            number(spec.macro_step),
            number(spec.phase),
            number(spec.micro_step),
            number(spec.duration),
            evaluated.outcome.name().to_owned(),
            optional(evaluated.outcome.at_s()),
            evaluated.outcome.reason(),
            number(evaluated.ended_at_s),
        ];
        row.extend(evaluated.metrics.iter().copied().map(optional));
        row.extend(evaluated.reference_uncertainty.map(optional));
        row.extend(evaluated.counters.iter().map(|(_, count)| count.to_string()));
        row.push(executed.experiment.trace_every_s.map(|_| trace_name(run)).unwrap_or_default());
        table.write_record(&row)?;
    }
    Ok(())
}

fn cost_table(table: &mut Table<'_>, executed: &Executed) -> csv::Result<()> {
    table.write_record(["run_id", "label", "macro_step_s", "phase", "wall_s", "real_time_factor"])?;
    for run in &executed.runs {
        let wall = run.evaluated.wall.as_secs_f64();
        table.write_record([
            run.id.clone(),
            run.planned.label.clone(),
            number(run.planned.spec.macro_step),
            number(run.planned.spec.phase),
            number(wall),
            number(run.evaluated.ended_at_s / wall),
        ])?;
    }
    Ok(())
}

fn provenance_table(table: &mut Table<'_>, executed: &Executed, from: &Provenance) -> csv::Result<()> {
    table.write_record(["run_id", "git_revision", "git_dirty", "lock_hash", "version", "rustc", "cpu"])?;
    for run in &executed.runs {
        table.write_record([
            run.id.as_str(),
            &from.git_revision,
            &from.git_dirty,
            &from.lock_hash,
            from.version,
            from.rustc,
            &from.cpu,
        ])?;
    }
    Ok(())
}

fn parameters_table(table: &mut Table<'_>, executed: &Executed) -> csv::Result<()> {
    table.write_record(["case", "set", "parameter", "value", "unit", "source"])?;
    for run in distinct_references(executed) {
        for (parameter, value) in run.planned.spec.parameters.iter() {
            table.write_record([
                run.planned.spec.case.name,
                &run.planned.set,
                parameter.name,
                &value.to_string(),
                parameter.unit,
                parameter.source,
            ])?;
        }
    }
    Ok(())
}

fn reference_table(table: &mut Table<'_>, executed: &Executed) -> csv::Result<()> {
    table.write_record(["case", "set", "column", "rms_uncertainty", "observed_order", "finest_step_s"])?;
    for run in distinct_references(executed) {
        let reference = &run.reference;
        for (index, column) in reference.trajectory.columns().iter().enumerate().skip(1) {
            table.write_record([
                run.planned.spec.case.name,
                &run.planned.set,
                column,
                &number(reference.uncertainty[index]),
                &number(reference.order[index]),
                &number(reference.step),
            ])?;
        }
    }
    Ok(())
}

/// Writes a trajectory, thinned to one row per `every` seconds; the first and last rows always stand.
fn trace_table(table: &mut Table<'_>, trajectory: &Trajectory, every: f64) -> csv::Result<()> {
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
    Ok(())
}

/// The first run of each distinct reference.
fn distinct_references(executed: &Executed) -> Vec<&ExecutedRun> {
    let mut distinct: Vec<&ExecutedRun> = Vec::new();
    for run in &executed.runs {
        if !distinct.iter().any(|known| Arc::ptr_eq(&known.reference, &run.reference)) {
            distinct.push(run);
        }
    }
    distinct
}

fn trace_name(run: &ExecutedRun) -> String {
    format!("{}.csv", run.id)
}

fn reference_name(index: usize) -> String {
    if index == 0 { "reference.csv".to_owned() } else { format!("reference-{}.csv", index + 1) }
}

/// Shortest text that reads back to the same bits; `inf` and `NaN` where it is so.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn optional(value: Option<f64>) -> String {
    value.map(number).unwrap_or_default()
}
