//! A coupling scheme that is an object of Python.

use crate::errors::{self, RimbenchError};
use crate::model;
use crate::numbers::{copied, count, flat, given, method, wrong_kind};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rimbench::cosim::{Ports, Sample, Side};
use rimbench::error::Error;
use rimbench::name::Name;
use rimbench::schemes::{AnswerForm, Asked, Family, Outside, OutsideScheme, Requirement, SchemeEntry};
use std::sync::Arc;

/// What one side sends at a communication point.
#[pyclass(frozen, name = "Sample", module = "rimbench")]
pub struct PySample {
    /// When it was taken, s.
    #[pyo3(get)]
    time: f64,
    /// The outputs of the sending side, a tuple.
    #[pyo3(get)]
    y: Py<PyTuple>,
    /// The reduced interface model of the mechanics, a dictionary, if the scheme asked for it and this is the sample of
    /// the mechanics.
    #[pyo3(get)]
    model: Option<Py<PyDict>>,
    /// Index of the macro step that starts here, from 0.
    #[pyo3(get)]
    index: usize,
    /// Its start, s.
    #[pyo3(get)]
    start: f64,
    /// Its length, s.
    #[pyo3(get)]
    length: f64,
}

/// One micro step inside a macro step, or, to be answered at once, a macro step with the number of its micro steps.
#[pyclass(frozen, get_all, name = "MicroStep", module = "rimbench")]
pub struct PyMicroStep {
    /// Its number, from 0.
    index: usize,
    /// Number of micro steps in the macro step.
    count: usize,
    /// Its length, s.
    length: f64,
    /// Absolute time at its start, s.
    start: f64,
    /// Time since the communication point at its start, s.
    since_exchange: f64,
    /// Absolute time at its middle, s.
    middle: f64,
}

/// How a side is called.
fn name(side: Side) -> &'static str {
    match side {
        Side::Mechanics => "mechanics",
        Side::Actuator => "actuator",
    }
}

/// An object with `receive(side, sample)` and one of the methods of [`AnswerForm::METHODS`].
struct SchemeObject {
    object: Py<PyAny>,
    receive: Py<PyAny>,
    answer: Py<PyAny>,
    form: AnswerForm,
}

impl SchemeObject {
    fn new(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        let mut forms = AnswerForm::METHODS.into_iter();
        let offered = forms.find(|(name, _)| object.hasattr(*name).unwrap_or(false));
        let (answer, form) = offered.unwrap_or(("input", AnswerForm::Input));
        let method = |name| method(object, name, "the scheme");
        let (receive, answer) = (method("receive")?, method(answer)?);
        Ok(SchemeObject { object: object.clone().unbind(), receive, answer, form })
    }
}

impl Outside for SchemeObject {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), String> {
        let call = |py: Python<'_>| -> PyResult<()> {
            let sample = PySample {
                time: sample.time,
                y: PyTuple::new(py, sample.y)?.unbind(),
                model: sample.model.map(|model| model::written(py, model).map(Bound::unbind)).transpose()?,
                index: sample.step.index,
                start: sample.step.start,
                length: sample.step.length,
            };
            self.receive.bind(py).call1((name(from), sample)).map(drop)
        };
        Python::attach(|py| call(py).map_err(|error| errors::keep(py, error)))
    }

    fn answer(&mut self, to: Side, asked: Asked<'_>, told: &mut Vec<f64>) -> Result<usize, String> {
        let call = |py: Python<'_>, told: &mut Vec<f64>| -> PyResult<usize> {
            let answer = self.answer.bind(py);
            let step = |index, count, length, start, since_exchange| {
                let middle = start + 0.5 * length;
                PyMicroStep { index, count, length, start, since_exchange, middle }
            };
            let value = match asked {
                Asked::MicroStep(at, own) => {
                    let step = step(at.index, at.count, at.length, at.start, at.since_exchange);
                    answer.call1((name(to), step, PyTuple::new(py, own)?))?
                }
                Asked::MacroStep(of, count) => {
                    answer.call1((name(to), step(of.index, count, of.length, of.start, 0.0)))?
                }
            };
            flat(&value, AnswerForm::METHODS[self.form as usize].0, told)
        };
        Python::attach(|py| call(py, told).map_err(|error| errors::keep(py, error)))
    }

    fn try_clone(&self) -> Option<Box<dyn Outside>> {
        let object = copied(&self.object)?;
        let copy = Python::attach(|py| SchemeObject::new(object.bind(py))).ok()?;
        Some(Box::new(copy))
    }
}

/// What `rimbench.Scheme` is made of: what makes the scheme, called for each run with the names of what each side puts
/// out, and the hash of its code or why there is none.
#[pyclass(frozen, subclass, name = "Scheme", module = "rimbench._native")]
pub struct PyScheme {
    pub entry: SchemeEntry,
    /// Why there is no hash of its code, if there is none.
    no_code: String,
}

impl PyScheme {
    /// The scheme as one whose results are kept: its code is a part of what determines a run.
    pub fn to_be_kept(&self) -> rimbench::error::Result<SchemeEntry> {
        if self.entry.digest.is_some() {
            return Ok(self.entry.clone());
        }
        Err(Error::Incompatible(format!(
            "scheme {}: results are kept, and nothing tells when its code changes: {}; valid: a class in a file",
            self.entry.name, self.no_code
        )))
    }
}

#[pymethods]
impl PyScheme {
    #[new]
    #[pyo3(signature = (name, make, code, *, order=None, samples=None, interface_model=None))]
    fn new(
        name: &Bound<'_, PyAny>,
        make: &Bound<'_, PyAny>,
        code: (Option<String>, String),
        order: Option<&Bound<'_, PyAny>>,
        samples: Option<&Bound<'_, PyAny>>,
        interface_model: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let name: String = given("name", name, "a name, in kebab-case")?;
        if !make.is_callable() {
            return Err(wrong_kind("make", make, "what makes the scheme, called with the names of outputs"));
        }
        let order: u32 = order.map_or(Ok(1), |order| given("order", order, "a whole number from 0"))?;
        let samples: usize = samples.map_or(Ok(1), |samples| count("samples", samples))?;
        let truth = |value| given("interface_model", value, "True or False");
        let interface_model: bool = interface_model.map_or(Ok(false), truth)?;
        let make = Arc::new(make.clone().unbind());
        let entry = SchemeEntry::new(name, "A scheme written in Python", move |construction| {
            let names = |ports: &Ports| ports.outputs.iter().map(|port| port.name.to_string()).collect::<Vec<_>>();
            let built = |py: Python<'_>| -> PyResult<SchemeObject> {
                let outputs = PyDict::new(py);
                outputs.set_item("mechanics", PyTuple::new(py, names(construction.ports.mechanics))?)?;
                outputs.set_item("actuator", PyTuple::new(py, names(construction.ports.actuator))?)?;
                SchemeObject::new(&make.bind(py).call1((outputs,))?)
            };
            let who = Python::attach(|py| built(py).map_err(|error| errors::keep(py, error)));
            let form = who.as_ref().map_or(AnswerForm::Input, |object| object.form);
            let who = who.map(|object| Box::new(object) as Box<dyn Outside>);
            Ok(Box::new(OutsideScheme::new(who, form, construction.ports)))
        });
        let family = if interface_model { Family::Model } else { Family::Signal };
        let needs =
            if interface_model { vec![Requirement::InterfaceModel, Requirement::NoFriction] } else { Vec::new() };
        let (digest, no_code) = code;
        let digest = digest.map(Name::from);
        let entry = SchemeEntry { order, samples, family, needs, waits: true, digest, ..entry };
        // A name that cannot be is found here and not in every run.
        crate::everything()
            .clone()
            .add_scheme(entry.clone())
            .map_err(|error| RimbenchError::new_err(error.to_string()))?;
        Ok(PyScheme { entry, no_code })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.entry.name
    }

    fn __repr__(&self) -> String {
        format!("rimbench.Scheme({:?})", self.entry.name)
    }
}
