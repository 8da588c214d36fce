//! Steps in a series: where a history changed its level.

use rimbench_statistics::quantile;

/// Part of a level below which a difference does not count: what alignment, paths and the environment may do to a count.
pub(super) const FLOOR: f64 = 0.002;

/// Standard errors a difference of levels must have; among the ≤ 30² / 2 splits looked at, chance reaches it rarely.
const SIGNIFICANT: f64 = 5.0;
/// Differences whose median says something.
const FEW: usize = 5;
/// Standard deviation of a normal distribution over its median absolute deviation.
const MAD: f64 = 1.4826;

/// Finds the first indices of new levels in a series of values above zero, by binary segmentation of their logarithms.
///
/// The best split is where `|mean₂ − mean₁| √(n₁ n₂ / n)` is largest; it is a step if that is above five standard deviations
/// and the levels differ by more than [`FLOOR`], and then both parts are searched. The standard
/// deviation is taken from the differences of neighbours, of which a few steps do not disturb the median; of fewer than five
/// differences one step is already half, so the least of them is taken, and the floor is what keeps noise apart.
fn steps(values: &[f64]) -> Vec<usize> {
    let logs: Vec<f64> = values.iter().map(|value| value.ln()).collect();
    let mut differences: Vec<f64> = logs.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    differences.retain(|difference| difference.is_finite());
    let typical = match differences.len() {
        0 => 0.0,
        1..FEW => quantile(&differences, 0.0),
        _ => quantile(&differences, 0.5),
    };
    let sigma = MAD * typical / 2.0_f64.sqrt();
    let mut cuts = Vec::new();
    split(&logs, 0, sigma, &mut cuts);
    cuts.sort_unstable();
    cuts
}

/// First index of the level that the last value belongs to.
pub(super) fn start_of_last_level(values: &[f64]) -> usize {
    steps(values).last().copied().unwrap_or(0)
}

fn split(logs: &[f64], offset: usize, sigma: f64, cuts: &mut Vec<usize>) {
    let n = logs.len() as f64;
    let gain = |at: usize| {
        let (left, right) = logs.split_at(at);
        (mean(right) - mean(left)).abs() * (left.len() as f64 * right.len() as f64 / n).sqrt()
    };
    let Some(at) = (1..logs.len()).max_by(|&a, &b| gain(a).total_cmp(&gain(b))) else { return };
    let (left, right) = logs.split_at(at);
    if gain(at) > SIGNIFICANT * sigma && (mean(right) - mean(left)).abs() > FLOOR.ln_1p() {
        cuts.push(offset + at);
        split(left, offset, sigma, cuts);
        split(right, offset + at, sigma, cuts);
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn steps_are_found_where_they_are_and_nowhere_else() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let mut noise = move || 1.0 + 1e-4 * (rng.random::<f64>() - 0.5);
        let series: Vec<f64> = (0..30)
            .map(|k| {
                noise()
                    * if k < 10 {
                        1e6
                    } else if k < 22 {
                        1.02e6
                    } else {
                        0.9e6
                    }
            })
            .collect();
        assert_eq!(steps(&series), [10, 22]);
        assert_eq!(start_of_last_level(&series), 22);
        assert_eq!(steps(&series[..10]), [0; 0]);
    }

    #[test]
    fn a_last_value_that_jumps_is_a_step_and_one_value_or_none_has_none() {
        assert_eq!(steps(&[5.0, 5.0, 5.0, 5.1]).len(), 1);
        assert_eq!(steps(&[5.0, 5.0, 5.0, 5.005]), [0; 0]);
        assert_eq!(steps(&[5.0]), [0; 0]);
        // A short history with one step: the level is that of the last two, and not something wide between all three.
        assert_eq!(start_of_last_level(&[99.8, 83.3479, 83.348]), 1);
        assert_eq!(steps(&[99.8, 83.3]), [0; 0], "two values may be noise as well as a step");
        assert_eq!(steps(&[]), [0; 0]);
    }
}
