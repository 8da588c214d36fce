//! One instance of an exported FMU, without the boundary.

use super::history::{History, Taken};
use crate::export::{
    Contents, Kind, PartType, PartVariable, RESOURCE, Variable, Variables, build_side, side_name, text,
};
use rimbench_cases::cases::Case;
use rimbench_cases::parameter::{Parameters, Value};
use rimbench_core::cosim::{MacroStep, MicroStep, OutputRates, Side, Subsystem, WorkMeter, division};
use rimbench_core::interface_model::ReducedInterfaceModel;
use rimbench_runs::catalogue::Catalogue;
use std::mem::MaybeUninit;
use std::path::Path;
use std::sync::Arc;

/// Why a call failed.
pub(super) type Refusal = String;

/// The model as it has been built, with what has been asked of it since it last moved.
struct Built {
    subsystem: Box<dyn Subsystem>,
    y: Vec<f64>,
    y_known: bool,
    rates: OutputRates,
    rates_known: bool,
    observed: Vec<f64>,
    observed_known: bool,
    model: Option<ReducedInterfaceModel>,
    model_known: bool,
    work: WorkMeter,
}

impl Built {
    fn new(mut subsystem: Box<dyn Subsystem>) -> Self {
        let (outputs, inputs) = (subsystem.ports().outputs.len(), subsystem.ports().inputs.len());
        let observed = subsystem.capabilities().observables().len();
        let model = subsystem.capabilities().empty_interface_model();
        Built {
            y: vec![0.0; outputs],
            y_known: false,
            rates: OutputRates::zeros(outputs, inputs),
            rates_known: false,
            observed: vec![0.0; observed],
            observed_known: false,
            model,
            model_known: false,
            work: WorkMeter::new(subsystem.ports()),
            subsystem,
        }
    }

    fn forget(&mut self) {
        (self.y_known, self.rates_known, self.observed_known, self.model_known) = (false, false, false, false);
    }

    fn try_clone(&self) -> Option<Built> {
        Some(Built { work: self.work.clone(), ..Built::new(self.subsystem.try_clone().ok()?) })
    }
}

/// Where an instance is between its calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Instantiated,
    Initialization,
    Stepping,
    Terminated,
}

impl Phase {
    const ALL: [Phase; 4] = [Phase::Instantiated, Phase::Initialization, Phase::Stepping, Phase::Terminated];

    /// Whether parameters are fixed.
    fn has_begun(self) -> bool {
        matches!(self, Phase::Stepping | Phase::Terminated)
    }
}

/// Everything that a state holds.
struct State {
    parameters: Parameters,
    longest: f64,
    /// Time for which the model stands still at first, s.
    wait: f64,
    model_step: f64,
    serialisable: bool,
    u: Vec<f64>,
    /// Time at which it was initialised, s.
    begin: f64,
    time: f64,
    phase: Phase,
    history: History,
    built: Option<Built>,
}

impl State {
    /// The model's own time at a time of the master.
    fn model_time(&self, t: f64) -> f64 {
        if self.wait == 0.0 { t } else { (t - self.wait).max(self.begin) }
    }

    /// From when on and how long the model moves in a communication step, in its own time; none while it waits. What is
    /// left of the step in which the wait ends is shorter; beyond rounding no step is of another length than the
    /// master's.
    fn motion(&self, t: f64, h: f64) -> Option<[f64; 2]> {
        let slack = 1e-9 * h + 8.0 * f64::EPSILON * t.abs().max(self.wait);
        let from = t - self.wait;
        if self.wait == 0.0 || from >= self.begin - slack {
            return Some([from, h]);
        }
        let length = from + h - self.begin;
        (length > slack).then_some([self.begin, length])
    }

    fn try_clone(&self) -> Option<State> {
        let built = match &self.built {
            Some(built) => Some(built.try_clone()?),
            None => None,
        };
        Some(State {
            parameters: self.parameters.clone(),
            u: self.u.clone(),
            history: self.history.clone(),
            built,
            ..*self
        })
    }
}

/// A state that a master keeps.
pub(super) struct Kept {
    state: State,
    /// Of the FMU that it is a state of.
    token: Arc<str>,
}

/// An instance.
pub(super) struct Instance {
    case: Arc<Case>,
    side: Side,
    contents: Contents,
    token: Arc<str>,
    variables: Variables,
    state: State,
}

/// First bytes of a serialised state: format and its version.
const MARK: &[u8; 8] = b"rimfmu03";

impl Instance {
    /// Reads what it is from the FMU's resources.
    pub(super) fn new(token: &str, resources: &Path) -> Result<Self, Refusal> {
        let file = resources.join(RESOURCE);
        let text =
            std::fs::read_to_string(&file).map_err(|error| format!("{}: cannot be read: {error}", file.display()))?;
        let contents: Contents = serde_json::from_str(&text)
            .map_err(|error| format!("{}: was not exported by this program: {error}", file.display()))?;
        if contents.sources != crate::sources() {
            return Err(format!("{}: the library of this FMU was built from other sources", file.display()));
        }
        let own: Arc<str> = contents.token().into();
        if *own != *token {
            return Err(format!("instantiation token {token} is not that of this FMU, {own}"));
        }
        let side = Side::BOTH.into_iter().find(|side| side_name(*side) == contents.side);
        let side = side.ok_or_else(|| format!("{}: side = {} is none", file.display(), contents.side))?;
        let case = Catalogue::standard().case(&contents.case).map_err(|error| error.to_string())?.clone();
        let parameters = initial(&case, &contents)?;
        let variables = Variables::of(&case, side, &parameters, contents.fmi).map_err(|error| error.to_string())?;
        let state = start(&contents, parameters, variables.inputs);
        Ok(Instance { case, side, contents, token: own, variables, state })
    }

    /// Goes back to the state after instantiation.
    pub(super) fn reset(&mut self) -> Result<(), Refusal> {
        self.state = start(&self.contents, initial(&self.case, &self.contents)?, self.variables.inputs);
        Ok(())
    }

    pub(super) fn enter_initialization(&mut self, start: f64) -> Result<(), Refusal> {
        if self.state.phase != Phase::Instantiated {
            return Err("it has been initialised already: a reset comes before another time".to_owned());
        }
        if !start.is_finite() {
            return Err(format!("start time {start} s is not valid; valid: a finite time"));
        }
        (self.state.begin, self.state.time, self.state.phase) = (start, start, Phase::Initialization);
        Ok(())
    }

    /// Says when it is to begin, as a master for FMI 2.0 does before initialization.
    pub(super) fn begin_at(&mut self, start: f64) -> Result<(), Refusal> {
        self.enter_initialization(start)?;
        self.state.phase = Phase::Instantiated;
        Ok(())
    }

    /// Enters initialization at the time that was said.
    pub(super) fn enter_initialization_there(&mut self) -> Result<(), Refusal> {
        self.enter_initialization(self.state.time)
    }

    /// From here on parameters are fixed.
    pub(super) fn exit_initialization(&mut self) -> Result<(), Refusal> {
        if self.state.phase != Phase::Initialization {
            return Err("it is not in initialization mode, which it is asked to leave".to_owned());
        }
        self.built()?;
        self.state.phase = Phase::Stepping;
        Ok(())
    }

    /// From here on there are no steps.
    pub(super) fn terminate(&mut self) {
        self.state.phase = Phase::Terminated;
    }

    fn variable(&self, reference: u32, of: fn(&Variable) -> bool, what: &str) -> Result<&Variable, Refusal> {
        let found = self.variables.get(reference).filter(|variable| of(variable));
        found.ok_or_else(|| format!("value reference {reference} is no {what}"))
    }

    fn built(&mut self) -> Result<&mut Built, Refusal> {
        let State { built, parameters, .. } = &mut self.state;
        if let Some(built) = built {
            return Ok(built);
        }
        let subsystem = build_side(&self.case, self.side, parameters).map_err(|error| error.to_string())?;
        Ok(built.insert(Built::new(subsystem)))
    }

    fn outputs(&mut self) -> Result<&[f64], Refusal> {
        self.built()?;
        let State { built: Some(built), u, .. } = &mut self.state else { unreachable!("built above") };
        if !built.y_known {
            built.subsystem.outputs(u, &mut built.y).map_err(|failure| failure.to_string())?;
            built.y_known = true;
        }
        Ok(&built.y)
    }

    fn rates(&mut self) -> Result<&OutputRates, Refusal> {
        self.built()?;
        let time = self.state.model_time(self.state.time);
        let State { built: Some(built), u, .. } = &mut self.state else { unreachable!("built above") };
        if !built.rates_known {
            let offered = built.subsystem.capabilities().output_rates(time, u, &mut built.rates);
            if !offered.map_err(|failure| failure.to_string())? {
                return Err("the outputs have no known rates".to_owned());
            }
            built.rates_known = true;
        }
        Ok(&built.rates)
    }

    fn observed(&mut self) -> Result<&[f64], Refusal> {
        let h = self.state.model_step;
        let built = self.built()?;
        if !built.observed_known {
            built.subsystem.capabilities().observe(h, &mut built.observed);
            built.observed_known = true;
        }
        Ok(&built.observed)
    }

    fn model(&mut self) -> Result<&ReducedInterfaceModel, Refusal> {
        let h = self.state.model_step;
        let built = self.built()?;
        let model = built.model.as_mut().ok_or("no interface model is offered with these parameters")?;
        if !built.model_known {
            let offered = built.subsystem.capabilities().interface_model(h, model);
            if !offered.map_err(|failure| failure.to_string())? {
                return Err("no interface model is offered in this state".to_owned());
            }
            built.model_known = true;
        }
        Ok(model)
    }

    fn append_part(&mut self, variable: &PartVariable, found: &mut Vec<f64>) -> Result<(), Refusal> {
        variable.part.append(self.model()?, found);
        Ok(())
    }

    /// Writes the numbers of some variables one after the other.
    pub(super) fn get_numbers(&mut self, references: &[u32], values: &mut [MaybeUninit<f64>]) -> Result<(), Refusal> {
        let mut found = Vec::with_capacity(values.len());
        for &reference in references {
            match self.variable(reference, |_| true, "variable")?.kind {
                Kind::Time => found.push(self.state.time),
                Kind::Input(k) => found.push(self.state.u[k]),
                Kind::Output(k) => found.push(self.outputs()?[k]),
                Kind::Rate(k) => found.push(self.rates()?.rate[k]),
                Kind::LongestStep => found.push(self.state.longest),
                Kind::Wait => found.push(self.state.wait),
                Kind::ModelStep => found.push(self.state.model_step),
                Kind::Observable(k) => found.push(self.observed()?[k]),
                Kind::InterfaceWork => {
                    let work = self.built()?.subsystem.capabilities().interface_work();
                    found.push(work.ok_or("no account of work is kept")?);
                }
                Kind::WorkSent => found.push(self.built()?.work.sent().ok_or("no account of work is kept")?),
                Kind::Parameter(k) => match self.state.parameters.iter().nth(k) {
                    Some((_, Value::Number(number))) => found.push(*number),
                    _ => return Err(format!("value reference {reference} is no number")),
                },
                Kind::Model(part) if part.part_type == PartType::Number => self.append_part(part, &mut found)?,
                Kind::Model(_) => return Err(format!("value reference {reference} is no Float64")),
                Kind::Serialisable => return Err("serialisable is Boolean".to_owned()),
            }
        }
        write_all(found, values)
    }

    pub(super) fn get_booleans(&mut self, references: &[u32], values: &mut [MaybeUninit<bool>]) -> Result<(), Refusal> {
        let mut found = Vec::with_capacity(values.len());
        for &reference in references {
            match self.variable(reference, |_| true, "variable")?.kind {
                Kind::Serialisable => found.push(self.state.serialisable),
                Kind::Model(part) if part.part_type == PartType::Truth => {
                    let mut numbers = Vec::new();
                    self.append_part(part, &mut numbers)?;
                    found.extend(numbers.iter().map(|number| *number != 0.0));
                }
                _ => return Err(format!("value reference {reference} is not Boolean")),
            }
        }
        write_all(found, values)
    }

    pub(super) fn get_integers(&mut self, references: &[u32], values: &mut [MaybeUninit<i32>]) -> Result<(), Refusal> {
        let mut found = Vec::with_capacity(values.len());
        for &reference in references {
            match self.variable(reference, |_| true, "variable")?.kind {
                Kind::Model(part) if part.part_type == PartType::Whole => {
                    let mut numbers = Vec::new();
                    self.append_part(part, &mut numbers)?;
                    found.extend(numbers.iter().map(|number| *number as i32));
                }
                _ => return Err(format!("value reference {reference} is no Int32")),
            }
        }
        write_all(found, values)
    }

    /// The text of a parameter that is one of some names.
    pub(super) fn get_text(&self, reference: u32) -> Result<String, Refusal> {
        let variable = self.variable(reference, |variable| matches!(variable.kind, Kind::Parameter(_)), "text")?;
        let value = self
            .state
            .parameters
            .iter()
            .find(|(parameter, _)| *parameter.name == variable.name)
            .map(|(_, value)| value);
        match value {
            Some(Value::Choice(choice)) => Ok(choice.to_string()),
            _ => Err(format!("`{}` is no text", variable.name)),
        }
    }

    fn set_parameter(&mut self, reference: u32, value: &str, choice: bool) -> Result<(), Refusal> {
        let name =
            self.variable(reference, |variable| matches!(variable.kind, Kind::Parameter(_)), "parameter")?.name.clone();
        if self.state.phase.has_begun() {
            return Err(format!("`{name}` is fixed once the model has begun"));
        }
        let known = self.state.parameters.iter().find(|(parameter, _)| *parameter.name == name);
        if known.is_some_and(|(_, known)| matches!(known, Value::Choice(_)) != choice) {
            return Err(format!("`{name}` is of another type"));
        }
        self.state.parameters.set(&name, value).map_err(|error| error.to_string())?;
        self.state.built = None;
        Ok(())
    }

    pub(super) fn set_number(&mut self, reference: u32, value: f64) -> Result<(), Refusal> {
        match self.variable(reference, |_| true, "variable")?.kind {
            Kind::Input(k) => {
                self.state.u[k] = value;
                if let Some(built) = &mut self.state.built {
                    // What depends on inputs; the state has not moved.
                    (built.rates_known, built.y_known) = (false, built.y_known && !self.variables.feedthrough);
                }
            }
            Kind::LongestStep if value >= 0.0 && value.is_finite() => self.state.longest = value,
            Kind::LongestStep => {
                return Err(format!("longest_step_s = {value} is not valid; valid: a finite number, 0 or above"));
            }
            Kind::Wait if self.state.phase.has_begun() => {
                return Err("`wait_s` is fixed once the model has begun".to_owned());
            }
            Kind::Wait if value >= 0.0 && value.is_finite() => self.state.wait = value,
            Kind::Wait => return Err(format!("wait_s = {value} is not valid; valid: a finite number, 0 or above")),
            Kind::ModelStep if value > 0.0 && value.is_finite() => {
                self.state.model_step = value;
                if let Some(built) = &mut self.state.built {
                    (built.model_known, built.observed_known) = (false, false);
                }
            }
            Kind::ModelStep => return Err(format!("rim.step = {value} is not valid; valid: a finite number above 0")),
            Kind::Parameter(_) => self.set_parameter(reference, &format!("{value:?}"), false)?,
            _ => return Err(format!("value reference {reference} is no input and no parameter")),
        }
        Ok(())
    }

    pub(super) fn set_boolean(&mut self, reference: u32, value: bool) -> Result<(), Refusal> {
        self.variable(reference, |variable| variable.kind == Kind::Serialisable, "Boolean that can be set")?;
        if self.state.phase.has_begun() {
            return Err("`serialisable` is fixed once the model has begun".to_owned());
        }
        self.state.serialisable = value;
        Ok(())
    }

    pub(super) fn set_text(&mut self, reference: u32, value: &str) -> Result<(), Refusal> {
        self.set_parameter(reference, value, true)
    }

    /// Covers a communication step; inputs are held.
    pub(super) fn do_step(&mut self, t: f64, h: f64) -> Result<(), Refusal> {
        if !(h.is_finite() && h > 0.0 && t.is_finite()) {
            return Err(format!("a communication step of {h} s from {t} s is not valid; valid: finite, above 0 s"));
        }
        let now = self.state.time;
        if self.state.phase != Phase::Stepping {
            let where_it_is = match self.state.phase {
                Phase::Terminated => "after it was terminated",
                _ => "before its initialization has ended",
            };
            return Err(format!("a communication step is not valid {where_it_is}"));
        }
        // A master counts its own time, k h say: rounding is forgiven.
        if (t - now).abs() > 1e-6 * h + 8.0 * f64::EPSILON * t.abs().max(now.abs()) {
            return Err(format!("a communication step from {t} s is not valid: this instance is at {now} s"));
        }
        self.built()?;
        let motion = self.state.motion(t, h);
        let State { built: Some(built), u, longest, serialisable, history, time, .. } = &mut self.state else {
            unreachable!("built above")
        };
        built.forget();
        if let Some([t, h]) = motion {
            advance(built, u, t, h, *longest)?;
            if *serialisable {
                history.push(Taken { t, h, longest: *longest, u: u.as_slice().into() });
            }
        }
        *time = t + h;
        Ok(())
    }

    /// `Σ ∂unknown/∂known · seed` for each unknown: outputs and their rates, by inputs.
    pub(super) fn directional(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        out: &mut [MaybeUninit<f64>],
    ) -> Result<(), Refusal> {
        if seed.len() != knowns.len() || out.len() != unknowns.len() {
            return Err("as many seeds as knowns and as much room as unknowns are needed".to_owned());
        }
        let inputs = self.variables.inputs;
        for (&unknown, out) in unknowns.iter().zip(out) {
            let mut sum = 0.0;
            let of = self.variable(unknown, |_| true, "variable")?.kind;
            for (&known, seed) in knowns.iter().zip(seed) {
                let Kind::Input(column) = self.variable(known, |_| true, "variable")?.kind else {
                    return Err(format!("value reference {known} is no input"));
                };
                sum += seed
                    * match of {
                        Kind::Output(_) if !self.variables.feedthrough => 0.0,
                        Kind::Output(row) => self.rates()?.feedthrough[row * inputs + column],
                        Kind::Rate(row) => self.rates()?.rate_gain[row * inputs + column],
                        _ => return Err(format!("value reference {unknown} is no output and no rate of one")),
                    };
            }
            out.write(sum);
        }
        Ok(())
    }

    pub(super) fn keep(&self) -> Result<Kept, Refusal> {
        let state = self.state.try_clone().ok_or("this model cannot be copied")?;
        Ok(Kept { state, token: Arc::clone(&self.token) })
    }

    pub(super) fn restore(&mut self, kept: &Kept) -> Result<(), Refusal> {
        self.check_own(kept)?;
        self.state = kept.state.try_clone().ok_or("this model cannot be copied")?;
        Ok(())
    }

    fn check_own(&self, kept: &Kept) -> Result<(), Refusal> {
        if kept.token == self.token { Ok(()) } else { Err("this is a state of another FMU".to_owned()) }
    }

    /// A state as bytes: its parameters, and the steps that led to it. The same library comes to the same bits from
    /// there.
    pub(super) fn serialised(&self, kept: &Kept) -> Result<Vec<u8>, Refusal> {
        self.check_own(kept)?;
        let state = &kept.state;
        if !state.serialisable {
            return Err("`serialisable` was set to false: no steps are noted".to_owned());
        }
        let mut bytes = MARK.to_vec();
        let mut words = format!("{}\n", self.token);
        for (parameter, value) in state.parameters.iter() {
            words += &format!("{}={}\n", parameter.name, text(value));
        }
        bytes.extend((words.len() as u64).to_le_bytes());
        bytes.extend(words.as_bytes());
        let phase = Phase::ALL.iter().position(|phase| *phase == state.phase).unwrap_or_default() as f64;
        let State { longest, model_step, wait, begin, time, .. } = *state;
        let mut numbers = vec![phase, state.built.is_some().into(), longest, model_step, wait, begin, time];
        numbers.extend(&state.u);
        for Taken { t, h, longest, u } in state.history.steps() {
            numbers.extend([t, h, longest]);
            numbers.extend(u);
        }
        numbers.iter().for_each(|number: &f64| bytes.extend(number.to_le_bytes()));
        Ok(bytes)
    }

    /// Returns the length of [`serialised`](Self::serialised).
    pub(super) fn serialised_len(&self, kept: &Kept) -> Result<usize, Refusal> {
        let state = &kept.state;
        let steps = state.history.len();
        let without = State { history: History::default(), ..state.try_clone().ok_or("this model cannot be copied")? };
        Ok(self.serialised(&Kept { state: without, token: Arc::clone(&kept.token) })?.len()
            + 8 * steps * (3 + state.u.len()))
    }

    /// Reads a state back, by taking its steps again.
    pub(super) fn deserialised(&self, bytes: &[u8]) -> Result<Kept, Refusal> {
        let none = || "these bytes are no state of this FMU".to_owned();
        let rest = bytes.strip_prefix(MARK).ok_or_else(none)?;
        let (length, rest) = rest.split_first_chunk::<8>().ok_or_else(none)?;
        let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| none())?;
        let (words, numbers) = rest.split_at_checked(length).ok_or_else(none)?;
        let words = std::str::from_utf8(words).map_err(|_| none())?;
        let (token, words) = words.split_once('\n').ok_or_else(none)?;
        if *token != *self.token || !numbers.len().is_multiple_of(8) {
            return Err(none());
        }
        let mut parameters = self.case.default_parameters();
        for line in words.lines() {
            let (name, value) = line.split_once('=').ok_or_else(none)?;
            parameters.set(name, value).map_err(|error| error.to_string())?;
        }
        let numbers: Vec<f64> =
            numbers.chunks_exact(8).map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap_or_default())).collect();
        let inputs = self.variables.inputs;
        let (&[phase, built, longest, model_step, wait, begin, time], rest) =
            numbers.split_first_chunk::<7>().ok_or_else(none)?;
        let (u, steps) = rest.split_at_checked(inputs).ok_or_else(none)?;
        if !steps.len().is_multiple_of(3 + inputs) {
            return Err(none());
        }
        let mut history = History::default();
        let mut made = None;
        if built != 0.0 {
            let subsystem = build_side(&self.case, self.side, &parameters).map_err(|error| error.to_string())?;
            let made = made.insert(Built::new(subsystem));
            for step in steps.chunks_exact(3 + inputs) {
                let (&[t, h, longest], u) = step.split_first_chunk::<3>().ok_or_else(none)?;
                advance(made, u, t, h, longest)?;
                history.push(Taken { t, h, longest, u: u.into() });
            }
        }
        let phase = Phase::ALL.get(phase as usize).copied().ok_or_else(none)?;
        let state = State {
            parameters,
            longest,
            wait,
            model_step,
            serialisable: true,
            u: u.to_vec(),
            begin,
            time,
            phase,
            history,
            built: made,
        };
        Ok(Kept { state, token: Arc::clone(&self.token) })
    }
}

/// Writes values into room that must hold as many.
fn write_all<T>(found: Vec<T>, room: &mut [MaybeUninit<T>]) -> Result<(), Refusal> {
    if found.len() != room.len() {
        return Err(format!("there is room for {} values, and the variables have {}", room.len(), found.len()));
    }
    room.iter_mut().zip(found).for_each(|(place, value)| {
        place.write(value);
    });
    Ok(())
}

/// The parameters that an FMU begins with.
fn initial(case: &Case, contents: &Contents) -> Result<Parameters, Refusal> {
    let mut parameters = case.default_parameters();
    for (name, value) in &contents.set {
        parameters.set(name, value).map_err(|error| error.to_string())?;
    }
    Ok(parameters)
}

fn start(contents: &Contents, parameters: Parameters, inputs: usize) -> State {
    let mut u = contents.input_starts.clone();
    u.resize(inputs, 0.0);
    State {
        parameters,
        longest: contents.longest_step_s,
        wait: 0.0,
        model_step: contents.model_step_s,
        serialisable: true,
        u,
        begin: 0.0,
        time: 0.0,
        phase: Phase::Instantiated,
        history: History::default(),
        built: None,
    }
}

/// Most steps of its own in one communication step.
const MOST_STEPS: f64 = 1e7;

/// The steps of a macro step as the macro loop takes them.
fn advance(built: &mut Built, u: &[f64], t: f64, h: f64, longest: f64) -> Result<(), Refusal> {
    if longest > 0.0 && h / longest > MOST_STEPS {
        return Err(format!(
            "longest_step_s = {longest} is not valid: a communication step of {h} s would be more than {MOST_STEPS:e} of them"
        ));
    }
    let count = if longest > 0.0 { division(h, longest) } else { 1 };
    let step = MacroStep { index: 0, start: t, length: h };
    let Built { subsystem, y, work, .. } = built;
    for index in 0..count {
        let at = MicroStep::new(step, index, count);
        let moved = subsystem.outputs(u, y).and_then(|()| {
            // At both ends, as the program's loop counts it, to the bit.
            work.add_half_step(at.length, y, u);
            work.add_half_step(at.length, y, u);
            subsystem.step(at.start, u, at.length)
        });
        moved.map_err(|failure| format!("at {:.6} s: {failure}", at.start))?;
    }
    Ok(())
}
