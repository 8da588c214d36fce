//! Ranks that say no more than the data do: who cannot be told apart shares one.

use crate::bootstrap_interval;

/// Where a competitor stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rank {
    /// One more than the number of those that are surely better. Who cannot be told from the best is first.
    pub first: usize,
    /// All but those that are surely worse.
    pub last: usize,
}

/// Ranks competitors by the mean of a quantity over witnesses, of which less is better.
///
/// ```text
/// A is surely better than B where the 95 % bootstrap interval of  mean_w (a_w − b_w)  lies below zero
/// ```
/// `values[c][w]` is what competitor c has with witness w (a case, say); all have all of them. The witnesses are drawn, the same
/// for both, so that what is hard for everybody tells nobody apart. Of a single witness nothing is sure: all are first. Who is surely better
/// than whom is asked pair by pair, with no allowance for the number of pairs: of twenty pairs that are equal in truth, one is told apart.
///
/// # Panics
/// If the competitors have not been given equally many witnesses.
/// # Source
/// Ours; ranks from pairwise intervals as in Goldstein, Spiegelhalter: League tables and their limitations, J. R. Stat. Soc. A 159 (1996).
pub fn ranks(values: &[Vec<f64>]) -> Vec<Rank> {
    let witnesses = values.first().map_or(0, Vec::len);
    assert!(values.iter().all(|own| own.len() == witnesses), "every competitor has a value for every witness");
    let (mut better, mut worse) = (vec![0; values.len()], vec![0; values.len()]);
    for (a, of_a) in values.iter().enumerate() {
        for (b, of_b) in values.iter().enumerate().skip(a + 1) {
            let differences: Vec<Vec<f64>> = of_a.iter().zip(of_b).map(|(a, b)| vec![a - b]).collect();
            match bootstrap_interval(&differences, |drawn| Some(drawn.iter().sum::<f64>())) {
                Some([_, high]) if high < 0.0 => (better[b], worse[a]) = (better[b] + 1, worse[a] + 1),
                Some([low, _]) if low > 0.0 => (better[a], worse[b]) = (better[a] + 1, worse[b] + 1),
                _ => {}
            }
        }
    }
    better
        .into_iter()
        .zip(worse)
        .map(|(better, worse)| Rank { first: 1 + better, last: values.len() - worse })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(values: &[&[f64]]) -> Vec<(usize, usize)> {
        let values: Vec<Vec<f64>> = values.iter().map(|own| own.to_vec()).collect();
        ranks(&values).iter().map(|rank| (rank.first, rank.last)).collect()
    }

    #[test]
    fn who_is_better_with_every_witness_is_ahead_and_who_is_better_with_half_of_them_is_not() {
        let (low, high, mixed): (&[f64], &[f64], &[f64]) =
            (&[1.0, 2.0, 3.0, 4.0], &[1.1, 2.1, 3.1, 4.1], &[0.5, 2.5, 2.5, 4.5]);
        assert_eq!(pairs(&[low, high]), [(1, 1), (2, 2)]);
        assert_eq!(pairs(&[high, low]), [(2, 2), (1, 1)]);
        assert_eq!(pairs(&[low, mixed]), [(1, 2), (1, 2)]);
        // In the middle of three: told from nobody, although the others are told apart.
        assert_eq!(pairs(&[low, mixed, high]), [(1, 2), (1, 3), (2, 3)]);
    }

    #[test]
    fn equals_share_a_rank_and_one_witness_proves_nothing() {
        assert_eq!(pairs(&[&[1.0, 2.0], &[1.0, 2.0]]), [(1, 2), (1, 2)]);
        assert_eq!(pairs(&[&[1.0], &[9.0]]), [(1, 2), (1, 2)]);
        assert_eq!(pairs(&[&[1.0, 2.0]]), [(1, 1)]);
        assert_eq!(pairs(&[]), []);
    }

    /// What is hard for everybody: with unpaired witnesses the spread would hide a difference that every witness shows.
    #[test]
    fn witnesses_are_drawn_for_both() {
        let hard: Vec<f64> = (0..12).map(|w| f64::from(w) * 10.0).collect();
        let less: Vec<f64> = hard.iter().enumerate().map(|(w, value)| value - 0.1 - 0.01 * w as f64).collect();
        assert_eq!(pairs(&[&hard, &less]), [(2, 2), (1, 1)]);
    }
}
