//! Runs of two scheme rows, compared case by case where they cost the same.

use rimbench_statistics::{median, ratio_at_equal_cost};
use std::collections::BTreeMap;

/// A run of one of the two rows.
pub(super) struct CostedRun<'a> {
    /// Case and set.
    pub(super) problem: &'a [String],
    /// Macro step and tolerance: what a row is swept over.
    pub(super) setting: [f64; 2],
    /// Whether it is of the row that is compared with.
    pub(super) is_other: bool,
    pub(super) cost: f64,
    pub(super) error: f64,
}

/// Costs and errors of the phases of a row, by setting.
type Row = BTreeMap<[u64; 2], [Vec<f64>; 2]>;

/// The factor between the errors of each problem, medians over phases; problems with nothing to compare are left out.
pub(super) fn ratios<'a>(runs: impl Iterator<Item = CostedRun<'a>>) -> Vec<f64> {
    let mut problems: BTreeMap<&[String], [Row; 2]> = BTreeMap::new();
    for run in runs {
        let rows = problems.entry(run.problem).or_default();
        let [costs, errors] = rows[usize::from(run.is_other)].entry(run.setting.map(f64::to_bits)).or_default();
        costs.push(run.cost);
        errors.push(run.error);
    }
    let points = |settings: Row| -> Vec<[f64; 2]> {
        let medians = |[costs, errors]: [Vec<f64>; 2]| Some([median(costs)?, median(errors)?]);
        settings.into_values().filter_map(medians).collect()
    };
    let rows = problems.into_values().map(|rows| rows.map(points));
    rows.filter_map(|[own, other]| ratio_at_equal_cost(&own, &other)).collect()
}
