//! Values that a call gives or a callback returns.

use crate::errors::RimbenchError;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyList, PyString, PyTuple};
use rimbench::error::{Error, shortened};

/// The error of a value that is of a kind that cannot be.
pub fn wrong_kind(key: &str, value: &Bound<'_, PyAny>, valid: &str) -> PyErr {
    let shown = value.repr().map_or_else(|_| "?".to_owned(), |text| shortened(&text.to_string_lossy()));
    let kind = value.get_type().name().map_or_else(|_| "?".to_owned(), |name| name.to_string());
    PyTypeError::new_err(format!("{key} = {shown} ({kind}) is not valid; valid: {valid}"))
}

/// A value of the kind that is wanted; a whole number beyond all use is of that kind and not valid.
pub fn given<T: for<'py> FromPyObjectOwned<'py>>(key: &str, value: &Bound<'_, PyAny>, valid: &str) -> PyResult<T> {
    value.extract().map_err(|error| match Into::<PyErr>::into(error) {
        error if error.is_instance_of::<PyOverflowError>(value.py()) => {
            let shown = value.str().map_or_else(|_| "?".to_owned(), |text| text.to_string_lossy().into_owned());
            RimbenchError::new_err(Error::invalid(key, shown, valid).to_string())
        }
        _ => wrong_kind(key, value, valid),
    })
}

/// A number of something.
pub fn count<T: for<'py> FromPyObjectOwned<'py>>(key: &str, value: &Bound<'_, PyAny>) -> PyResult<T> {
    let valid = "a whole number from 1";
    if is_truth(value)? { Err(wrong_kind(key, value, valid)) } else { given(key, value, valid) }
}

/// A number that a call gives: of one that has fewer digits than ours those that it has (`np.float32(5e-3)` is 0.005),
/// and of a truth none.
pub fn number(key: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let wrong = || wrong_kind(key, value, "a number");
    if is_truth(value)? {
        return Err(wrong());
    }
    let number: f64 = given(key, value, "a number, at most 1.8e308")?;
    let is_short = match value.getattr_opt("dtype")? {
        Some(dtype) => {
            dtype.getattr("kind")?.extract::<String>()? == "f" && dtype.getattr("itemsize")?.extract::<usize>()? < 8
        }
        None => false,
    };
    if is_short { value.str()?.to_str()?.parse().map_err(|_| wrong()) } else { Ok(number) }
}

/// Whether a value is a truth of Python or of NumPy.
pub fn is_truth(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    Ok(value.is_instance_of::<PyBool>() || value.get_type().name()?.to_str()?.starts_with("bool"))
}

/// Copies a sequence of numbers, which `what` returned, to a place of the same length.
pub fn fill(value: &Bound<'_, PyAny>, what: &str, to: &mut [f64]) -> PyResult<()> {
    let wanted = to.len();
    let wrong = |found: usize| PyValueError::new_err(format!("{what} gives {found} numbers instead of {wanted}"));
    let put = |to: &mut f64, item: &Bound<'_, PyAny>| {
        let read = item.extract().map_err(|_| wrong_kind(&format!("a number that {what} gives"), item, "a number"));
        read.map(|number| *to = number)
    };
    // Tuples, lists and arrays are read in place; any other sequence is copied.
    if let Some(array) = value.cast::<PyArray1<f64>>().ok().and_then(|array| array.try_readonly().ok()) {
        let array = array.as_array();
        if array.len() != wanted {
            return Err(wrong(array.len()));
        }
        to.iter_mut().zip(array).for_each(|(to, number)| *to = *number);
        Ok(())
    } else if let Ok(tuple) = value.cast::<PyTuple>() {
        if tuple.len() != wanted {
            return Err(wrong(tuple.len()));
        }
        to.iter_mut().zip(tuple.iter_borrowed()).try_for_each(|(to, item)| put(to, &item))
    } else if let Ok(list) = value.cast::<PyList>() {
        if list.len() != wanted {
            return Err(wrong(list.len()));
        }
        to.iter_mut().zip(list.iter()).try_for_each(|(to, item)| put(to, &item))
    } else {
        let numbers: Vec<f64> = value.extract().map_err(|_| {
            let kind = value.get_type();
            PyTypeError::new_err(format!("{what} gives {kind} instead of a sequence of {wanted} numbers"))
        })?;
        if numbers.len() != wanted {
            return Err(wrong(numbers.len()));
        }
        to.copy_from_slice(&numbers);
        Ok(())
    }
}

/// Replaces `to` by the numbers that `what` returned, plain or in rows alike; returns the number of rows, 0 of plain
/// ones.
pub fn flat(value: &Bound<'_, PyAny>, what: &str, to: &mut Vec<f64>) -> PyResult<usize> {
    to.clear();
    let value = if value.hasattr("tolist")? { value.call_method0("tolist")? } else { value.clone() };
    let (mut rows, mut width) = (0, None);
    for row in value.try_iter()? {
        let row = row?;
        let numbers: Vec<f64> = match row.extract() {
            Ok(number) => vec![number],
            Err(_) if row.is_instance_of::<PyString>() => return Err(wrong_kind(what, &row, "numbers")),
            Err(_) => row.extract().map_err(|_| wrong_kind(what, &row, "numbers, or rows of them"))?,
        };
        rows += usize::from(row.extract::<f64>().is_err());
        if *width.get_or_insert(numbers.len()) != numbers.len() {
            return Err(PyValueError::new_err(format!("{what} gives rows that are not alike")));
        }
        to.extend(numbers);
    }
    Ok(rows)
}

/// An attribute, if the object has it.
pub fn attribute<'py>(object: &Bound<'py, PyAny>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
    object.getattr_opt(name).map(|found| found.filter(|value| !value.is_none()))
}

/// A method, bound to the object; `whose` says whose it is.
pub fn method(object: &Bound<'_, PyAny>, name: &str, whose: &str) -> PyResult<Py<PyAny>> {
    let found = attribute(object, name)?.filter(|method| method.is_callable());
    let missing = || PyTypeError::new_err(format!("{whose}, {}, has no method `{name}`", object.get_type()));
    found.map(Bound::unbind).ok_or_else(missing)
}

/// A copy as `copy.deepcopy` makes it, if it can.
pub fn copied(object: &Py<PyAny>) -> Option<Py<PyAny>> {
    Python::attach(|py| py.import("copy")?.call_method1("deepcopy", (object,)).map(Bound::unbind)).ok()
}
