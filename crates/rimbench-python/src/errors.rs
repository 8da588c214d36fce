//! What goes wrong in Rust as an exception of Python, and the other way round.

use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rimbench::error::{Error, Failure};
use std::sync::{Arc, Mutex, PoisonError};

create_exception!(
    rimbench,
    RimbenchError,
    PyValueError,
    "Bad input, in the words of the command line: what is wrong, and what would be valid."
);

/// The first exception that a callback raised during a call, kept whole: the run itself only knows it in words.
#[derive(Debug, Clone, Default)]
pub struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// Keeps an exception unless there is one, and puts it in words.
    fn keep(&self, py: Python<'_>, error: PyErr) -> String {
        let words = in_words(py, &error);
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        words
    }

    /// Keeps an exception that ends a run.
    pub fn failure(&self, py: Python<'_>, error: PyErr) -> Failure {
        Failure::reported(self.keep(py, error))
    }

    /// Keeps an exception for which there is nothing to run.
    pub fn error(&self, py: Python<'_>, error: PyErr) -> Error {
        Error::Incompatible(self.keep(py, error))
    }

    /// Gives out what was kept.
    pub fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
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
pub fn exception(py: Python<'_>, error: &Error, raised: &[Raised]) -> PyErr {
    let exception = RimbenchError::new_err(error.to_string());
    if let Some(cause) = raised.iter().find_map(Raised::take) {
        exception.set_cause(py, Some(cause));
    }
    exception
}
