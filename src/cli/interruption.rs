//! Ctrl-C: once, and no run is begun any more; twice, and those under way end; and if that takes too long, the program does.

use super::INTERRUPTED;
use anyhow::Context;
use rimbench::cosim::StopFlag;
use rimbench::harness::StopFlags;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// What a run needs to see the flag and to end. It looks in every step of its own; what else there may be gets no longer.
const GRACE: Duration = Duration::from_millis(900);

/// What has been asked for by Ctrl-C.
#[derive(Debug, Clone, Default)]
pub(super) struct Interruption(Arc<[AtomicBool; 2]>);

impl Interruption {
    /// Begins to listen.
    ///
    /// # Errors
    /// If the system does not allow it.
    pub(super) fn listen() -> anyhow::Result<Self> {
        let interruption = Interruption::default();
        let asked = interruption.clone();
        ctrlc::set_handler(move || asked.ask()).context("cannot listen for Ctrl-C")?;
        Ok(interruption)
    }

    fn ask(&self) {
        let [soon, now] = &*self.0;
        if !soon.swap(true, Ordering::Relaxed) {
            eprintln!("\nstopping after the runs in progress; again to stop now");
            return;
        }
        if !now.swap(true, Ordering::Relaxed) {
            eprintln!("\nstopping now; what is stored is kept");
        }
        // Records are appended with one write each, so the store is whole at any time.
        std::thread::spawn(|| {
            std::thread::sleep(GRACE);
            std::process::exit(INTERRUPTED.into());
        });
    }

    /// Whether somebody has asked.
    pub(super) fn is_asked(&self) -> bool {
        self.0[0].load(Ordering::Relaxed)
    }

    /// What the runs look at.
    pub(super) fn flags(&self) -> StopFlags<'_> {
        StopFlags { soon: StopFlag::new(&self.0[0]), now: StopFlag::new(&self.0[1]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_time_runs_go_on_and_the_second_time_they_end() {
        let interruption = Interruption::default();
        let seen = |of: &Interruption| [of.flags().soon.check().is_err(), of.flags().now.check().is_err()];
        assert_eq!((seen(&interruption), interruption.is_asked()), ([false, false], false));
        interruption.ask();
        assert_eq!((seen(&interruption), interruption.is_asked()), ([true, false], true));
    }
}
