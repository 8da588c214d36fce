//! `rimbench simulate`: one run.

use super::run_options::RunOptions;
use super::{Format, json_number, print, table};
use clap::Args;
use rimbench::atomic_file::{check_writable_folder, write_atomically};
use rimbench::cosim::{Outcome, Trajectory};
use rimbench::error::{Error, Result};
use rimbench::harness::{COUNTERS, Cache, EvaluatedRun, Reference, RunSpec, evaluate, simulate};
use rimbench::metrics::METRICS;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub struct Simulate {
    #[command(flatten)]
    run: RunOptions,
    /// Macro step H, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    macro_step: Option<f64>,
    /// Communication phase φ in (0, 1]: the first macro step is φH long
    #[arg(long, value_name = "PHI", default_value_t = 1.0, allow_negative_numbers = true)]
    phase: f64,
    /// Write a trace, one row per communication point
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

impl Simulate {
    pub(super) fn run(self) -> anyhow::Result<()> {
        let spec = self.run.spec(self.macro_step, self.phase)?;
        // A trace that cannot be written is found before anything is computed.
        if let Some(path) = &self.trace {
            check_trace(path)?;
        }
        let reference = Reference::obtain(spec.case, &spec.parameters, spec.solver, spec.duration, &Cache::of_user())?;
        let bounds = reference.bounds(spec.case, &spec.parameters, spec.solver)?;
        let run = evaluate(&spec, simulate(&spec, bounds)?, &reference);
        if let Some(path) = &self.trace {
            write_trace(path, &run.trajectory, spec.case.trace_columns.len())?;
        }
        match self.format {
            Format::Json => print(&serde_json::to_string_pretty(&json(&spec, &run))?),
            Format::Table => print_tables(&spec, &run),
        }
    }
}

fn check_trace(path: &Path) -> Result<()> {
    if path.is_dir() {
        return Err(Error::file(path, "is a folder; a trace needs the name of a file"));
    }
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(Error::file(path, format!("cannot be written: there is no folder {}", folder.display())));
    }
    check_writable_folder(folder)
}

/// Writes the trace columns of a case, every communication point.
fn write_trace(path: &Path, trajectory: &Trajectory, columns: usize) -> Result<()> {
    write_atomically(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        writer.write_record(&trajectory.columns()[..columns])?;
        for row in trajectory.rows() {
            writer.write_record(row[..columns].iter().map(|value| format!("{value:?}")))?;
        }
        writer.flush()
    })
}

fn json(spec: &RunSpec, run: &EvaluatedRun) -> Value {
    let mut facts = Map::new();
    let mut put = |key: &str, value: Value| {
        facts.insert(key.to_owned(), value);
    };
    put("case", spec.case.name.into());
    put("scheme", spec.scheme.name.into());
    put("sequence", spec.sequence.to_string().into());
    put("force_return", spec.force_return.to_string().into());
    put("solver", spec.solver.name.into());
    put("macro_step_s", json_number(spec.macro_step));
    put("step_control", spec.step_control.to_string().into());
    put("step_tolerance", spec.step_control.rule().map_or(Value::Null, |rule| json_number(rule.tolerance)));
    put("min_macro_step_s", spec.step_control.rule().map_or(Value::Null, |rule| json_number(rule.shortest)));
    put("micro_step_s", json_number(spec.micro_step));
    put("phase", json_number(spec.phase));
    put("duration_s", json_number(spec.duration));
    put("outcome", run.outcome.name().into());
    let diverged = matches!(run.outcome, Outcome::Diverged { .. });
    let optional = |value: Option<f64>| value.map_or(Value::Null, json_number);
    put("diverged_at_s", optional(run.outcome.at_s().filter(|_| diverged)));
    put("outcome_at_s", optional(run.outcome.at_s()));
    put("reason", run.outcome.reason().into());
    put("ended_at_s", json_number(run.ended_at_s));
    for (metric, value) in METRICS.iter().zip(&run.metrics) {
        put(metric.name, optional(*value));
    }
    let [force, position] = run.reference_uncertainty;
    put("reference_force_uncertainty_n", optional(force));
    put("reference_position_uncertainty_m", optional(position));
    for (name, count) in COUNTERS.iter().zip(run.counters) {
        put(name, count.into());
    }
    put("wall_s", json_number(run.wall.as_secs_f64()));
    put("real_time_factor", json_number(run.real_time_factor()));
    put("latency_p50_s", optional(run.latency.map(|latency| latency.p50_s)));
    put("latency_p99_s", optional(run.latency.map(|latency| latency.p99_s)));
    put("latency_max_s", optional(run.latency.map(|latency| latency.max_s)));
    put("missed_deadlines", run.latency.map_or(Value::Null, |latency| latency.missed_deadlines.into()));
    Value::Object(facts)
}

fn print_tables(spec: &RunSpec, run: &EvaluatedRun) -> anyhow::Result<()> {
    print(&format!(
        "{} with {} at H = {} ms ({}, force return {}): {}\n",
        spec.case.name,
        spec.scheme.name,
        spec.macro_step * 1e3,
        spec.sequence,
        spec.force_return,
        run.outcome
    ))?;
    let mut metrics = table(&["metric", "value", "unit"]);
    for (metric, value) in METRICS.iter().zip(&run.metrics) {
        let value = value.map_or("–".to_owned(), |value| format!("{value:.6e}"));
        metrics.add_row([metric.name, &value, metric.unit]);
    }
    print(&metrics.to_string())?;
    if let [Some(force), Some(position)] = run.reference_uncertainty {
        print(&format!("The reference itself is uncertain by {force:.2e} N and {position:.2e} m (rms).\n"))?;
    }
    let mut counters = table(&["counter", "value"]);
    for (name, count) in COUNTERS.iter().zip(run.counters) {
        counters.add_row([(*name).to_owned(), count.to_string()]);
    }
    let wall = run.wall.as_secs_f64();
    counters.add_row(["wall time (s)".to_owned(), format!("{wall:.4}")]);
    counters.add_row(["real-time factor".to_owned(), format!("{:.0}", run.real_time_factor())]);
    if let Some(latency) = run.latency {
        for (name, seconds) in [("p50", latency.p50_s), ("p99", latency.p99_s), ("max", latency.max_s)] {
            counters.add_row([format!("macro step {name} (s)"), format!("{seconds:.2e}")]);
        }
        counters.add_row(["missed deadlines".to_owned(), latency.missed_deadlines.to_string()]);
    }
    print(&counters.to_string())
}
