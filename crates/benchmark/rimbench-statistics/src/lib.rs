//! The statistics of rimbench: pools, quantiles, straight lines, intervals, the bootstrap.
//!
//! Nothing is read, written or timed here.

mod bootstrap;
mod draws;
mod equal_cost;
mod intervals;
mod latin_hypercube;
mod one_threshold;
mod paired;
mod pool;
mod rank_correlation;
mod share_better;

pub use bootstrap::{bootstrap_interval, interval_of_mean};
pub use equal_cost::{Costed, ratios_at_equal_cost};
pub use intervals::{share_interval, wilson_interval};
pub use latin_hypercube::latin_hypercube;
pub use one_threshold::share_told_by_threshold;
pub use paired::{PairedRatios, PairedRun};
pub use pool::{Pool, by_abscissa, order_of_medians};
pub use rank_correlation::rank_correlation;
pub use share_better::Share;

/// Returns quantile `p` in [0, 1] of a sample, with linear interpolation between the order statistics (Hyndman and Fan,
/// type 7); NaN for an empty one.
pub fn quantile(values: &[f64], p: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = p.clamp(0.0, 1.0) * last as f64;
    let (below, above, share) = (sorted[at.floor() as usize], sorted[at.ceil() as usize], at - at.floor());
    // Infinite values have no difference.
    if share == 0.0 || below == above { below } else { below + share * (above - below) }
}

/// A straight line fitted by least squares, point by point: nothing of a point is kept.
///
/// ```text
/// slope = Σ (x − x̄)(y − ȳ) / Σ (x − x̄)²        Δ = x_n − x̄_{n−1}:    Σ += Δ (x_n − x̄_n),  Δ (y_n − ȳ_n)
/// ```
/// # Source
/// Welford, *Note on a method for calculating corrected sums of squares and products*, Technometrics 4 (1962).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Line {
    points: f64,
    means: [f64; 2],
    covariance: f64,
    variance: f64,
}

impl Line {
    /// Takes one more point.
    pub fn add(&mut self, [x, y]: [f64; 2]) {
        self.points += 1.0;
        let from_mean = x - self.means[0];
        self.means[0] += from_mean / self.points;
        self.means[1] += (y - self.means[1]) / self.points;
        self.covariance += from_mean * (y - self.means[1]);
        self.variance += from_mean * (x - self.means[0]);
    }

    /// Returns the slope; none with fewer than two different abscissas.
    pub fn slope(&self) -> Option<f64> {
        (self.variance > 0.0).then(|| self.covariance / self.variance)
    }
}

/// Fits a straight line by least squares and returns its slope; none with fewer than two different abscissas.
pub fn slope(points: &[[f64; 2]]) -> Option<f64> {
    let mut line = Line::default();
    points.iter().for_each(|&point| line.add(point));
    line.slope()
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
