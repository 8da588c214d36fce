//! Two ways of working, compared where they cost the same.

use crate::Pool;
use std::collections::BTreeMap;

/// One run of two scheme rows that are compared.
#[derive(Debug, Clone, Copy)]
pub struct Costed<'a> {
    /// Case and set.
    pub problem: [&'a str; 2],
    /// Macro step and tolerance: what a row is swept over.
    pub setting: [f64; 2],
    /// Whether it is of the row that is compared with.
    pub is_other: bool,
    /// What it cost.
    pub cost: f64,
    /// How wrong it is.
    pub error: f64,
}

/// Costs and errors of the phases of a row, by setting.
type Row = BTreeMap<[u64; 2], [Vec<f64>; 2]>;

/// Computes the factor between the errors of two rows at equal cost on each problem; costs and errors are medians over
/// the runs of a setting. Problems with nothing to compare are left out.
pub fn ratios_at_equal_cost<'a>(runs: impl IntoIterator<Item = Costed<'a>>) -> Vec<f64> {
    let mut problems: BTreeMap<[&str; 2], [Row; 2]> = BTreeMap::new();
    for run in runs {
        let rows = problems.entry(run.problem).or_default();
        let [costs, errors] = rows[usize::from(run.is_other)].entry(run.setting.map(f64::to_bits)).or_default();
        costs.push(run.cost);
        errors.push(run.error);
    }
    let points = |settings: Row| -> Vec<[f64; 2]> {
        let medians = |[costs, errors]: [Vec<f64>; 2]| Some([Pool::of(costs).median()?, Pool::of(errors).median()?]);
        settings.into_values().filter_map(medians).collect()
    };
    let rows = problems.into_values().map(|rows| rows.map(points));
    rows.filter_map(|[own, other]| ratio_at_equal_cost(&own, &other)).collect()
}

/// Computes by what factor the error of one way of working differs from that of another at equal cost.
///
/// ```text
/// exp mean_k ln(e_k / ê(c_k))        ê the straight line through the other's points in ln c, ln e
/// ```
/// Points of the one that cost less than the cheapest or more than the dearest of the other are left out; none if none
/// is left.
///
/// # Shapes and units
/// Pairs (cost, error), in any order; pairs that are not positive and finite are left out.
fn ratio_at_equal_cost(own: &[[f64; 2]], other: &[[f64; 2]]) -> Option<f64> {
    let other = logarithms(other);
    let ratios = logarithms(own).into_iter().filter_map(|[cost, error]| Some(error - on_line(&other, cost)?));
    let (sum, count) = ratios.fold((0.0, 0_usize), |(sum, count), ratio| (sum + ratio, count + 1));
    (count > 0).then(|| (sum / count as f64).exp())
}

/// Usable points in logarithms, by ascending cost.
fn logarithms(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let usable = points.iter().filter(|point| point.iter().all(|value| value.is_finite() && *value > 0.0));
    let mut logarithms: Vec<[f64; 2]> = usable.map(|point| point.map(f64::ln)).collect();
    logarithms.sort_by(|a, b| a[0].total_cmp(&b[0]));
    logarithms
}

/// Value at `x` of the broken line through the points; none beyond its ends.
fn on_line(points: &[[f64; 2]], x: f64) -> Option<f64> {
    let piece = points.windows(2).find(|piece| piece[0][0] <= x && x <= piece[1][0])?;
    let ([x0, y0], [x1, y1]) = (piece[0], piece[1]);
    Some(if x1 > x0 { y0 + (y1 - y0) * (x - x0) / (x1 - x0) } else { 0.5 * (y0 + y1) })
}
