//! How long macro steps took, in room that does not grow with their number.

use hdrhistogram::Histogram;
use std::time::Duration;

/// The longest that is told apart; a longer one counts as this much in a percentile.
const LONGEST: Duration = Duration::from_secs(3600);

/// Wall times of macro steps, counted in classes that are at most a thousandth wide, and how many took longer than a
/// deadline.
#[derive(Debug, Clone, PartialEq)]
pub struct Latencies {
    nanoseconds: Histogram<u32>,
    deadline: Duration,
    longest: Duration,
    missed: u64,
}

impl Latencies {
    /// Makes room for any number, none of which has been seen.
    pub fn new(deadline: Duration) -> Self {
        let nanoseconds = Histogram::new_with_bounds(1, LONGEST.as_nanos() as u64, 3);
        let nanoseconds = nanoseconds.expect("three digits from 1 ns to an hour are bounds of a histogram");
        Latencies { nanoseconds, deadline, longest: Duration::ZERO, missed: 0 }
    }

    /// Notes that a macro step took this long.
    pub fn record(&mut self, latency: Duration) {
        self.nanoseconds.saturating_record(latency.as_nanos().min(LONGEST.as_nanos()) as u64);
        self.longest = self.longest.max(latency);
        self.missed += u64::from(latency > self.deadline);
    }

    /// Returns the percentile by nearest rank, s, to a thousandth of it; none if nothing was noted.
    pub fn percentile_s(&self, percent: f64) -> Option<f64> {
        let value = Duration::from_nanos(self.nanoseconds.value_at_percentile(percent)).min(self.longest);
        (!self.nanoseconds.is_empty()).then_some(value.as_secs_f64())
    }

    /// Counts them.
    pub fn count(&self) -> u64 {
        self.nanoseconds.len()
    }

    /// Returns the longest, s.
    pub fn longest_s(&self) -> f64 {
        self.longest.as_secs_f64()
    }

    /// Counts those longer than the deadline.
    pub fn missed(&self) -> u64 {
        self.missed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_nearest_rank_to_a_thousandth() {
        let mut latencies = Latencies::new(Duration::from_millis(150));
        assert_eq!(latencies.percentile_s(50.0), None);
        (1..=200).rev().for_each(|ms| latencies.record(Duration::from_millis(ms)));
        for (percent, expected) in [(50.0, 0.1), (99.0, 0.198), (100.0, 0.2)] {
            let found = latencies.percentile_s(percent).unwrap();
            assert!((found / expected - 1.0).abs() < 1e-3, "{percent}: {found}");
        }
        assert_eq!((latencies.longest_s(), latencies.missed()), (0.2, 50));
    }

    #[test]
    fn one_of_days_is_the_longest_and_one_of_nothing_is_seen() {
        let mut latencies = Latencies::new(Duration::from_secs(1));
        latencies.record(Duration::ZERO);
        assert_eq!((latencies.percentile_s(50.0), latencies.missed()), (Some(0.0), 0));
        latencies.record(Duration::from_secs(1_000_000));
        assert_eq!((latencies.longest_s(), latencies.missed()), (1e6, 1));
        assert!(latencies.percentile_s(100.0).unwrap() > 3590.0);
    }
}
