//! Values of several runs, and what they come to.

use crate::{bootstrap_interval, order_of_convergence, quantile};

/// Values of several runs, grouped by what may be drawn independently.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pool {
    values: Vec<f64>,
    /// Where each group ends.
    ends: Vec<usize>,
}

impl Pool {
    /// Pools values of which each is independent of the others.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.into_iter().filter(|value| !value.is_nan()).collect();
        Pool { ends: (1..=values.len()).collect(), values }
    }

    /// Pools values in groups; values of one group depend on each other. NaN is no value.
    pub fn grouped(groups: impl IntoIterator<Item = Vec<f64>>) -> Self {
        let mut pool = Pool::default();
        for group in groups {
            pool.values.extend(group.into_iter().filter(|value| !value.is_nan()));
            pool.ends.push(pool.values.len());
        }
        pool.ends.dedup();
        pool.ends.retain(|&end| end > 0);
        pool
    }

    /// Returns the middle value, of two middle values their mean; none of an empty pool.
    pub fn median(&self) -> Option<f64> {
        median(self.values.clone())
    }

    /// Returns the lower quartile, the median and the upper quartile, see [`quantile`]; NaN for an empty pool.
    pub fn quartiles(&self) -> [f64; 3] {
        [0.25, 0.5, 0.75].map(|p| quantile(&self.values, p))
    }

    /// Returns the least and the largest value; none of an empty pool.
    pub fn range(&self) -> Option<[f64; 2]> {
        let values = || self.values.iter().copied();
        Some([values().reduce(f64::min)?, values().reduce(f64::max)?])
    }

    /// Returns the mean; none of an empty pool.
    pub fn mean(&self) -> Option<f64> {
        (!self.values.is_empty()).then(|| self.values.iter().sum::<f64>() / self.values.len() as f64)
    }

    /// Returns the 95 % interval of the median, see [`bootstrap_interval`]; none of fewer than two groups.
    pub fn interval(&self) -> Option<[f64; 2]> {
        let starts = [0].into_iter().chain(self.ends.iter().copied());
        let groups: Vec<Vec<f64>> = starts.zip(&self.ends).map(|(from, &to)| self.values[from..to].to_vec()).collect();
        bootstrap_interval(&groups, median)
    }
}

/// ```text
/// ½ (x_(⌈n/2⌉) + x_(⌊n/2⌋+1)),    x_(1) ≤ … ≤ x_(n)
/// ```
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (n > 0).then(|| 0.5 * (values[(n - 1) / 2] + values[n / 2]))
}

/// Returns the values at equal abscissas, by ascending abscissa; what has no finite abscissa is left out.
pub fn by_abscissa<T>(pairs: impl IntoIterator<Item = (f64, T)>) -> Vec<(f64, Vec<T>)> {
    let mut pairs: Vec<(f64, T)> = pairs.into_iter().filter(|(x, _)| x.is_finite()).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut groups: Vec<(f64, Vec<T>)> = Vec::new();
    for (x, value) in pairs {
        match groups.last_mut() {
            Some((last, group)) if *last == x => group.push(value),
            _ => groups.push((x, vec![value])),
        }
    }
    groups
}

/// Fits the order of convergence of the medians at each macro step, see [`order_of_convergence`].
///
/// # Shapes and units
/// Pairs (H in s, error in any unit), several per macro step.
pub fn order_of_medians(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<f64> {
    let medians = by_abscissa(pairs).into_iter().filter_map(|(step, errors)| Some((step, median(errors)?)));
    order_of_convergence(&medians.collect::<Vec<_>>())
}
