//! In how many settings one is better than another.

use crate::paired::{PairedRun, medians_by_setting};

/// In how many settings (case, set of parameters, macro step) one of two has less error than the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Share {
    /// Settings in which it has less.
    pub better: usize,
    /// Settings in which it has more.
    pub worse: usize,
    /// Settings in which both fail, have as good as the same error, or have none that the reference could tell from
    /// zero.
    pub ties: usize,
}

impl Share {
    /// Compares the medians of each setting; one in which either has no run is left out. What differs by no more than
    /// the share `apart` of the other is as good as equal.
    pub fn of<'t>(runs: impl IntoIterator<Item = PairedRun<'t>>, apart: f64) -> Self {
        let mut share = Share::default();
        for ([own, other], floor) in medians_by_setting(runs) {
            match own.partial_cmp(&other) {
                _ if own <= floor && other <= floor => share.ties += 1,
                _ if other.is_finite() && (own - other).abs() <= apart * other => share.ties += 1,
                Some(std::cmp::Ordering::Less) => share.better += 1,
                Some(std::cmp::Ordering::Greater) => share.worse += 1,
                _ => share.ties += 1,
            }
        }
        share
    }

    /// Returns the share of the settings, ties aside, in which it has less error; none if there is no such setting.
    pub fn share(&self) -> Option<f64> {
        let compared = self.better + self.worse;
        (compared > 0).then(|| self.better as f64 / compared as f64)
    }

    /// Says what was counted, to go behind what it is about.
    pub fn in_words(&self) -> String {
        let ties = if self.ties == 0 { String::new() } else { format!(", and {} ties", self.ties) };
        format!(": {} of {}{ties}", self.better, self.better + self.worse)
    }
}
