//! A subsystem that is an object of Python.

use crate::errors::failure;
use crate::model;
use crate::numbers::{attribute, copied, fill, given, method, number};
use numpy::PyArray1;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rimbench::cases::{JumpWatch, check_step_of_model, model_against_outputs};
use rimbench::cosim::{Capabilities, OutputRates, Ports, Subsystem, SubsystemCounters, subsystem_methods};
use rimbench::error::{Cause, Failure};
use rimbench::interface_model::ReducedInterfaceModel;
use rimbench::name::Name;
use std::sync::{Arc, OnceLock};

/// An object with `outputs(u)` and `step(t, u, h)`.
///
/// `step` may return the outputs of the state that it has come to: they are used until the next step, and the step
/// costs one callback.
pub struct PySubsystem {
    object: Py<PyAny>,
    outputs: Py<PyAny>,
    step: Py<PyAny>,
    ports: Ports,
    /// Names, and the method that gives the values.
    observables: Vec<Name>,
    observe: Option<Py<PyAny>>,
    /// Work received through the interface, J.
    work: Option<Py<PyAny>>,
    /// How the outputs move.
    rates: Option<Py<PyAny>>,
    /// An empty interface model, and the method that fills it.
    model: Option<(Arc<ReducedInterfaceModel>, Py<PyAny>)>,
    /// Why it has none, where it says so; and the shortest step in which it is one, s.
    without_model: Option<String>,
    model_from_s: f64,
    /// Its last input, and that as Python has it: a step begins with the input that outputs were asked for after the last.
    u: Vec<f64>,
    u_of_python: Option<Py<PyTuple>>,
    /// Whether it wants arrays instead.
    takes_arrays: bool,
    /// Outputs that `step` has returned, if it has.
    known: Vec<f64>,
    is_known: bool,
    /// Outputs of the present state that it has put out, if it has.
    told: Vec<f64>,
    is_told: bool,
    /// Time since outputs were put out last, s.
    since: f64,
    jumps: JumpWatch,
    /// What `observe` raised, which cannot fail itself.
    failed: Option<Failure>,
    counters: SubsystemCounters,
    doubted: Arc<Doubted>,
}

/// What is found of a side when its case is made: why there are no copies of it, why its model is none, and from what
/// it says that it is made.
#[derive(Default)]
pub struct Doubted {
    pub copies: OnceLock<String>,
    pub model: OnceLock<String>,
    pub made_from: OnceLock<String>,
    /// Whether that is over: it is tried in steps that no run takes.
    pub tried: OnceLock<()>,
}

impl PySubsystem {
    /// Takes an object that stands for a side with these ports; `whose` says which in errors.
    ///
    /// # Errors
    /// Methods that are missing, attributes that are no numbers.
    pub fn new(object: &Bound<'_, PyAny>, ports: &Ports, whose: &str, doubted: Arc<Doubted>) -> PyResult<Self> {
        Self::with_model(object, ports, whose, doubted, None)
    }

    /// The same of a copy, whose empty model is that `of_original`.
    fn with_model(
        object: &Bound<'_, PyAny>,
        ports: &Ports,
        whose: &str,
        doubted: Arc<Doubted>,
        of_original: Option<Arc<ReducedInterfaceModel>>,
    ) -> PyResult<Self> {
        let feedthrough = attribute(object, "direct_feedthrough")?;
        let direct_feedthrough = feedthrough.map_or(Ok(ports.direct_feedthrough), |value| value.is_truthy())?;
        let names = attribute(object, "observables")?;
        let names: Vec<String> =
            names.map_or(Ok(Vec::new()), |names| given("observables", &names, "a sequence of names"))?;
        let observe = if names.is_empty() { None } else { Some(method(object, "observe", whose)?) };
        let work = match attribute(object, "interface_work")? {
            Some(_) => Some(method(object, "interface_work", whose)?),
            None => None,
        };
        let rates = match attribute(object, "output_rates")? {
            Some(_) => Some(method(object, "output_rates", whose)?),
            None => None,
        };
        let model = match attribute(object, "interface_model")? {
            Some(_) => {
                let filled = method(object, "interface_model", whose)?;
                let forces = ports.inputs.len().min(ports.outputs.len());
                let empty = match of_original {
                    Some(empty) => empty,
                    None => Arc::new(model::empty(object, forces)?),
                };
                Some((empty, filled))
            }
            None => None,
        };
        let without_model = attribute(object, "no_interface_model")?;
        let without_model = without_model.map(|why| given("no_interface_model", &why, "a text")).transpose()?;
        let model_from_s = attribute(object, "model_from_s")?.map_or(Ok(0.0), |step| number("model_from_s", &step))?;
        if attribute(object, "made_from")?.is_some() && doubted.made_from.get().is_none() {
            let digest = object.py().import("rimbench")?.call_method1("_made_from", (object,))?;
            let _ = doubted.made_from.set(given("made_from", &digest, "a text, or paths of files")?);
        }
        Ok(PySubsystem {
            outputs: method(object, "outputs", whose)?,
            step: method(object, "step", whose)?,
            object: object.clone().unbind(),
            u: Vec::with_capacity(ports.inputs.len()),
            u_of_python: None,
            takes_arrays: attribute(object, "takes_arrays")?.map_or(Ok(false), |value| value.is_truthy())?,
            known: vec![0.0; ports.outputs.len()],
            is_known: false,
            told: vec![0.0; ports.outputs.len()],
            is_told: false,
            since: 0.0,
            jumps: JumpWatch::of(ports),
            ports: Ports { direct_feedthrough, ..ports.clone() },
            observables: names.into_iter().map(Name::from).collect(),
            observe,
            work,
            rates,
            model,
            without_model,
            model_from_s,
            failed: None,
            counters: SubsystemCounters::default(),
            doubted,
        })
    }

    /// Calls back, and keeps what is raised.
    fn call(&mut self, back: impl FnOnce(&mut Self, Python<'_>) -> PyResult<()>) -> Result<(), Failure> {
        if let Some(failure) = self.failed.take() {
            return Err(failure);
        }
        Python::attach(|py| back(self, py).map_err(|error| failure(py, error)))
    }

    /// The input as Python has it, made anew if a bit of it is another one.
    fn input<'py>(&mut self, py: Python<'py>, u: &[f64]) -> PyResult<Bound<'py, PyAny>> {
        if self.takes_arrays {
            return Ok(PyArray1::from_slice(py, u).into_any());
        }
        let is_same = u.len() == self.u.len() && u.iter().zip(&self.u).all(|(one, own)| one.to_bits() == own.to_bits());
        match &self.u_of_python {
            Some(tuple) if is_same => Ok(tuple.bind(py).clone().into_any()),
            _ => {
                self.u.clear();
                self.u.extend_from_slice(u);
                let tuple = PyTuple::new(py, u)?;
                self.u_of_python = Some(tuple.clone().unbind());
                Ok(tuple.into_any())
            }
        }
    }
}

impl Subsystem for PySubsystem {
    subsystem_methods!(ports capabilities counters);

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        if self.is_known {
            y.copy_from_slice(&self.known);
        } else {
            self.call(|this, py| {
                let u = this.input(py, u)?;
                let value = this.outputs.bind(py).call1((u,))?;
                fill(&value, "outputs", y)
            })?;
        }
        self.told.copy_from_slice(y);
        self.is_told = !self.ports.direct_feedthrough;
        match std::mem::take(&mut self.since) {
            0.0 => self.jumps.begin(y),
            since => self.jumps.see(since, y, &self.ports).map_err(Failure::reported)?,
        }
        Ok(())
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.counters.micro_steps += 1;
        self.since += h;
        (self.is_known, self.is_told) = (false, false);
        self.call(|this, py| {
            let u = this.input(py, u)?;
            let value = this.step.bind(py).call1((t, u, h))?;
            if value.is_none() {
                return Ok(());
            }
            if this.ports.direct_feedthrough {
                let message = "step gives outputs, which with direct feedthrough depend on the next input: return None";
                return Err(PyTypeError::new_err(message));
            }
            fill(&value, "step", &mut this.known)?;
            this.is_known = true;
            Ok(())
        })
    }

    fn try_clone(&self) -> Result<Box<dyn Subsystem>, Failure> {
        if let Some(why) = self.doubted.copies.get() {
            return Err(Cause::NotOffered { what: why.clone().into() }.into());
        }
        let object = copied(&self.object).ok_or(Cause::NotCopied)?;
        let doubted = self.doubted.clone();
        let empty = self.model.as_ref().map(|(empty, _)| empty.clone());
        let copy =
            Python::attach(|py| PySubsystem::with_model(object.bind(py), &self.ports, "the copy", doubted, empty));
        let copy = copy.map_err(|_| Cause::NotCopied)?;
        let (known, is_known, counters) = (self.known.clone(), self.is_known, self.counters);
        let (told, is_told) = (self.told.clone(), self.is_told);
        let (since, jumps) = (self.since, self.jumps.clone());
        Ok(Box::new(PySubsystem { known, is_known, told, is_told, since, jumps, counters, ..copy }))
    }
}

impl Capabilities for PySubsystem {
    fn empty_interface_model(&mut self) -> Option<ReducedInterfaceModel> {
        if self.doubted.model.get().is_some() {
            return None;
        }
        self.model.as_ref().map(|(empty, _)| empty.as_ref().clone())
    }

    fn interface_model(&mut self, h: f64, into: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        let without = self.without_model.as_ref().filter(|_| self.model.is_none());
        if let Some(words) = without.or(self.doubted.model.get()) {
            return Err(Cause::NotOffered { what: words.clone().into() }.into());
        }
        if self.model.is_none() {
            return Ok(false);
        }
        if self.doubted.tried.get().is_some() {
            check_step_of_model(h, self.model_from_s)?;
        }
        self.counters.eliminations += 1;
        self.call(|this, py| match &this.model {
            Some((empty, filled)) => model::read(&filled.bind(py).call1((h,))?, h, empty.contacts(), into),
            None => Ok(()),
        })?;
        if self.is_told {
            model_against_outputs(into, &self.told).map_err(Failure::reported)?;
        }
        Ok(true)
    }

    fn output_rates(&mut self, t: f64, u: &[f64], into: &mut OutputRates) -> Result<bool, Failure> {
        if self.rates.is_none() {
            return Ok(false);
        }
        self.call(|this, py| {
            let u = this.input(py, u)?;
            match &this.rates {
                Some(rates) => model::read_rates(&rates.bind(py).call1((t, u))?, into),
                None => Ok(()),
            }
        })?;
        Ok(true)
    }

    fn observables(&mut self) -> &[Name] {
        &self.observables
    }

    fn observe(&mut self, _h: f64, row: &mut [f64]) {
        row.fill(f64::NAN);
        let seen = self.call(|this, py| match &this.observe {
            Some(observe) => fill(&observe.bind(py).call0()?, "observe", row),
            None => Ok(()),
        });
        self.failed = seen.err();
    }

    fn interface_work(&mut self) -> Option<f64> {
        let work = self.work.as_ref()?;
        let worked = Python::attach(|py| {
            let counted = || number("the number that interface_work gives", &work.bind(py).call0()?);
            counted().map_err(|error| failure(py, error))
        });
        Some(worked.unwrap_or_else(|failure| {
            self.failed = Some(failure);
            f64::NAN
        }))
    }
}
