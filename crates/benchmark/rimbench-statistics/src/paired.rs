//! Two scheme rows that are compared setting by setting: case, set of parameters, macro step.

use crate::Pool;
use std::collections::BTreeMap;

/// The error of a run of one of two scheme rows that are compared setting by setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairedRun<'t> {
    /// Case and set of parameters.
    pub problem: [&'t str; 2],
    /// H, s.
    pub macro_step: f64,
    /// Whether it is a run of the other of the two.
    pub is_other: bool,
    /// Infinite of a run that failed.
    pub error: f64,
    /// What an error must exceed to be known; NaN if nothing is.
    pub floor: f64,
}

/// Computes the medians of the two rows over the runs of each setting, and what an error must exceed to be known; a
/// setting in which either has no run is left out.
pub(crate) fn medians_by_setting<'t>(runs: impl IntoIterator<Item = PairedRun<'t>>) -> Vec<([f64; 2], f64)> {
    let mut settings: BTreeMap<_, ([Vec<f64>; 2], f64)> = BTreeMap::new();
    for run in runs {
        // Macro steps are above zero, so that their bits have their order.
        let (errors, floor) = settings.entry((run.problem, run.macro_step.to_bits())).or_default();
        errors[usize::from(run.is_other)].push(run.error);
        *floor = floor.max(run.floor);
    }
    let medians = |(errors, floor): ([Vec<f64>; 2], f64)| {
        let [Some(own), Some(other)] = errors.map(|errors| Pool::of(errors).median()) else { return None };
        Some(([own, other], floor))
    };
    settings.into_values().filter_map(medians).collect()
}

/// By what factor the error of one of two differs from that of the other, setting by setting.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PairedRatios {
    /// A ratio of medians for each setting: ∞ where only the one is infinite, 0 where only the other is.
    pub ratios: Vec<f64>,
    /// Settings without a ratio, because both are infinite.
    pub both_failed: usize,
    /// Settings without a ratio, because both are zero.
    pub both_zero: usize,
}

impl PairedRatios {
    /// Computes a ratio for each setting.
    ///
    /// ```text
    /// r_s = median_φ e_sφ / median_φ ê_sφ        s a setting, φ its phases, e = ∞ of a run that failed
    /// ```
    pub fn of<'t>(runs: impl IntoIterator<Item = PairedRun<'t>>) -> Self {
        let mut all = PairedRatios::default();
        for ([own, other], _) in medians_by_setting(runs) {
            match own / other {
                ratio if !ratio.is_nan() => all.ratios.push(ratio),
                _ if own.is_infinite() => all.both_failed += 1,
                _ => all.both_zero += 1,
            }
        }
        all
    }

    /// Says how many settings there are where there are several, and which have no ratio, to go behind what it is about.
    pub fn in_words(&self) -> String {
        let [ratios, failed, zero] = [self.ratios.len(), self.both_failed, self.both_zero];
        let all = ratios + failed + zero;
        let mut words = if all > 1 { format!(": the ratio in each of {ratios} settings") } else { String::new() };
        for (count, why) in [(failed, "both fail"), (zero, "both are zero")] {
            if count > 0 {
                words += &format!(", {count} left out in which {why}");
            }
        }
        words
    }
}
