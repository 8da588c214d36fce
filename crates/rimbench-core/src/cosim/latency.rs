//! How long single macro steps take on this machine, and when a run has taken too long.

use std::time::{Duration, Instant};

/// What the macro loop does with the clock. By default it never looks at it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Timing {
    /// Measure the latency of each macro step.
    pub latency: bool,
    /// Give up at the first communication point after this much wall time.
    pub wall_limit: Option<Duration>,
}

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
    /// Statistics of latencies (s) against a deadline (s); `None` of none. Percentiles by nearest rank.
    ///
    /// ```text
    /// p_q = x_(⌈q n⌉),    x_(1) ≤ … ≤ x_(n)
    /// ```
    pub fn of(mut latencies: Vec<f64>, deadline: f64) -> Option<Self> {
        let n = latencies.len();
        let missed = latencies.iter().filter(|latency| **latency > deadline).count() as u64;
        // Three ranks need no sorted list.
        let mut rank = |percent: usize| {
            let index = (percent * n).div_ceil(100).max(1) - 1;
            (index < n).then(|| *latencies.select_nth_unstable_by(index, f64::total_cmp).1)
        };
        Some(Latency { p50_s: rank(50)?, p99_s: rank(99)?, max_s: rank(100)?, missed_deadlines: missed })
    }
}

/// The clock of one run. Room for all latencies is made beforehand.
#[derive(Debug)]
pub(super) struct Stopwatch {
    timing: Timing,
    started: Instant,
    lap: Instant,
    so_far: Duration,
    pub(super) latencies: Vec<f64>,
}

impl Stopwatch {
    pub(super) fn new(timing: Timing, macro_steps: usize) -> Self {
        let now = Instant::now();
        let latencies = Vec::with_capacity(if timing.latency { macro_steps } else { 0 });
        Stopwatch { timing, started: now, lap: now, so_far: Duration::ZERO, latencies }
    }

    /// Whether the wall limit has passed.
    #[inline]
    pub(super) fn expired(&self) -> bool {
        self.timing.wall_limit.is_some_and(|limit| self.started.elapsed() > limit)
    }

    /// A macro step begins.
    #[inline]
    pub(super) fn begin(&mut self) {
        self.so_far = Duration::ZERO;
        self.resume();
    }

    /// Something that is no part of the macro step follows.
    #[inline]
    pub(super) fn pause(&mut self) {
        if self.timing.latency {
            self.so_far += self.lap.elapsed();
        }
    }

    /// The macro step goes on.
    #[inline]
    pub(super) fn resume(&mut self) {
        if self.timing.latency {
            self.lap = Instant::now();
        }
    }

    /// The macro step is done.
    #[inline]
    pub(super) fn end(&mut self) {
        if self.timing.latency {
            self.pause();
            self.latencies.push(self.so_far.as_secs_f64());
        }
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

    #[test]
    fn a_stopwatch_leaves_out_what_happens_between_pause_and_resume() {
        let mut watch = Stopwatch::new(Timing { latency: true, wall_limit: Some(Duration::ZERO) }, 1);
        watch.begin();
        watch.pause();
        std::thread::sleep(Duration::from_millis(20));
        watch.resume();
        watch.end();
        assert!(watch.latencies[0] < 0.015, "{:?}", watch.latencies);
        assert!(watch.expired());
        let mut off = Stopwatch::new(Timing::default(), 1);
        off.begin();
        off.end();
        assert!(off.latencies.is_empty() && !off.expired());
    }
}
