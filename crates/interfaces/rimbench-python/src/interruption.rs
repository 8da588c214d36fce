//! Work without the lock of the interpreter, that Ctrl-C ends.

use crate::errors::{exception, with_raised};
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

/// Does `work` on a thread of its own, while this one lends the interpreter to whoever needs it, looks at signals, and
/// tells `progress`. With a part `of_python` one thread works, from which all callbacks come; without one all cores
/// may. Gives out the result, and the first exception that a callback raised. A signal, or an exception of `progress`,
/// raises the flag that the runs look at in every step.
///
/// # Errors
/// What the signal or `progress` raised; the error of the work as an exception.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    of_python: bool,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(StopFlag<'_>, &Count) -> Result<T> + Send,
) -> PyResult<(T, Option<PyErr>)> {
    let (flag, count) = (AtomicBool::new(false), Count::default());
    let ((done, raised), asked) = py.detach(|| {
        std::thread::scope(|scope| {
            let (end, ended) = channel::<()>();
            let (flag, count) = (&flag, &count);
            let worker = scope.spawn(move || {
                // Closed when the work ends, in whatever way.
                let _end = end;
                let work = || work(StopFlag::new(flag), count);
                if !of_python {
                    return (work(), None);
                }
                // Several threads would only wait for each other. A pool that takes in this thread would never be
                // freed.
                let alone = match ThreadPoolBuilder::new().num_threads(1).build() {
                    Ok(alone) => alone,
                    Err(error) => {
                        return (Err(Error::Incompatible(format!("no thread for what Python makes: {error}"))), None);
                    }
                };
                // Whoever calls back finds the thread known to the interpreter, which otherwise would be told of it
                // each time.
                alone.install(|| Python::attach(|py| py.detach(|| with_raised(work))))
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
    match done {
        Ok(done) => Ok((done, raised)),
        Err(Error::Stopped) => Err(PyKeyboardInterrupt::new_err(())),
        Err(error) => Err(exception(py, &error, raised)),
    }
}
