//! `rimbench simulate`: one run.

use super::json::Object;
use super::progress::Heartbeat;
use super::run_options::RunOptions;
use super::{Format, complain, print, probe_lines, table, with_files};
use clap::Args;
use rimbench::cases::Value as ParameterValue;
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{Outcome, StopFlag};
use rimbench::fmi::import::{ProbeQuality, take_probe_errors};
use rimbench::harness::{Cache, monotonic_clock, obtain_reference};
use rimbench::metrics::{METRICS, is_of_friction};
use rimbench::runs::{EvaluatedRun, RunSpec, evaluate, simulate_inside};
use rimbench::trace::{check_place_for_trace, write_trace};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub struct Simulate {
    #[command(flatten)]
    run: RunOptions<false>,
    /// Write a trace, one row per communication point
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

impl Simulate {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let mut request = self.run.request()?;
        let catalogue = with_files(catalogue, &mut request)?;
        let spec = request.resolve_built(&catalogue)?;
        // A trace that cannot be written is found before anything is computed.
        if let Some(path) = &self.trace {
            check_place_for_trace(path)?;
        }
        let stop = StopFlag::never();
        let alive = Heartbeat::of("simulate");
        let cache = Cache::of_user();
        let reference = obtain_reference(&spec, &cache, stop)?;
        complain(&cache);
        // Those of the reference are not of the run.
        take_probe_errors();
        let result = simulate_inside(&spec, reference.bounds(&spec)?, Some(monotonic_clock), stop)?;
        let probed = take_probe_errors();
        let run = evaluate(&spec, result, &reference)?;
        drop(alive);
        if let Some(path) = &self.trace {
            write_trace(path, &run.trajectory, None)?;
        }
        match self.format {
            Format::Json => print(&serde_json::to_string_pretty(&json(&spec, &run, &probed))?),
            Format::Table => {
                print_tables(&spec, &run)?;
                probe_lines(&probed).iter().try_for_each(|line| print(line))
            }
        }
    }
}

/// Everything that determines the run, everything that was found, everything it cost.
fn json(spec: &RunSpec, run: &EvaluatedRun, probed: &BTreeMap<PathBuf, ProbeQuality>) -> Value {
    let mut object = Object::default();
    object.put("run_id", spec.id());
    spec.facts().iter().for_each(|fact| object.fact(fact));
    let mut parameters = Object::default();
    for (parameter, value) in spec.parameters.iter() {
        match value {
            ParameterValue::Number(number) => parameters.number(&*parameter.name, *number),
            ParameterValue::Choice(choice) => parameters.put(&*parameter.name, choice.as_ref()),
        }
    }
    object.put("parameters", parameters);
    let diverged = matches!(run.outcome, Outcome::Diverged { .. });
    object.number("diverged_at_s", run.outcome.at_s().filter(|_| diverged));
    let findings = run.findings();
    let shown = findings.iter().filter(|fact| spec.case.records_friction() || !is_of_friction(fact.name));
    shown.chain(&run.costs()).for_each(|fact| object.fact(fact));
    if !probed.is_empty() {
        let of_fmu = |quality: &ProbeQuality| {
            let mut object = Object::default();
            object.put("count", quality.count);
            object.number("error_p50", quality.median);
            object.number("error_max", quality.largest);
            Value::from(object)
        };
        let all = probed.iter().map(|(file, quality)| (file.display().to_string(), of_fmu(quality)));
        object.put("probed_fmus", Value::Object(all.collect()));
    }
    object.into()
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
    let shown = |name: &str| spec.case.records_friction() || !is_of_friction(name);
    for (metric, value) in METRICS.iter().zip(&run.metrics).filter(|(metric, _)| shown(metric.name)) {
        let value = value.map_or("–".to_owned(), |value| format!("{value:.6e}"));
        metrics.add_row([metric.name, &value, metric.unit]);
    }
    print(&metrics.to_string())?;
    if let [Some(force), Some(position)] = run.reference_uncertainty {
        print(&format!("The reference itself is uncertain by {force:.2e} N and {position:.2e} m (rms).\n"))?;
    }
    let mut counters = table(&["counter", "value"]);
    for fact in run.counters() {
        counters.add_row([fact.name.to_owned(), fact.cell()]);
    }
    let wall = run.wall.as_secs_f64();
    counters.add_row(["wall time (s)".to_owned(), format!("{wall:.4}")]);
    // A run that never began took no time.
    let factor = Some(run.real_time_factor()).filter(|factor| factor.is_finite());
    counters.add_row(["real-time factor".to_owned(), factor.map_or("–".to_owned(), |factor| format!("{factor:.0}"))]);
    if let Some(latency) = run.latency {
        for (name, seconds) in [("p50", latency.p50_s), ("p99", latency.p99_s), ("max", latency.max_s)] {
            counters.add_row([format!("macro step {name} (s)"), format!("{seconds:.2e}")]);
        }
        counters.add_row(["missed deadlines".to_owned(), latency.missed_deadlines.to_string()]);
    }
    print(&counters.to_string())
}
