//! The variables of an exported FMU. A value reference is the place in their list, on both sides of the boundary.

use super::{Fmi, build_side};
use crate::model_parts::{ModelSize, PartVariable};
use rimbench_cases::cases::Case;
use rimbench_cases::parameter::{self, Parameters, Value};
use rimbench_core::cosim::{OutputRates, Side, Subsystem, WorkMeter};
use rimbench_core::error::Result;

/// What a variable stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The independent variable.
    Time,
    /// An input by its place.
    Input(usize),
    /// An output by its place.
    Output(usize),
    /// The rate of an output with inputs held, by its place.
    Rate(usize),
    /// A parameter of the case by its place.
    Parameter(usize),
    /// Longest step of its own.
    LongestStep,
    /// Time for which the model stands still at first.
    Wait,
    /// Whether steps are noted so that a state can be serialised.
    Serialisable,
    /// Step for which the interface model and the observables are given.
    ModelStep,
    /// A part of the interface model.
    Model(&'static PartVariable),
    /// A further quantity by its place.
    Observable(usize),
    /// Work received through the interface.
    InterfaceWork,
    /// Work sent through the interface.
    WorkSent,
}

/// One variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// What it stands for.
    pub kind: Kind,
    /// Its unit; empty where it has none.
    pub unit: String,
    /// One line.
    pub about: String,
    /// Extents of an array; empty: one value.
    pub dimensions: Vec<usize>,
}

impl Variable {
    /// Returns how many values it has.
    pub fn size(&self) -> usize {
        self.dimensions.iter().product()
    }
}

/// What one side of a case shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Variables {
    /// All variables; the place of one is its value reference.
    pub list: Vec<Variable>,
    /// Numbers of inputs and outputs.
    pub inputs: usize,
    /// Likewise.
    pub outputs: usize,
    /// Whether outputs depend on inputs at once.
    pub feedthrough: bool,
    /// Whether the rates of outputs are known.
    pub rates: bool,
    /// Whether it can be copied, and so its state kept.
    pub copies: bool,
}

impl Variables {
    /// Lists those of one side of a case with these parameters.
    ///
    /// # Errors
    /// Those of building the case.
    pub fn of(case: &Case, side: Side, parameters: &Parameters, fmi: Fmi) -> Result<Self> {
        let mut subsystem = build_side(case, side, parameters)?;
        Ok(Self::of_subsystem(&mut *subsystem, parameters, fmi))
    }

    /// Lists those of a subsystem that has been built with these parameters. FMI 2.0 has no arrays, and so no interface
    /// model, and needs no variable for the time.
    pub fn of_subsystem(subsystem: &mut dyn Subsystem, parameters: &Parameters, fmi: Fmi) -> Self {
        let ports = subsystem.ports().clone();
        let (inputs, outputs) = (ports.inputs.len(), ports.outputs.len());
        let mut rates = OutputRates::zeros(outputs, inputs);
        let rates = matches!(subsystem.capabilities().output_rates(0.0, &vec![0.0; inputs], &mut rates), Ok(true));
        let mut list = Vec::new();
        let mut put = |name: &str, kind: Kind, unit: &str, about: &str, dimensions: &[usize]| {
            let (name, unit, about) = (name.to_owned(), unit.to_owned(), about.to_owned());
            list.push(Variable { name, kind, unit, about, dimensions: dimensions.to_vec() });
        };
        put("time", Kind::Time, "s", "Simulated time", &[]);
        for (k, port) in ports.inputs.iter().enumerate() {
            put(&port.name, Kind::Input(k), unit_of(&port.name), "Held over a communication step", &[]);
        }
        for (k, port) in ports.outputs.iter().enumerate() {
            put(&port.name, Kind::Output(k), unit_of(&port.name), "Of the present state", &[]);
        }
        for (k, port) in ports.outputs.iter().enumerate().filter(|_| rates) {
            let unit = format!("{}/s", unit_of(&port.name));
            put(&format!("der({})", port.name), Kind::Rate(k), &unit, "Rate of the output with its inputs held", &[]);
        }
        for (k, (parameter, _)) in parameters.iter().enumerate() {
            let unit = said(&parameter.unit);
            let about = format!("{}; valid: {}", parameter.about, parameter.range);
            put(&parameter.name, Kind::Parameter(k), unit, &about, &[]);
        }
        let about = "Longest step that the model takes by itself; 0: as long as the communication step";
        put("longest_step_s", Kind::LongestStep, "s", about, &[]);
        let about =
            "Time for which the model stands still at first: (1 - phase) H gives a master of fixed steps H that phase";
        put("wait_s", Kind::Wait, "s", about, &[]);
        let about =
            "Keep a note of every communication step, 8 (3 + inputs) bytes each, from which a state can be serialised";
        put("serialisable", Kind::Serialisable, "", about, &[]);
        put(
            "rim.step",
            Kind::ModelStep,
            "s",
            "Step of the mechanics for which local quantities and rim.* are given",
            &[],
        );
        if let Some(model) = subsystem.capabilities().empty_interface_model() {
            let size = ModelSize::of(&model);
            for part in size.parts() {
                let about = format!("Interface model: {}", part.about);
                put(part.name, Kind::Model(part), part.unit, &about, &part.dimensions(size));
            }
        }
        if subsystem.capabilities().interface_work().is_some() {
            let about = "Work received through the interface since the start, as the model's own steps count it";
            put("interface_work_j", Kind::InterfaceWork, "J", about, &[]);
        }
        if WorkMeter::new(&ports).sent().is_some() {
            let about = "Work sent through the interface since the start, as the model's own steps count it";
            put("work_sent_j", Kind::WorkSent, "J", about, &[]);
        }
        for (k, name) in subsystem.capabilities().observables().iter().enumerate() {
            put(name, Kind::Observable(k), unit_of(name), "A further quantity of the model", &[]);
        }
        let copies = subsystem.try_clone().is_ok();
        if fmi == Fmi::Two {
            list.retain(|variable| !matches!(variable.kind, Kind::Time | Kind::ModelStep | Kind::Model(_)));
        }
        // A name of the model's own stands where a parameter has it as well.
        let mut seen = std::collections::BTreeSet::new();
        list.retain(|variable| seen.insert(variable.name.clone()));
        Variables { list, inputs, outputs, feedthrough: ports.direct_feedthrough, rates, copies }
    }

    /// Finds the variable of a value reference.
    pub fn get(&self, reference: u32) -> Option<&Variable> {
        self.list.get(usize::try_from(reference).ok()?)
    }

    /// Tells whether it has an interface model.
    pub fn has_model(&self) -> bool {
        self.list.iter().any(|variable| matches!(variable.kind, Kind::Model(_)))
    }
}

/// Whether a parameter is a name rather than a number.
pub(crate) fn is_choice(value: &Value) -> bool {
    matches!(value, Value::Choice(_))
}

/// Unit that a name in data ends in; empty where it says none.
fn unit_of(name: &str) -> &'static str {
    said(parameter::unit_of(name))
}

/// A unit as FMI has it: nothing for a pure number.
fn said(unit: &str) -> &str {
    if unit == "-" { "" } else { unit }
}
