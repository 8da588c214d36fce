//! The statistics of rimbench: the table of runs with what is pooled of it, quantiles, straight lines, intervals, performance
//! profiles, the bootstrap.
//!
//! Nothing is read, written or timed here.

mod bootstrap;
mod draws;
mod equal_cost;
mod intervals;
mod latin_hypercube;
mod one_threshold;
mod performance_profile;
mod pool;
mod rank_correlation;
mod runs;
mod share_better;
mod table;

pub use bootstrap::bootstrap_interval;
pub use equal_cost::{Costed, ratios_at_equal_cost};
pub use intervals::wilson_interval;
pub use latin_hypercube::latin_hypercube;
pub use one_threshold::share_told_by_threshold;
pub use performance_profile::{data_profile, performance_profile, performance_ratios};
pub use pool::{Pool, by_abscissa, order_of_medians};
pub use rank_correlation::rank_correlation;
pub use runs::{ALL, Floor, Pooled, Run, Runs, has_words};
pub use share_better::{PairedRun, Share};
pub use table::ResultsTable;

/// Returns quantile `p` in [0, 1] of a sample, with linear interpolation between the order statistics (Hyndman and Fan, type
/// 7); NaN for an empty one.
pub fn quantile(values: &[f64], p: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = p.clamp(0.0, 1.0) * last as f64;
    let (below, above) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    below + (at - at.floor()) * (above - below)
}

/// Returns the percentile by nearest rank, a value of the sample itself; none of an empty one. Reorders the values.
///
/// ```text
/// x_(⌈q n / 100⌉),    x_(1) ≤ … ≤ x_(n)
/// ```
pub fn nearest_rank(values: &mut [f64], percent: usize) -> Option<f64> {
    let n = values.len();
    let index = (percent * n).div_ceil(100).max(1) - 1;
    // A rank needs no sorted list.
    (index < n).then(|| *values.select_nth_unstable_by(index, f64::total_cmp).1)
}

/// Fits a straight line by least squares and returns its slope; none with fewer than two different abscissas.
///
/// ```text
/// Σ (x − x̄)(y − ȳ) / Σ (x − x̄)²
/// ```
pub fn slope(points: &[[f64; 2]]) -> Option<f64> {
    let n = points.len() as f64;
    let (mean_x, mean_y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point[0] / n, y + point[1] / n));
    let covariance: f64 = points.iter().map(|point| (point[0] - mean_x) * (point[1] - mean_y)).sum();
    let variance: f64 = points.iter().map(|point| (point[0] - mean_x).powi(2)).sum();
    (variance > 0.0).then(|| covariance / variance)
}

/// Fits `error ≈ C H^p` by least squares in logarithms and returns the order p; none with fewer than two usable points.
///
/// # Shapes and units
/// Pairs (H in s, error in any unit); pairs that are not positive and finite are left out.
pub fn order_of_convergence(points: &[(f64, f64)]) -> Option<f64> {
    let usable = |(step, error): &&(f64, f64)| *step > 0.0 && *error > 0.0 && step.is_finite() && error.is_finite();
    let logs: Vec<[f64; 2]> = points.iter().filter(usable).map(|(step, error)| [step.ln(), error.ln()]).collect();
    slope(&logs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate_between_order_statistics() {
        assert_eq!(
            [0.0, 0.25, 0.5, 0.75, 1.0].map(|p| quantile(&[4.0, 1.0, 3.0, 2.0], p)),
            [1.0, 1.75, 2.5, 3.25, 4.0]
        );
        assert_eq!(quantile(&[7.0], 0.9), 7.0);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn percentiles_by_rank_are_values_of_the_sample() {
        let mut sample: Vec<f64> = (1..=200).rev().map(f64::from).collect();
        assert_eq!([50, 99, 100].map(|percent| nearest_rank(&mut sample, percent)), [100.0, 198.0, 200.0].map(Some));
        assert_eq!(nearest_rank(&mut [3.0], 50), Some(3.0));
        assert_eq!(nearest_rank(&mut [], 50), None);
    }

    #[test]
    fn the_slope_of_a_line_is_found_and_an_oscillation_has_next_to_none() {
        let points = |y: fn(f64) -> f64| -> Vec<[f64; 2]> {
            (0..=1000).map(|k| f64::from(k) * 0.01).map(|t| [t, y(t)]).collect()
        };
        approx::assert_relative_eq!(slope(&points(|t| 3.0 - 0.5 * t)).unwrap(), -0.5, epsilon = 1e-12);
        let swing = slope(&points(|t| (20.0 * std::f64::consts::PI * t).cos())).unwrap();
        assert!(swing.abs() < 1e-4, "{swing}");
        assert_eq!(slope(&[[1.0, 2.0]]), None);
        assert_eq!(slope(&[]), None);
    }

    #[test]
    fn the_order_of_a_power_law_is_its_exponent() {
        let points: Vec<_> = (1..6).map(|i| (i as f64, 3.0 * (i as f64).powf(1.7))).collect();
        approx::assert_relative_eq!(order_of_convergence(&points).unwrap(), 1.7, epsilon = 1e-12);
        assert_eq!(order_of_convergence(&[(1.0, 1.0), (2.0, f64::NAN)]), None);
    }
}
