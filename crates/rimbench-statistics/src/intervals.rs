//! Intervals for ratios of times.

use std::f64::consts::FRAC_PI_2;

/// Logarithms of ratios of two times measured back to back, reduced to what an interval needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeSummary {
    /// Geometric mean of the ratios.
    pub ratio: f64,
    /// Standard deviation of their logarithms.
    pub log_sd: f64,
    /// How many.
    pub samples: u32,
}

impl TimeSummary {
    /// Reduces pairs (numerator, denominator), both above zero. None for fewer than two.
    pub fn of(pairs: &[(f64, f64)]) -> Option<Self> {
        let logs: Vec<f64> = pairs.iter().map(|(a, b)| (a / b).ln()).filter(|log| log.is_finite()).collect();
        let n = logs.len();
        if n < 2 {
            return None;
        }
        let mean = logs.iter().sum::<f64>() / n as f64;
        let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (n - 1) as f64;
        Some(TimeSummary { ratio: mean.exp(), log_sd: variance.sqrt(), samples: n as u32 })
    }

    /// Returns the 95 % interval of the geometric mean (Student's t on the logarithms).
    pub fn interval(&self) -> [f64; 2] {
        let n = f64::from(self.samples);
        let reach = student(n - 1.0) * self.log_sd / n.sqrt();
        [self.ratio * (-reach).exp(), self.ratio * reach.exp()]
    }
}

/// Returns Wilson's 95 % interval of a share, `found` of `all`; none of nothing.
///
/// ```text
/// (p + z²/2n ± z √(p (1 − p)/n + z²/4n²)) / (1 + z²/n),    z the 97.5 % quantile of the normal distribution
/// ```
pub fn wilson_interval(found: usize, all: usize) -> Option<[f64; 2]> {
    const Z: f64 = 1.959_963_984_540_054;
    if all == 0 {
        return None;
    }
    let n = all as f64;
    let p = found as f64 / n;
    let (middle, shrunk) = (p + Z * Z / (2.0 * n), 1.0 + Z * Z / n);
    let reach = Z * (p * (1.0 - p) / n + (Z / (2.0 * n)).powi(2)).sqrt();
    Some([((middle - reach) / shrunk).max(0.0), ((middle + reach) / shrunk).min(1.0)])
}

/// 97.5 % quantile of Student's t with ν degrees of freedom, ν ≥ 1 and not necessarily whole.
///
/// ```text
/// t = √ν tan θ:    the density becomes cos^(ν−1) θ on (−π/2, π/2), up to a factor
/// ```
/// The angle that leaves 95 % of the half interval behind is found by the midpoint rule.
fn student(freedom: f64) -> f64 {
    const CELLS: u32 = 20_000;
    let width = FRAC_PI_2 / f64::from(CELLS);
    let cell = |k: u32| ((f64::from(k) + 0.5) * width).cos().powf(freedom - 1.0);
    let wanted = 0.95 * (0..CELLS).map(cell).sum::<f64>();
    let mut below = 0.0;
    for k in 0..CELLS {
        let part = cell(k);
        if below + part >= wanted {
            return freedom.sqrt() * ((f64::from(k) + (wanted - below) / part) * width).tan();
        }
        below += part;
    }
    f64::INFINITY
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_share_is_wilson_s() {
        // Newcombe (1998), method 3: 81 of 263, and 0 of 20.
        let [low, high] = wilson_interval(81, 263).unwrap();
        approx::assert_abs_diff_eq!(low, 0.2553, epsilon = 5e-5);
        approx::assert_abs_diff_eq!(high, 0.3662, epsilon = 5e-5);
        let [low, high] = wilson_interval(0, 20).unwrap();
        approx::assert_abs_diff_eq!(low, 0.0, epsilon = 1e-15);
        approx::assert_abs_diff_eq!(high, 0.1611, epsilon = 5e-5);
        assert_eq!(wilson_interval(0, 0), None);
    }

    #[test]
    fn intervals_use_student_s_t() {
        // Tables: t(0.975, 1) = 12.706, t(0.975, 4) = 2.776, t(0.975, 10) = 2.228.
        approx::assert_abs_diff_eq!(student(1.0), 12.706, epsilon = 5e-4);
        approx::assert_abs_diff_eq!(student(4.0), 2.776, epsilon = 5e-4);
        approx::assert_abs_diff_eq!(student(10.0), 2.228, epsilon = 5e-4);
        let summary = TimeSummary::of(&[(2.0, 1.0), (8.0, 1.0)]).unwrap();
        approx::assert_relative_eq!(summary.ratio, 4.0, max_relative = 1e-14);
        // Two logarithms ln 2 and ln 8: standard error ln 2, t(0.975, 1) = 12.706.
        approx::assert_relative_eq!(summary.interval()[1], 4.0 * 2.0_f64.powf(12.706), max_relative = 1e-3);
        assert_eq!(TimeSummary::of(&[(1.0, 1.0)]), None);
    }
}
