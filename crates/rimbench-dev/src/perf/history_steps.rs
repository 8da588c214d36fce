//! All steps of a history in words: what changed, by how much, between which revisions.

use super::history::{History, Row};
use super::steps::steps;
use std::collections::BTreeMap;

/// Relative change of a time below which there is no step: code layout alone does as much.
const TIME_FLOOR: f64 = 0.05;

/// A change of level, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryStep {
    /// Name in the suite.
    pub benchmark: String,
    /// `instructions`, or `time` over the yardstick.
    pub quantity: &'static str,
    /// Ratio of the new level to the old one.
    pub ratio: f64,
    /// Git revision of the last record of the old level.
    pub before: String,
    /// Git revision of the first record of the new one.
    pub revision: String,
    /// Name of that record.
    pub record: String,
}

/// Finds all steps of a history, oldest records first: instructions of one target and compiler, times of one
/// machine as well.
pub fn history_steps<'a>(history: &'a History) -> Vec<HistoryStep> {
    let mut series: BTreeMap<[&'a str; 5], Vec<(&'a Row, f64)>> = BTreeMap::new();
    for row in history.rows.iter().filter(|row| row.is_ok()) {
        let mut put = |machine: &'a str, quantity: &'static str, value: Option<f64>| {
            if let Some(value) = value {
                let key = [row.benchmark.as_str(), quantity, &row.target, &row.rustc, machine];
                series.entry(key).or_default().push((row, value));
            }
        };
        put("", "instructions", row.instructions.map(|count| count as f64));
        put(&row.machine, "time", row.time_ratio);
    }
    let mut found: Vec<(u64, HistoryStep)> = Vec::new();
    for ([benchmark, quantity, ..], rows) in series {
        let values: Vec<f64> = rows.iter().map(|(_, value)| *value).collect();
        let quantity = if quantity == "time" { "time" } else { "instructions" };
        for step in steps(&values, if quantity == "time" { TIME_FLOOR } else { 0.0 }) {
            let (before, after) = (rows[step.at - 1].0, rows[step.at].0);
            let step = HistoryStep {
                benchmark: benchmark.to_owned(),
                quantity,
                ratio: step.ratio,
                before: before.git_revision.clone(),
                revision: after.git_revision.clone(),
                record: after.record.clone(),
            };
            found.push((after.recorded_at_unix_s, step));
        }
    }
    // Of one record by benchmark, as they were found.
    found.sort_by_key(|(at, _)| *at);
    found.into_iter().map(|(_, step)| step).collect()
}
