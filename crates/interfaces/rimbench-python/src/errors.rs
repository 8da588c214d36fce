//! What goes wrong in Rust as an exception of Python, and the other way round.

use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rimbench::error::{Error, Failure, without_system_number};
use std::cell::Cell;

create_exception!(
    rimbench,
    RimbenchError,
    PyValueError,
    "Bad input, in the words of the command line: what is wrong, and what would be valid."
);

/// An exception kept whole, and in words, which is all that the run itself knows of it.
struct Raised {
    error: PyErr,
    words: String,
}

thread_local! {
    /// The first exception that a callback raised during the call that this thread works for. All callbacks of a call
    /// come from one thread, so that calls from several threads, with the same case even, have nothing in common.
    static RAISED: Cell<Option<Raised>> = const { Cell::new(None) };
}

/// Does `work`, and gives out the first exception that its callbacks raised on this thread.
pub fn with_raised<T>(work: impl FnOnce() -> T) -> (T, Option<PyErr>) {
    // A callback may make a case, which calls back in turn.
    let outer = RAISED.take();
    let done = work();
    (done, RAISED.replace(outer).map(|raised| raised.error))
}

/// Keeps an exception unless there is one, and puts it in words.
pub fn keep(py: Python<'_>, error: PyErr) -> String {
    let words = in_words(py, &error);
    let raised = Raised { error, words: words.clone() };
    let first = RAISED.take().unwrap_or(raised);
    RAISED.set(Some(first));
    words
}

/// Keeps an exception that ends a run.
pub fn failure(py: Python<'_>, error: PyErr) -> Failure {
    Failure::reported(keep(py, error))
}

/// Keeps an exception for which there is nothing to run.
pub fn error(py: Python<'_>, error: PyErr) -> Error {
    Error::Incompatible(keep(py, error))
}

/// What was raised so far, in words.
pub fn raised_so_far() -> Option<String> {
    let raised = RAISED.take();
    let words = raised.as_ref().map(|raised| raised.words.clone());
    RAISED.set(raised);
    words
}

/// An exception in one line: kind, message, and where it was raised.
fn in_words(py: Python<'_>, error: &PyErr) -> String {
    let place = || -> PyResult<String> {
        let mut innermost = error.traceback(py).ok_or_else(|| PyValueError::new_err("no traceback"))?.into_any();
        loop {
            let next = innermost.getattr("tb_next")?;
            if next.is_none() {
                break;
            }
            innermost = next;
        }
        let code = innermost.getattr("tb_frame")?.getattr("f_code")?;
        let file: String = code.getattr("co_filename")?.extract()?;
        let file = std::path::Path::new(&file).file_name().map(|name| name.to_string_lossy().into_owned());
        let (line, function) = (innermost.getattr("tb_lineno")?, code.getattr("co_name")?);
        Ok(format!(" ({}, line {line}, in {function})", file.unwrap_or_default()))
    };
    format!("{error}{}", place().unwrap_or_default()).replace('\n', "; ")
}

/// The exception for an error, with the exception of a callback that caused it, if one did.
pub fn exception(py: Python<'_>, error: &Error, raised: Option<PyErr>) -> PyErr {
    let exception = RimbenchError::new_err(without_system_number(&error.to_string()));
    if raised.is_some() {
        exception.set_cause(py, raised);
    }
    exception
}
