//! What drives one FMU, wherever it runs: numbers in, numbers out.

use crate::model_parts::{ModelSize, PartType};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What a host can be asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Ask {
    /// Inputs in; outputs out.
    Outputs = 1,
    /// Time, step, inputs in; the outputs that the state has come to out, with these inputs.
    Step,
    /// Time and inputs in; rates, feedthrough and rate gain out. Where they are probed, the longest step that may be
    /// taken for it stands before the inputs, and their relative error behind the answer.
    Rates,
    /// Step of the mechanics in; out come the parts of [`ModelSize::parts`], one after the other, or rows of an engine.
    Model,
    /// Step of the mechanics in; observed quantities out.
    Observe,
    /// Nothing in; the work received out.
    Work,
    /// Nothing in; the number of a copy out.
    Copy,
    /// Nothing in, nothing out: this copy is done with.
    Drop,
    /// Inputs in, nothing out: ends its initialisation with them.
    Begin,
    /// Nothing in; how often it has warned, and the bytes of what it said first out.
    Heard,
    /// Of an object of Python, nothing in; whether outputs follow inputs at once (−1: it does not say), whether it
    /// counts work, whether it has an interface model, says how its outputs move, and has rows of an engine, from which
    /// step (s) on its model is one, its contacts or most rows, and the bytes of what it observes out.
    Describe,
    /// Of a scheme: the side, 0 for the mechanics, the time, index, start and length of the macro step, the number of
    /// outputs and these, and with an interface model the mechanics' step and its parts in; nothing out.
    Receive,
    /// Of a scheme: the side and what is asked for in, as
    /// [`Asked`](rimbench_core::schemes::Asked) has it; the answer out.
    Answer,
}

impl Ask {
    const ALL: [Ask; 13] = [
        Ask::Outputs,
        Ask::Step,
        Ask::Rates,
        Ask::Model,
        Ask::Observe,
        Ask::Work,
        Ask::Copy,
        Ask::Drop,
        Ask::Begin,
        Ask::Heard,
        Ask::Describe,
        Ask::Receive,
        Ask::Answer,
    ];

    pub(super) fn of(byte: u8) -> Option<Ask> {
        Ask::ALL.into_iter().find(|ask| *ask as u8 == byte)
    }
}

/// Drives an FMU with any number of copies of its state, the first of which is 0.
pub(super) trait Host: Send {
    /// Asks copy `id`; what is answered replaces `output`.
    ///
    /// # Errors
    /// What the FMU says, or how its process ended.
    fn ask(&mut self, ask: Ask, id: u32, input: &[f64], output: &mut Vec<f64>) -> Result<(), String>;
}

/// Type of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Type {
    Float64,
    Float32,
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Boolean,
    Text,
    /// What is of no use here.
    Other,
}

impl Type {
    /// The type of a variable whose element has this name; an enumeration is a whole number.
    pub(super) fn of_element(name: &str, two: bool) -> Type {
        match name {
            "Real" | "Float64" => Type::Float64,
            "Float32" => Type::Float32,
            "Int8" => Type::Int8,
            "UInt8" => Type::UInt8,
            "Int16" => Type::Int16,
            "UInt16" => Type::UInt16,
            "Integer" | "Int32" => Type::Int32,
            "Enumeration" if two => Type::Int32,
            "UInt32" => Type::UInt32,
            "Int64" | "Enumeration" => Type::Int64,
            "UInt64" => Type::UInt64,
            "Boolean" => Type::Boolean,
            "String" => Type::Text,
            _ => Type::Other,
        }
    }

    /// How FMI 3.0 calls it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Type::Float64 => "Float64",
            Type::Float32 => "Float32",
            Type::Int8 => "Int8",
            Type::UInt8 => "UInt8",
            Type::Int16 => "Int16",
            Type::UInt16 => "UInt16",
            Type::Int32 => "Int32 (Integer, Enumeration)",
            Type::UInt32 => "UInt32",
            Type::Int64 => "Int64 (Enumeration)",
            Type::UInt64 => "UInt64",
            Type::Boolean => "Boolean",
            Type::Text => "String",
            Type::Other => "Clock, Binary or one that is not known",
        }
    }

    /// The least and the largest whole number of a type of whole numbers.
    pub(super) fn whole(self) -> Option<[i128; 2]> {
        let (bits, signed) = match self {
            Type::Int8 => (8, true),
            Type::UInt8 => (8, false),
            Type::Int16 => (16, true),
            Type::UInt16 => (16, false),
            Type::Int32 => (32, true),
            Type::UInt32 => (32, false),
            Type::Int64 => (64, true),
            Type::UInt64 => (64, false),
            _ => return None,
        };
        Some(if signed { [-(1 << (bits - 1)), (1 << (bits - 1)) - 1] } else { [0, (1 << bits) - 1] })
    }

    /// Whether its values are numbers that may have digits behind the point.
    pub(super) fn is_real(self) -> bool {
        matches!(self, Type::Float64 | Type::Float32)
    }
}

impl From<PartType> for Type {
    fn from(of_part: PartType) -> Type {
        match of_part {
            PartType::Number => Type::Float64,
            PartType::Truth => Type::Boolean,
            PartType::Whole => Type::Int32,
        }
    }
}

/// Values of a variable, one or those of an array.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Whole(Vec<i64>),
    Truths(Vec<bool>),
    Texts(Vec<String>),
}

impl Values {
    /// Checks numbers against what they may be.
    ///
    /// # Errors
    /// The first that is not valid, and what would be.
    pub(super) fn check(&self, limits: &Limits) -> Result<(), (f64, String)> {
        let check = |number: f64| limits.check(number).map_err(|valid| (number, valid));
        match self {
            Values::Numbers(list) => list.iter().copied().try_for_each(check),
            Values::Whole(list) => list.iter().map(|number| *number as f64).try_for_each(check),
            Values::Truths(_) | Values::Texts(_) => Ok(()),
        }
    }

    /// Puts one value of the same type in a place of an array.
    pub(super) fn put(&mut self, at: usize, one: Values) {
        match (self, one) {
            (Values::Numbers(all), Values::Numbers(one)) => all[at] = one[0],
            (Values::Whole(all), Values::Whole(one)) => all[at] = one[0],
            (Values::Truths(all), Values::Truths(one)) => all[at] = one[0],
            (Values::Texts(all), Values::Texts(mut one)) => all[at] = one.swap_remove(0),
            _ => {}
        }
    }
}

/// Values that are set before a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Start {
    /// The name of the variable, for messages.
    pub(super) variable: String,
    pub(super) reference: u32,
    pub(super) kind: Type,
    pub(super) values: Values,
    /// Whether it is an output, which begins with it whatever initialisation makes of it.
    pub(super) exact: bool,
}

/// What values of a variable may be, in its own unit.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Limits {
    pub(super) least: Option<f64>,
    pub(super) most: Option<f64>,
    /// Those of an enumeration; empty: any.
    pub(super) items: Vec<i64>,
}

/// By what share of a bound round-off may put a number beyond it.
const ROUNDED: f64 = 1e-9;

impl Limits {
    /// Whether there is nothing to check.
    pub(super) fn is_none(&self) -> bool {
        self.least.is_none() && self.most.is_none() && self.items.is_empty()
    }

    /// # Errors
    /// What would be valid.
    pub(super) fn check(&self, value: f64) -> Result<(), String> {
        match (self.least, self.most) {
            (Some(least), _) if value < least - ROUNDED * least.abs() => Err(format!("at least {least} (min)")),
            (_, Some(most)) if value > most + ROUNDED * most.abs() => Err(format!("at most {most} (max)")),
            _ if self.items.is_empty() || self.items.iter().any(|item| *item as f64 == value) => Ok(()),
            _ => {
                let items: Vec<String> = self.items.iter().map(i64::to_string).collect();
                Err(format!("an item of its enumeration, {}", items.join(", ")))
            }
        }
    }
}

/// A place in an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Element {
    pub(super) at: usize,
    /// How many there are.
    pub(super) of: usize,
}

/// A number that crosses the boundary: `SI = factor × value + offset`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Scaled {
    pub(super) reference: u32,
    pub(super) kind: Type,
    /// Which of an array it is; none: the only value of its variable.
    pub(super) element: Option<Element>,
    pub(super) factor: f64,
    pub(super) offset: f64,
}

impl Scaled {
    /// Whether it goes to the FMU by itself: a Float64 of one value.
    pub(super) fn is_single(&self) -> bool {
        self.element.is_none() && self.kind == Type::Float64
    }

    /// As others have it.
    pub(super) fn outwards(&self, value: f64) -> f64 {
        if self.is_plain() { value } else { self.factor * value + self.offset }
    }

    /// As the FMU has it.
    pub(super) fn inwards(&self, si: f64) -> f64 {
        if self.is_plain() { si } else { (si - self.offset) / self.factor }
    }

    fn is_plain(&self) -> bool {
        self.factor == 1.0 && self.offset == 0.0
    }
}

/// Where the parts of the interface model are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct ModelVariables {
    /// The variable that takes the step of the mechanics.
    pub(super) step: u32,
    pub(super) size: ModelSize,
    /// The variable of each of the parts that a model of this size has.
    pub(super) references: Vec<u32>,
}

/// How an FMU that does not give the rates of its outputs is probed for them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Probe {
    /// The longest step, s: the longer of the two that are compared, or beyond all steps, where answers are over the
    /// step that is asked for.
    pub(super) step: f64,
    /// By how much inputs are changed, of their magnitude, or of 1 in SI where that is less.
    pub(super) change: f64,
    /// Whether outputs follow inputs at once.
    pub(super) feedthrough: bool,
}

impl Probe {
    /// By how much an input is changed, in SI.
    pub(super) fn change_of(self, input: f64) -> f64 {
        self.change * input.abs().max(1.0)
    }
}

/// What is to be said of an FMU that is but half of what runs.
pub(super) const NEEDS_TOOL: &str = "it drives a tool that must be installed here (needsExecutionTool)";

/// Everything that driving an FMU needs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Plan {
    /// How errors call it.
    pub(super) file: PathBuf,
    pub(super) library: PathBuf,
    /// Libraries whose symbols it takes for granted.
    pub(super) needs: Vec<PathBuf>,
    pub(super) resources: PathBuf,
    pub(super) version_2: bool,
    pub(super) token: String,
    /// Which side it is: what its instance is called begins with that.
    pub(super) side: String,
    /// Whether it drives a tool that must be here.
    pub(super) needs_tool: bool,
    /// Whether its log is switched on, and shown as it comes.
    pub(super) log: bool,
    /// Whether what it changes of the process that it is in is set back after each call.
    pub(super) lodger: bool,
    /// What one of its unit of time is, s.
    pub(super) time_unit: f64,
    /// Its time when a run begins, in its unit of time.
    pub(super) begin: f64,
    /// When the run ends, s, where that is known.
    pub(super) stop: Option<f64>,
    pub(super) starts: Vec<Start>,
    pub(super) inputs: Vec<Scaled>,
    /// What inputs may be: which of them, and its name.
    pub(super) limits: Vec<(usize, String, Limits)>,
    pub(super) outputs: Vec<Scaled>,
    /// How many of the outputs are positions; velocities stand behind them.
    pub(super) positions: usize,
    /// Rates of the outputs, where all of them have one.
    pub(super) rates: Option<Vec<Scaled>>,
    pub(super) derivatives: bool,
    /// A mechanics of whose rates only the accelerations count.
    pub(super) smooth: bool,
    /// The longest step by which rates are probed, s, where they are not given.
    pub(super) probe: Option<Probe>,
    pub(super) keeps_state: bool,
    pub(super) model: Option<ModelVariables>,
    /// The variable that takes the step of the mechanics for what is observed, if there is one.
    pub(super) step: Option<u32>,
    /// Values in the FMU's own units.
    pub(super) observed: Vec<Scaled>,
    pub(super) observed_names: Vec<String>,
    pub(super) work: Option<Scaled>,
}
