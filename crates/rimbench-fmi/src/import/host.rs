//! What drives one FMU, wherever it runs: numbers in, numbers out.

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
    /// Time and inputs in; rates, feedthrough and rate gain out. Where they are probed, the longest step that may be taken for it stands
    /// before the inputs, and their relative error behind the answer.
    Rates,
    /// Step of the mechanics in, and 1 if the kinks that lie ahead are wanted; the parts of the interface model out, one after the other.
    Model,
    /// Step of the mechanics in; observed quantities out.
    Observe,
    /// Nothing in; the work received out.
    Work,
    /// Nothing in; the number of a copy out.
    Copy,
    /// Nothing in, nothing out: this copy is done with.
    Drop,
}

impl Ask {
    const ALL: [Ask; 8] =
        [Ask::Outputs, Ask::Step, Ask::Rates, Ask::Model, Ask::Observe, Ask::Work, Ask::Copy, Ask::Drop];

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

/// A value that is set before a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) enum Start {
    /// Reference and number.
    Number(u32, f64),
    /// Reference and whole number.
    Integer(u32, i32),
    /// Reference and truth.
    Boolean(u32, bool),
    /// Reference and text.
    Text(u32, String),
}

/// A number that crosses the boundary: `SI = factor × value + offset`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Scaled {
    pub(super) reference: u32,
    pub(super) factor: f64,
    pub(super) offset: f64,
}

impl Scaled {
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

/// Where the parts of the interface model are, and how large they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct ModelVariables {
    /// The variable that takes the step of the mechanics.
    pub(super) step: u32,
    /// Numbers, each with its count, in the order in which they are given.
    pub(super) numbers: Vec<(u32, usize)>,
    /// Truths likewise, after them.
    pub(super) truths: Vec<(u32, usize)>,
    /// Numbers of contacts with friction, after those.
    pub(super) friction: Vec<(u32, usize)>,
    /// Whole numbers likewise.
    pub(super) states: Vec<(u32, usize)>,
    /// How many kinks lie ahead, when, and by how much accelerations jump there: after everything else, where they are asked for.
    pub(super) kinks: Option<(u32, [(u32, usize); 2])>,
}

/// How an FMU that does not give the rates of its outputs is probed for them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Probe {
    /// The longer of the two steps that are compared, s.
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
    pub(super) starts: Vec<Start>,
    pub(super) inputs: Vec<Scaled>,
    pub(super) outputs: Vec<Scaled>,
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
    pub(super) observed: Vec<Scaled>,
    pub(super) work: Option<Scaled>,
}
