//! Work without the lock of the interpreter, that Ctrl-C ends.

use crate::errors::{Raised, exception};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;
use rimbench::cosim::StopFlag;
use rimbench::error::{Error, Result};
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How often signals are looked at, and progress is told.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// How much of something is done.
#[derive(Debug, Default)]
pub struct Count {
    /// So much.
    pub done: AtomicUsize,
    /// Of so much.
    pub total: AtomicUsize,
}

impl Count {
    fn now(&self) -> (usize, usize) {
        (self.done.load(Ordering::Relaxed), self.total.load(Ordering::Relaxed))
    }
}

/// Does `work` on a thread of its own, while this one lends the interpreter to whoever needs it, looks at signals, and tells `progress`.
/// `raised` has an entry for everything that Python made; with none all cores may work.
/// A signal, or an exception of `progress`, raises the flag that the runs look at in every step.
///
/// # Errors
/// What the signal or `progress` raised; the error of the work as an exception.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    raised: &[Raised],
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(StopFlag<'_>, &Count) -> Result<T> + Send,
) -> PyResult<T> {
    // Of an earlier call.
    raised.iter().for_each(|raised| drop(raised.take()));
    let (flag, count) = (AtomicBool::new(false), Count::default());
    let (done, asked) = py.detach(|| {
        std::thread::scope(|scope| {
            let (end, ended) = channel::<()>();
            let (flag, count) = (&flag, &count);
            let worker = scope.spawn(move || {
                // Closed when the work ends, in whatever way.
                let _end = end;
                let work = || work(StopFlag::new(flag), count);
                if raised.is_empty() {
                    return work();
                }
                // Whoever calls back finds this thread known to the interpreter, which otherwise would be told of it each time; and
                // several threads would only wait for each other.
                match ThreadPoolBuilder::new().num_threads(1).use_current_thread().build() {
                    Ok(alone) => Python::attach(|py| py.detach(|| alone.install(work))),
                    Err(error) => Err(Error::Incompatible(format!("no thread for what Python makes: {error}"))),
                }
            });
            let mut asked = None;
            let mut told = (0, 0);
            let mut look = |py: Python<'_>| -> PyResult<()> {
                py.check_signals()?;
                let now = count.now();
                if let Some(progress) = progress.filter(|_| now != told) {
                    progress.call1(py, now)?;
                    told = now;
                }
                Ok(())
            };
            while ended.recv_timeout(LOOK_EVERY) == Err(RecvTimeoutError::Timeout) {
                if asked.is_none() {
                    asked = Python::attach(&mut look).err();
                    flag.fetch_or(asked.is_some(), Ordering::Relaxed);
                }
            }
            let done = worker.join().unwrap_or_else(|panic| resume_unwind(panic));
            asked = asked.or_else(|| Python::attach(&mut look).err());
            (done, asked)
        })
    });
    if let Some(asked) = asked {
        return Err(asked);
    }
    done.map_err(|error| match error {
        Error::Stopped => PyKeyboardInterrupt::new_err(()),
        error => exception(py, &error, raised),
    })
}
