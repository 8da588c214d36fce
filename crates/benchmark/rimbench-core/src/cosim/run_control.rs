//! Limits that end a run from outside, and how long its macro steps take: the only place where the loop looks at a
//! clock, which it is given.

use super::latencies::Latencies;
use crate::error::{Cause, Failure};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A request that a simulation should end, read in every step.
#[derive(Debug, Clone, Copy)]
pub struct StopFlag<'a>(&'a AtomicBool);

impl<'a> StopFlag<'a> {
    /// Makes a flag that another thread may raise.
    pub fn new(flag: &'a AtomicBool) -> Self {
        StopFlag(flag)
    }

    /// Makes a flag that is never raised.
    pub fn never() -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        StopFlag(&NEVER)
    }

    /// Ends what is under way if the flag is up.
    ///
    /// # Errors
    /// [`Cause::Stopped`].
    #[inline]
    pub fn check(self) -> Result<(), Failure> {
        if self.0.load(Ordering::Relaxed) { Err(Cause::Stopped.into()) } else { Ok(()) }
    }
}

/// A clock and what to do with it.
#[derive(Debug, Clone, Copy)]
pub struct Timer {
    /// Time since some instant before the run; never goes back.
    pub now: fn() -> Duration,
    /// Measure the latency of each macro step, against this deadline.
    pub deadline: Option<Duration>,
    /// Give up at the first communication point after this much wall time.
    pub wall_limit: Option<Duration>,
}

/// How a run is watched over. By default it is not stopped, and it has no clock.
#[derive(Debug, Clone, Copy)]
pub struct RunControl<'a> {
    /// The means to end it.
    pub stop: StopFlag<'a>,
    /// The clock, if it may know one.
    pub timer: Option<Timer>,
    /// Note what the actuator did in each micro step, where the loop itself runs the scheme (see
    /// [`Report::inside`](super::Report)), with room for at most this many: of a longer run an observer takes them out
    /// as it goes on.
    pub inside: Option<usize>,
    /// Keep account of the energy that the scheme's interface model creates, where the loop itself runs it (see
    /// [`ModelEnergy`](super::ModelEnergy)).
    pub audit: bool,
}

impl Default for RunControl<'_> {
    fn default() -> Self {
        RunControl { stop: StopFlag::never(), timer: None, inside: None, audit: false }
    }
}

/// The stopwatch of one run.
///
/// The latency of a macro step is the wall time from the end of the macro step before until both sides have covered
/// this one; what observers do at the communication point is not part of it.
#[derive(Debug)]
pub(crate) struct Stopwatch {
    timer: Option<Timer>,
    started: Duration,
    lap: Duration,
    so_far: Duration,
    pub(crate) latencies: Option<Latencies>,
}

impl Stopwatch {
    pub(crate) fn new(timer: Option<Timer>) -> Self {
        let now = timer.map_or(Duration::ZERO, |timer| (timer.now)());
        let latencies = timer.and_then(|timer| timer.deadline).map(Latencies::new);
        Stopwatch { timer, started: now, lap: now, so_far: Duration::ZERO, latencies }
    }

    /// Tells whether the wall limit has passed.
    #[inline]
    pub(crate) fn expired(&self) -> bool {
        let limit = |timer: &Timer| Some((timer.now, timer.wall_limit?));
        self.timer.as_ref().and_then(limit).is_some_and(|(now, limit)| now() - self.started > limit)
    }

    /// The clock, if latencies are measured.
    #[inline]
    fn measuring(&self) -> Option<fn() -> Duration> {
        self.timer.filter(|timer| timer.deadline.is_some()).map(|timer| timer.now)
    }

    /// Begins a macro step where the one before ended: what the loop does in between belongs to it, and a clock is not
    /// free.
    #[inline]
    pub(crate) fn begin(&mut self) {
        self.so_far = Duration::ZERO;
    }

    /// Stops the clock for something that is no part of the macro step.
    #[inline]
    pub(crate) fn pause(&mut self) {
        if let Some(now) = self.measuring() {
            let now = now();
            self.so_far += now - self.lap;
            self.lap = now;
        }
    }

    /// Starts the clock again: the macro step goes on.
    #[inline]
    pub(crate) fn resume(&mut self) {
        if let Some(now) = self.measuring() {
            self.lap = now();
        }
    }

    /// Ends the macro step.
    #[inline]
    pub(crate) fn end(&mut self) {
        self.pause();
        if let Some(latencies) = &mut self.latencies {
            latencies.record(self.so_far);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    thread_local! {
        static NOW: Cell<u64> = const { Cell::new(0) };
    }

    fn now() -> Duration {
        Duration::from_secs(NOW.get())
    }

    fn pass(seconds: u64) {
        NOW.set(NOW.get() + seconds);
    }

    #[test]
    fn a_stopwatch_leaves_out_what_happens_between_pause_and_resume() {
        let timer = Timer { now, deadline: Some(Duration::from_secs(1)), wall_limit: Some(Duration::from_secs(5)) };
        let mut stopwatch = Stopwatch::new(Some(timer));
        stopwatch.begin();
        pass(1);
        stopwatch.pause();
        pass(3);
        stopwatch.resume();
        pass(1);
        stopwatch.end();
        let latencies = stopwatch.latencies.as_ref().unwrap();
        assert_eq!((latencies.longest_s(), latencies.missed()), (2.0, 1));
        assert!(!stopwatch.expired());
        pass(1);
        assert!(stopwatch.expired());
    }

    #[test]
    fn without_a_clock_nothing_is_measured_and_nothing_expires() {
        for timer in [None, Some(Timer { now, deadline: None, wall_limit: None })] {
            let mut stopwatch = Stopwatch::new(timer);
            stopwatch.begin();
            pass(1000);
            stopwatch.end();
            assert!(stopwatch.latencies.is_none() && !stopwatch.expired());
        }
    }

    #[test]
    fn a_raised_flag_ends_what_is_under_way() {
        let flag = AtomicBool::new(false);
        assert_eq!(StopFlag::new(&flag).check(), Ok(()));
        flag.store(true, Ordering::Relaxed);
        assert_eq!(StopFlag::new(&flag).check(), Err(Cause::Stopped.into()));
        assert_eq!(StopFlag::never().check(), Ok(()));
    }
}
