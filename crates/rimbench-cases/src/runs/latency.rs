//! How long single macro steps took.

use rimbench_statistics::nearest_rank;

/// Latency of single macro steps: the wall time from the exchange at `t_k` until both sides have covered the macro step.
///
/// What observers do at the communication point is not part of it. Depends on machine and load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Latency {
    /// Median, s.
    pub p50_s: f64,
    /// 99th percentile, s.
    pub p99_s: f64,
    /// Longest, s.
    pub max_s: f64,
    /// Macro steps that took longer than the deadline.
    pub missed_deadlines: u64,
}

impl Latency {
    /// Statistics of latencies (s) against a deadline (s), percentiles by nearest rank; none of none.
    pub fn of(mut latencies: Vec<f64>, deadline: f64) -> Option<Self> {
        let missed_deadlines = latencies.iter().filter(|latency| **latency > deadline).count() as u64;
        let [p50_s, p99_s, max_s] = [50, 99, 100].map(|percent| nearest_rank(&mut latencies, percent));
        Some(Latency { p50_s: p50_s?, p99_s: p99_s?, max_s: max_s?, missed_deadlines })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_nearest_rank() {
        let latency = Latency::of((1..=200).rev().map(f64::from).collect(), 150.0).unwrap();
        assert_eq!((latency.p50_s, latency.p99_s, latency.max_s, latency.missed_deadlines), (100.0, 198.0, 200.0, 50));
        let one = Latency::of(vec![3.0], 3.0).unwrap();
        assert_eq!((one.p50_s, one.p99_s, one.max_s, one.missed_deadlines), (3.0, 3.0, 3.0, 0));
        assert_eq!(Latency::of(Vec::new(), 1.0), None);
    }
}
