//! Numbers that a callback returns.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyList, PyTuple};

/// A number that a call gives: of one that has fewer digits than ours those that it has (`np.float32(5e-3)` is 0.005),
/// and of a truth none.
pub fn number(key: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let kind = value.get_type();
    let wrong = || PyTypeError::new_err(format!("{key} is {kind} and not a number"));
    if is_truth(value)? {
        return Err(wrong());
    }
    let number: f64 = value.extract().map_err(|_| wrong())?;
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
    // The two that are made fast; any other sequence, an array among them, takes a copy.
    if let Ok(tuple) = value.cast::<PyTuple>() {
        if tuple.len() != wanted {
            return Err(wrong(tuple.len()));
        }
        to.iter_mut().zip(tuple.iter_borrowed()).try_for_each(|(to, number)| number.extract().map(|x| *to = x))
    } else if let Ok(list) = value.cast::<PyList>() {
        if list.len() != wanted {
            return Err(wrong(list.len()));
        }
        to.iter_mut().zip(list.iter()).try_for_each(|(to, number)| number.extract().map(|x| *to = x))
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
