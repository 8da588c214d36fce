//! The interval of a share.

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
