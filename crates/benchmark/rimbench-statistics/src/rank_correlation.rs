//! Whether two quantities rise together, whatever their units.

/// Computes Spearman's rank correlation of pairs; none with fewer than three, or where one quantity is all the same.
///
/// ```text
/// ρ = Σ (r_i − r̄)(s_i − s̄) / √(Σ (r_i − r̄)² Σ (s_i − s̄)²)        r, s the ranks, of equal values their mean
/// ```
/// # Source
/// Textbook (Spearman 1904).
pub fn rank_correlation(pairs: &[[f64; 2]]) -> Option<f64> {
    if pairs.len() < 3 || pairs.iter().flatten().any(|value| value.is_nan()) {
        return None;
    }
    let ranks = [0, 1].map(|of| ranks(&pairs.iter().map(|pair| pair[of]).collect::<Vec<f64>>()));
    let mean = 0.5 * (pairs.len() - 1) as f64;
    let product =
        |a: usize, b: usize| -> f64 { ranks[a].iter().zip(&ranks[b]).map(|(a, b)| (a - mean) * (b - mean)).sum() };
    let spread = (product(0, 0) * product(1, 1)).sqrt();
    (spread > 0.0).then(|| product(0, 1) / spread)
}

/// Ranks from 0, equal values sharing the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for same in order.chunk_by(|&a, &b| values[a] == values[b]) {
        same.iter().for_each(|&index| ranks[index] = first as f64 + 0.5 * (same.len() - 1) as f64);
        first += same.len();
    }
    ranks
}
