//! How far a statistic can be trusted: the bootstrap over what was drawn.

use crate::draws::Draws;
use crate::quantile;

/// Resamples.
const RESAMPLES: usize = 2000;

/// Where every sequence of draws starts, so that the same values have the same interval on every machine.
const SEED: u64 = 0x52_49_4D;

/// Returns the 95 % percentile interval of a statistic of grouped values; none for less than two groups, of which nothing can be said.
///
/// Whole groups are drawn with replacement, as many as there are: runs of one case at several phases are no independent witnesses.
/// Values that are, such as the phases of one case, are a group each. Draws that leave nothing to be measured are passed over.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pool;

    fn median(values: Vec<f64>) -> Option<f64> {
        Pool::of(values).median()
    }

    fn mean(values: Vec<f64>) -> Option<f64> {
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    }

    fn alone(values: impl Iterator<Item = f64>) -> Vec<Vec<f64>> {
        values.map(|value| vec![value]).collect()
    }

    #[test]
    fn the_interval_of_a_mean_is_that_of_the_normal_distribution() {
        // 400 equally spaced values in [0, 1]: standard error √(1/12)/20; a quantile of 2000 draws is uncertain by some 3 % of it.
        let values = alone((0..400).map(|k| (f64::from(k) + 0.5) / 400.0));
        let [low, high] = bootstrap_interval(&values, mean).unwrap();
        let reach = 1.96 * (1.0_f64 / 12.0).sqrt() / 20.0;
        approx::assert_relative_eq!(0.5 - low, reach, max_relative = 0.1);
        approx::assert_relative_eq!(high - 0.5, reach, max_relative = 0.1);
    }

    #[test]
    fn copies_of_a_witness_are_no_further_witnesses() {
        let values: Vec<f64> = (0..12).map(f64::from).collect();
        let grouped: Vec<Vec<f64>> = values.iter().map(|value| vec![*value; 8]).collect();
        let apart = alone(values.iter().flat_map(|value| [*value; 8]));
        let width = |groups: &[Vec<f64>]| bootstrap_interval(groups, mean).map(|[low, high]| high - low).unwrap();
        // Eight times the witnesses, if they were any: √8 times the certainty; the intervals themselves are uncertain by some 3 %.
        approx::assert_relative_eq!(width(&grouped), 8.0_f64.sqrt() * width(&apart), max_relative = 0.1);
    }

    #[test]
    fn the_same_values_have_the_same_interval_and_one_group_has_none() {
        let values = alone([3.0, 1.0, 4.0, 1.0, 5.0].into_iter());
        assert_eq!(bootstrap_interval(&values, median), bootstrap_interval(&values, median));
        assert_eq!(bootstrap_interval(&values[..1], median), None);
        assert_eq!(bootstrap_interval(&[Vec::new(), Vec::new()], median), None);
    }
}
