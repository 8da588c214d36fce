//! The reduced interface model as a dictionary, in both directions.

use crate::numbers::{attribute, given, number, wrong_kind};
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLikeDyn, PyArrayMethods};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rimbench::cosim::OutputRates;
use rimbench::interface_model::{ReducedInterfaceModel, TOUCHING};

/// What a model has before it is filled: an empty one, from the attributes `contacts`, `stabilisation` and
/// `restitution`, or of rows of an engine, at most `engine_rows`.
pub fn empty(object: &Bound<'_, PyAny>, interface: usize) -> PyResult<ReducedInterfaceModel> {
    let share = |name: &str| attribute(object, name)?.map_or(Ok(0.0), |value| number(name, &value));
    let contacts = "a whole number from 0";
    let contacts: usize = attribute(object, "contacts")?.map_or(Ok(0), |value| given("contacts", &value, contacts))?;
    let (stabilisation, restitution) = (share("stabilisation")?, share("restitution")?);
    for (name, value) in [("stabilisation", stabilisation), ("restitution", restitution)] {
        if !(0.0..=1.0).contains(&value) {
            return Err(PyValueError::new_err(format!("{name} = {value} is not valid; valid: a number in [0, 1]")));
        }
    }
    let rows = attribute(object, "engine_rows")?.map(|value| given("engine_rows", &value, "a whole number from 1"));
    let mut model = match rows.transpose()? {
        Some(rows) => ReducedInterfaceModel::zeros_with_targets(rows, interface),
        None => ReducedInterfaceModel::zeros(contacts, interface),
    };
    (model.stabilisation, model.restitution, model.inertia_varies) = (stabilisation, restitution, true);
    Ok(model)
}

/// Copies the numbers of `part`, of which errors say that it is `name` of what `whose` gives.
fn copy(whose: &str, name: &str, part: &Bound<'_, PyAny>, to: &mut [f64]) -> PyResult<()> {
    let array: Result<PyArrayLikeDyn<'_, f64, AllowTypeChange>, _> = part.extract();
    let array = array.map_err(|_| wrong_kind(&format!("{whose}: `{name}`"), part, "an array of numbers"))?;
    let array = array.as_array();
    if array.len() != to.len() {
        let message = format!("{whose}: `{name}` has {} numbers instead of {}", array.len(), to.len());
        return Err(PyValueError::new_err(message));
    }
    match array.as_slice() {
        Some(numbers) => to.copy_from_slice(numbers),
        None => to.iter_mut().zip(array.iter()).for_each(|(to, number)| *to = *number),
    }
    Ok(())
}

/// Fills a model from what `interface_model` returned; its size is known, but for rows of an engine, at most `most`.
pub fn read(value: &Bound<'_, PyAny>, h: f64, most: usize, model: &mut ReducedInterfaceModel) -> PyResult<()> {
    let dict = value.cast::<PyDict>().map_err(|_| wrong_kind("interface_model", value, "a dictionary"))?;
    let part = |name: &str| {
        let found = dict.get_item(name)?;
        found.ok_or_else(|| PyKeyError::new_err(format!("interface_model gives no `{name}`")))
    };
    let copy = |name: &str, to: &mut [f64]| copy("interface_model", name, &part(name)?, to);
    if model.has_targets {
        let rows = part("compliance")?.len()?;
        if rows > most {
            return Err(PyValueError::new_err(format!(
                "the engine has {rows} rows at once, and there is room for {most}; valid: engine_rows={rows} or more"
            )));
        }
        model.set_contacts(rows);
    }
    copy("H", &mut model.h)?;
    copy("a", &mut model.a)?;
    copy("w", &mut model.w)?;
    copy("position", &mut model.position)?;
    if model.contacts() > 0 {
        copy("gap", &mut model.gap)?;
    }
    for (at_bound, gap) in model.at_bound.iter_mut().zip(&model.gap) {
        *at_bound = *gap <= TOUCHING;
    }
    if let Some(closed) = dict.get_item("closed")? {
        let items = closed
            .try_iter()
            .map_err(|_| wrong_kind("`closed` of interface_model", &closed, "a sequence of truths"))?;
        let closed: Vec<bool> = items.map(|item| item?.is_truthy()).collect::<PyResult<_>>()?;
        if closed.len() != model.contacts() {
            let (found, wanted) = (closed.len(), model.contacts());
            let message = format!("interface_model: `closed` has {found} entries instead of {wanted}");
            return Err(PyValueError::new_err(message));
        }
        model.at_bound.copy_from_slice(&closed);
    }
    model.mechanics_step = h;
    if model.has_targets {
        let mut numbers = [(); 4].map(|()| vec![0.0; model.contacts()]);
        for (name, to) in ["compliance", "damping", "stiffness"].iter().zip(&mut numbers) {
            copy(name, to)?;
        }
        numbers[3].iter_mut().enumerate().for_each(|(row, opposite)| *opposite = row as f64);
        if dict.contains("opposite")? {
            copy("opposite", &mut numbers[3])?;
        }
        let steps: Option<usize> =
            dict.get_item("steps")?.map(|steps| given("steps", &steps, "a whole number from 1")).transpose()?;
        let symmetric = dict.get_item("symmetric")?.map_or(Ok(true), |said| said.is_truthy())?;
        (model.own_steps, model.unsymmetric) = (steps.unwrap_or(1).max(1), !symmetric);
        model.mechanics_step = h / model.own_steps as f64;
        let taken = model.take_targets(numbers.each_ref().map(|numbers| &numbers[..]));
        taken.map_err(|what| PyValueError::new_err(format!("interface_model: {what}")))?;
    }
    model.check().map_err(|what| PyValueError::new_err(format!("interface_model: {what}")))
}

/// The same dictionary for a scheme.
pub fn written<'py>(py: Python<'py>, model: &ReducedInterfaceModel) -> PyResult<Bound<'py, PyDict>> {
    let rows = model.interface_start() + model.interface();
    let array = |numbers: &[f64]| PyArray1::from_slice(py, numbers);
    let h = PyArray2::zeros(py, [rows, rows], false);
    {
        let mut h = h.try_readwrite()?;
        let mut entries = h.as_array_mut();
        for row in 0..rows {
            for column in 0..rows {
                entries[[row, column]] = model.entry(row, column);
            }
        }
    }
    let dict = PyDict::new(py);
    dict.set_item("H", h)?;
    dict.set_item("a", array(&model.a))?;
    dict.set_item("w", array(&model.w))?;
    dict.set_item("gap", array(&model.gap))?;
    dict.set_item("position", array(&model.position))?;
    dict.set_item("closed", &model.at_bound)?;
    dict.set_item("stabilisation", model.stabilisation)?;
    dict.set_item("restitution", model.restitution)?;
    dict.set_item("mechanics_step", model.mechanics_step)?;
    Ok(dict)
}

/// Fills directional derivatives from what `output_rates` returned: a dictionary of `rate`, `feedthrough` and, if it is
/// not 0, `rate_gain`.
pub fn read_rates(value: &Bound<'_, PyAny>, into: &mut OutputRates) -> PyResult<()> {
    let dict = value.cast::<PyDict>().map_err(|_| wrong_kind("output_rates", value, "a dictionary"))?;
    let parts = [("rate", &mut into.rate), ("feedthrough", &mut into.feedthrough), ("rate_gain", &mut into.rate_gain)];
    for (name, to) in parts {
        match dict.get_item(name)? {
            Some(part) => copy("output_rates", name, &part, to)?,
            None if name == "rate_gain" => to.fill(0.0),
            None => return Err(PyKeyError::new_err(format!("output_rates gives no `{name}`"))),
        }
    }
    Ok(())
}
