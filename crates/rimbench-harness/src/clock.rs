//! The clock of this machine, for the runs that are timed.

use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// Time since somebody first asked, by the monotonic clock.
pub fn monotonic_clock() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}
