//! A record of performance in the formats that trackers of others read.

use super::json::Object;
use clap::ValueEnum;
use rimbench::perf::{COUNTERS, Row};
use serde_json::{Value, json};

/// How `perf show` prints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ShowFormat {
    /// For reading.
    Table,
    /// All that the record says.
    Json,
    /// Bencher Metric Format: instructions, and latency in ns.
    Bencher,
    /// Of the action github-action-benchmark, `customSmallerIsBetter`.
    GithubActionBenchmark,
}

impl ShowFormat {
    /// The record as a document; none where it is a table. Benchmarks without a right answer have no measurements, and stand in
    /// `json` only.
    pub(super) fn document(self, rows: &[&Row]) -> Option<Value> {
        let measured = || rows.iter().filter(|row| row.is_ok());
        match self {
            ShowFormat::Table => None,
            ShowFormat::Json => Some(rows.iter().map(|row| everything(row)).collect()),
            ShowFormat::Bencher => {
                let entry = |row: &&Row| {
                    let measures = measures(row).map(|(slug, _, value)| (slug.to_owned(), json!({ "value": value })));
                    (row.benchmark.clone(), Value::Object(measures.collect()))
                };
                Some(Value::Object(measured().map(entry).collect()))
            }
            ShowFormat::GithubActionBenchmark => {
                let entries = measured().flat_map(|row| {
                    measures(row).map(|(slug, unit, value)| {
                        let extra = format!("record {}, revision {}, {}", row.record, row.git_revision, row.cpu);
                        json!({
                            "name": format!("{} {slug}", row.benchmark), "unit": unit, "value": value, "extra": extra,
                        })
                    })
                });
                Some(entries.collect())
            }
        }
    }
}

/// What was measured, of which less is better: slug, unit, value.
fn measures(row: &Row) -> impl Iterator<Item = (&'static str, &'static str, f64)> {
    let instructions = row.instructions.map(|count| ("instructions", "instructions", count as f64));
    let latency = row.wall_s.map(|wall| ("latency", "ns", 1e9 * wall));
    instructions.into_iter().chain(latency)
}

fn everything(row: &Row) -> Value {
    let mut object = Object::default();
    for (key, text) in [
        ("record", &row.record),
        ("git_revision", &row.git_revision),
        ("git_dirty", &row.git_dirty),
        ("rustc", &row.rustc),
        ("target", &row.target),
        ("lock_hash", &row.lock_hash),
        ("machine", &row.machine),
        ("cpu", &row.cpu),
        ("benchmark", &row.benchmark),
        ("status", &row.status),
    ] {
        object.put(key, text.as_str());
    }
    object.put("recorded_at_unix_s", row.recorded_at_unix_s);
    COUNTERS.iter().for_each(|(name, count)| object.put(*name, count(row)));
    object.put("flops_estimate", row.flops_estimate);
    object.put("instructions", row.instructions);
    for (key, number) in [
        ("wall_s", row.wall_s),
        ("time_ratio", row.time_ratio),
        ("time_log_sd", row.time_log_sd),
        ("placebo_ratio", row.placebo_ratio),
        ("placebo_low", row.placebo_low),
        ("placebo_high", row.placebo_high),
    ] {
        object.number(key, number);
    }
    object.into()
}
