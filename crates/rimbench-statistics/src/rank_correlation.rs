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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_rises_with_the_other_has_rank_correlation_one_and_whatever_falls_minus_one() {
        let pairs = |y: fn(f64) -> f64| -> Vec<[f64; 2]> { [3.0, -1.0, 2.0, 7.0, 0.5].map(|x| [x, y(x)]).to_vec() };
        assert_eq!(rank_correlation(&pairs(|x| x.powi(3))), Some(1.0));
        assert_eq!(rank_correlation(&pairs(|x| -x.exp())), Some(-1.0));
        assert_eq!(rank_correlation(&pairs(|_| 4.0)), None);
        assert_eq!(rank_correlation(&[[1.0, 2.0], [2.0, 3.0]]), None);
        assert_eq!(rank_correlation(&[[1.0, 2.0], [2.0, 3.0], [f64::NAN, 4.0]]), None);
    }

    /// Ranks 0 1 2 3 against 1 0 2 3: 1 − 6·2/(4·15) = 0.8. With the first two equal, 0.5 0.5 2 3 against 0 1 2 3: 4.5/√(4.5·5).
    #[test]
    fn ranks_are_compared_as_by_hand_and_equal_values_share_theirs() {
        let swapped = [[1.0, 20.0], [2.0, 10.0], [3.0, 30.0], [4.0, 40.0]];
        approx::assert_relative_eq!(rank_correlation(&swapped).unwrap(), 0.8, epsilon = 1e-15);
        let tied = [[1.0, 10.0], [1.0, 20.0], [3.0, 30.0], [4.0, 40.0]];
        approx::assert_relative_eq!(rank_correlation(&tied).unwrap(), 4.5 / 22.5_f64.sqrt(), epsilon = 1e-15);
    }
}
