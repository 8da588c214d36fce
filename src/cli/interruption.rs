//! Ctrl-C: once, and no run is begun any more; twice, and those under way end; and if that takes too long, the program
//! does. SIGTERM, by which `timeout` and schedulers end a program and kill it soon after, is as good as the second
//! Ctrl-C.

use super::INTERRUPTED;
use anyhow::Context;
use rimbench::cosim::StopFlag;
use rimbench::harness::StopFlags;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// What a run needs to see the flag and to end. It looks in every step of its own; what else there may be gets no
/// longer.
const GRACE: Duration = Duration::from_millis(900);

/// What has been asked for by Ctrl-C or SIGTERM.
#[derive(Debug, Clone)]
pub(super) struct Interruption {
    /// Soon, and now.
    asked: Arc<[AtomicBool; 2]>,
    /// Whether runs are stored, from which the same command goes on.
    stores: bool,
}

/// The listener; without one the program leaves at once.
static LISTENING: Mutex<Option<Interruption>> = Mutex::new(None);

/// Ends the program; the processes of FMUs see to their own end.
fn leave() -> ! {
    rimbench::fmi::import::leave(INTERRUPTED)
}

/// Hands what was heard to who listens.
fn heard(act: impl Fn(&Interruption)) {
    let listening = LISTENING.lock().unwrap_or_else(PoisonError::into_inner).clone();
    listening.map_or_else(|| leave(), |interruption| act(&interruption));
}

/// From now on Ctrl-C and SIGTERM are heard.
///
/// # Errors
/// If the system does not allow it.
pub(super) fn listen() -> anyhow::Result<()> {
    hear_sigterm().context("cannot listen for SIGTERM")?;
    ctrlc::set_handler(|| heard(Interruption::ask)).context("cannot listen for Ctrl-C")
}

/// Not SIGHUP: who has begun this program with `nohup` wants it to go on.
#[cfg(unix)]
fn hear_sigterm() -> std::io::Result<()> {
    let mut signals = signal_hook::iterator::Signals::new([signal_hook::consts::SIGTERM])?;
    let listener = std::thread::Builder::new().name("sigterm".to_owned());
    listener.spawn(move || signals.forever().for_each(|_| heard(Interruption::end))).map(drop)
}

#[cfg(not(unix))]
fn hear_sigterm() -> std::io::Result<()> {
    Ok(())
}

impl Interruption {
    /// Begins to listen, for a command that `stores` its runs or does not.
    pub(super) fn listen(stores: bool) -> Self {
        let interruption = Interruption { asked: Arc::default(), stores };
        *LISTENING.lock().unwrap_or_else(PoisonError::into_inner) = Some(interruption.clone());
        interruption
    }

    fn ask(&self) {
        if !self.asked[0].swap(true, Ordering::Relaxed) {
            let then = if self.stores { ", after which the same command goes on from there" } else { "" };
            eprintln!("\nstopping after the runs in progress{then}; again to stop now");
            return;
        }
        self.end();
    }

    fn end(&self) {
        let [soon, now] = &*self.asked;
        soon.store(true, Ordering::Relaxed);
        if !now.swap(true, Ordering::Relaxed) {
            let then =
                if self.stores { "; what is stored is kept, and the same command goes on from there" } else { "" };
            eprintln!("\nstopping now{then}");
        }
        // Records are appended with one write each, so the store is whole at any time.
        std::thread::spawn(|| {
            std::thread::sleep(GRACE);
            leave();
        });
    }

    /// Whether a stop was asked for.
    pub(super) fn is_asked(&self) -> bool {
        self.asked[0].load(Ordering::Relaxed)
    }

    /// What the runs look at.
    pub(super) fn flags(&self) -> StopFlags<'_> {
        StopFlags { soon: StopFlag::new(&self.asked[0]), now: StopFlag::new(&self.asked[1]) }
    }
}
