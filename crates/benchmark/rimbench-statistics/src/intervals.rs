//! The interval of a share.

/// The 97.5 % quantile of the normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// Returns Wilson's 95 % interval of a share, `found` of `all`; none of nothing.
///
/// ```text
/// (p + z²/2n ± z √(p (1 − p)/n + z²/4n²)) / (1 + z²/n),    z the 97.5 % quantile of the normal distribution
/// ```
pub fn wilson_interval(found: usize, all: usize) -> Option<[f64; 2]> {
    wilson(found as f64, all as f64)
}

/// Returns Wilson's 95 % interval of a share whose members come in groups that were drawn, of each how many of how many
/// were found; none of nothing. Members of a group are no independent witnesses: the interval is that of so many
/// independent ones as have the variance of the groups.
///
/// ```text
/// s² = (Σ (f_k − p n_k)²)/n² · K/(K − 1),    n' = p (1 − p)/s², at most n; where groups do not differ, K
/// ```
/// # Source
/// Kish: Survey Sampling (1965), chapters 5 and 6 (the effect of the design on the variance).
pub fn share_interval(groups: &[[usize; 2]]) -> Option<[f64; 2]> {
    let groups: Vec<[f64; 2]> =
        groups.iter().filter(|[_, all]| *all > 0).map(|group| group.map(|count| count as f64)).collect();
    let (found, all) = groups.iter().fold((0.0, 0.0), |(found, all), group| (found + group[0], all + group[1]));
    let (p, count) = (found / all, groups.len() as f64);
    let spread: f64 = groups.iter().map(|[found, all]| (found - p * all).powi(2)).sum();
    let variance = spread / all.powi(2) * count / (count - 1.0);
    let independent = if variance > 0.0 { (p * (1.0 - p) / variance).min(all) } else { count };
    wilson(p * independent, independent)
}

fn wilson(found: f64, n: f64) -> Option<[f64; 2]> {
    if n.is_nan() || n <= 0.0 {
        return None;
    }
    let p = found / n;
    let (middle, shrunk) = (p + Z * Z / (2.0 * n), 1.0 + Z * Z / n);
    let reach = Z * (p * (1.0 - p) / n + (Z / (2.0 * n)).powi(2)).sqrt();
    Some([((middle - reach) / shrunk).max(0.0), ((middle + reach) / shrunk).min(1.0)])
}
