//! The clock of this machine, for the runs that are timed.

use std::time::Duration;

/// Reads the monotonic clock: time since some instant before the program began.
///
/// `Instant` knows only differences, each of which costs as much as looking at the clock; a run looks three times per
/// macro step.
#[cfg(unix)]
pub fn monotonic_clock() -> Duration {
    // POSIX demands this clock.
    time_of(nix::time::ClockId::CLOCK_MONOTONIC)
}

/// Reads the processor time of this thread, which other programs on the machine do not change. Waiting for a subsystem
/// in a process of its own is not in it. Where the system has no such clock it is [`monotonic_clock`].
#[cfg(any(target_os = "linux", target_os = "macos"))]
pub fn processor_clock() -> Duration {
    time_of(nix::time::ClockId::CLOCK_THREAD_CPUTIME_ID)
}

#[cfg(unix)]
fn time_of(clock: nix::time::ClockId) -> Duration {
    let now = nix::time::clock_gettime(clock);
    now.map_or(Duration::ZERO, |now| Duration::new(now.tv_sec() as u64, now.tv_nsec() as u32))
}

/// Reads [`monotonic_clock`].
#[cfg(not(any(target_os = "linux", target_os = "macos")))]
pub fn processor_clock() -> Duration {
    monotonic_clock()
}

/// Reads the monotonic clock: time since its first reading.
#[cfg(not(unix))]
pub fn monotonic_clock() -> Duration {
    static START: std::sync::LazyLock<std::time::Instant> = std::sync::LazyLock::new(std::time::Instant::now);
    START.elapsed()
}
