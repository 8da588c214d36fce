//! How far a statistic can be trusted: the bootstrap over what was drawn.

use crate::draws::Draws;
use crate::quantile;

/// Resamples.
const RESAMPLES: usize = 2000;

/// Where every sequence of draws starts, so that the same values have the same interval on every machine.
const SEED: u64 = 0x52_49_4D;

/// Returns the 95 % percentile interval of a statistic of grouped values; none for less than two groups, of which
/// nothing can be said.
///
/// Whole groups are drawn with replacement, as many as there are: runs of one case at several phases are no independent
/// witnesses. Values that are, such as the phases of one case, are a group each. Draws that leave nothing to be
/// measured are passed over.
/// # Source
/// Efron, Tibshirani: An Introduction to the Bootstrap (1993), chapters 8 and 13.
pub fn bootstrap_interval<T: Copy>(groups: &[Vec<T>], statistic: impl Fn(Vec<T>) -> Option<f64>) -> Option<[f64; 2]> {
    if groups.len() < 2 {
        return None;
    }
    let mut draws = Draws::from(SEED);
    let resampled: Vec<f64> = (0..RESAMPLES)
        .filter_map(|_| {
            let drawn = (0..groups.len()).flat_map(|_| &groups[draws.below(groups.len())]);
            statistic(drawn.copied().collect())
        })
        .collect();
    (!resampled.is_empty()).then(|| [quantile(&resampled, 0.025), quantile(&resampled, 0.975)])
}

/// Returns the same interval of a function of the mean, where each value is a group.
pub fn interval_of_mean(values: &[f64], of: &dyn Fn(f64) -> f64) -> Option<[f64; 2]> {
    let groups: Vec<Vec<f64>> = values.iter().map(|value| vec![*value]).collect();
    bootstrap_interval(&groups, |drawn| Some(of(drawn.iter().sum::<f64>() / drawn.len() as f64)))
}
