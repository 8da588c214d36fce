//! The clock of this machine, for the runs that are timed.

use std::time::Duration;

/// Reads the monotonic clock: time since some instant before the program began.
///
/// `Instant` knows only differences, each of which costs as much as looking at the clock; a run looks three times per macro step.
#[cfg(unix)]
pub fn monotonic_clock() -> Duration {
    // POSIX demands this clock.
    clock(nix::time::ClockId::CLOCK_MONOTONIC)
}

#[cfg(unix)]
fn clock(id: nix::time::ClockId) -> Duration {
    let now = nix::time::clock_gettime(id);
    now.map_or(Duration::ZERO, |now| Duration::new(now.tv_sec() as u64, now.tv_nsec() as u32))
}

/// Reads the monotonic clock: time since somebody first asked.
#[cfg(not(unix))]
pub fn monotonic_clock() -> Duration {
    static START: std::sync::LazyLock<std::time::Instant> = std::sync::LazyLock::new(std::time::Instant::now);
    START.elapsed()
}

/// Reads the processor time of this thread; where there is no such clock, the monotonic one.
pub(crate) fn thread_time() -> Duration {
    #[cfg(unix)]
    return clock(nix::time::ClockId::CLOCK_THREAD_CPUTIME_ID);
    #[cfg(not(unix))]
    monotonic_clock()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_goes_on_and_never_back() {
        let (first, begun) = (monotonic_clock(), std::time::Instant::now());
        while begun.elapsed() < Duration::from_millis(2) {}
        assert!(monotonic_clock() - first >= Duration::from_millis(2));
    }
}
