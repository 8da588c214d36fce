//! A program as a coupling scheme: one exchange per macro step, in which it says how the inputs of both sides run over it.

use super::command_line::{CommandLine, answer_within};
use super::conversation::Conversation;
use super::copies::Copies;
use super::messages::{
    Inputs, Model, Named, Rates, Request, Role, Sample as SampleLine, SchemeDescription, SchemeNeed, SidePorts, Sides,
    Step, wanted,
};
use super::subsystem::unit;
use rimbench_core::cosim::{
    CouplingScheme, Cubic, MacroStep, MicroStep, PerSide, Port, Ports, Sample, SchemeReport, Side, Transmission,
};
use rimbench_core::error::{Cause, Error, Failure, said_at};
use rimbench_core::name::check_new_name;
use rimbench_core::schemes::{Course as Polynomials, Family, Gain, Need, SchemeEntry};
use serde::Deserialize;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A scheme file as it is written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SchemeFile {
    name: String,
    #[serde(default)]
    about: String,
    command: Vec<String>,
    #[serde(default)]
    files: Vec<PathBuf>,
    #[serde(default = "minute")]
    answer_within_s: f64,
}

/// Most pieces in which inputs may be said to run over a macro step.
const MOST_PIECES: usize = 1 << 20;

fn minute() -> f64 {
    60.0
}

/// Reads a file that makes a scheme of a program, and asks the program once what it is.
///
/// # Errors
/// [`Error::File`] naming the file, what is wrong with it or with the program, and what would be valid.
pub fn read_scheme(path: &Path) -> Result<SchemeEntry, Error> {
    let wrong = |message: String| Error::file(path, message);
    let text = std::fs::read_to_string(path).map_err(|error| wrong(format!("cannot be read: {error}")))?;
    let file: SchemeFile = toml::from_str(&text).map_err(|error| {
        wrong(format!("is no scheme that is a program: {}", said_at(&text, error.span(), error.message())))
    })?;
    check_new_name("scheme", &file.name, std::iter::empty()).map_err(|error| wrong(error.to_string()))?;
    let patience = answer_within(file.answer_within_s).map_err(|error| wrong(error.to_string()))?;
    let command = CommandLine::new(path, &file.command, &file.files, patience)?;
    let description = Conversation::start(&command).and_then(|mut program| asked(&mut program)).map_err(wrong)?;
    let mut needs = Vec::new();
    for need in &description.needs {
        needs.extend_from_slice(match need {
            SchemeNeed::InterfaceModel => &[Need::InterfaceModel, Need::NoFriction],
            SchemeNeed::Rates => &[Need::OutputRates],
            SchemeNeed::ForceDisplacement => &[Need::ForceDisplacement],
        });
    }
    let gain = description.gain.as_ref().map(|gain| {
        let about = if gain.about.is_empty() { "the program's own".to_owned() } else { gain.about.clone() };
        Gain { about: about.into(), default: gain.default, range: gain.range }
    });
    let family = if needs.contains(&Need::InterfaceModel) { Family::Model } else { Family::Signal };
    let about = if file.about.is_empty() { format!("A program of its own: {command}") } else { file.about };
    let mut hash = Sha256::new();
    hash.update(&text);
    hash.update(&command.digest);
    let digest: String = hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    let (order, samples, has_gain) = (description.order, description.samples, gain.is_some());
    let shared = Arc::new((command, description));
    let entry = SchemeEntry::new(file.name, about, move |construction| {
        let gain = has_gain.then_some(construction.gain);
        Ok(Box::new(ProgramScheme::new(&shared, construction.ports, gain)))
    });
    Ok(SchemeEntry { order, samples, family, needs, gain, digest: Some(digest.into()), ..entry })
}

fn asked(program: &mut Conversation) -> Result<SchemeDescription, String> {
    program.hello(Role::Scheme, &Request::hello(Role::Scheme, None, None))
}

/// A program and what it has said it is.
type Described = Arc<(CommandLine, SchemeDescription)>;

/// What one side has sent last.
#[derive(Debug, Clone, Default)]
struct Sent {
    time: f64,
    y: Vec<f64>,
    model: Option<Model>,
    rates: Option<Rates>,
}

impl Sent {
    fn line(&self) -> SampleLine<'_> {
        let Sent { time, y, model, rates } = self;
        SampleLine { time_s: *time, y, interface_model: model.as_ref(), rates: rates.as_ref() }
    }
}

/// The inputs of one side over the present macro step.
#[derive(Debug, Clone)]
enum Course {
    /// As polynomials of the time since the communication point.
    Polynomials(Polynomials),
    /// Held over each of some equal parts of it.
    Pieces(Transmission),
}

/// One copy of a program's state.
struct ProgramScheme {
    /// None of a program that could not begin.
    copies: Result<Arc<Mutex<Copies>>, String>,
    id: usize,
    described: Described,
    names: PerSide<Vec<String>>,
    sent: PerSide<Sent>,
    courses: PerSide<Course>,
    step: MacroStep,
    actuator_micro_step: f64,
    /// Whether the courses are of what was sent last.
    answered: bool,
}

impl ProgramScheme {
    fn new(described: &Described, ports: PerSide<&Ports>, gain: Option<f64>) -> Self {
        let named = |ports: &[Port]| -> Vec<Named> {
            ports.iter().map(|port| (port.name.to_string(), unit(port).to_owned())).collect()
        };
        let of = |ports: &Ports| SidePorts {
            inputs: named(&ports.inputs),
            outputs: named(&ports.outputs),
            direct_feedthrough: ports.direct_feedthrough,
        };
        let sides = Sides { mechanics: of(ports.mechanics), actuator: of(ports.actuator) };
        let begin = || -> Result<Copies, String> {
            let mut conversation = Conversation::start(&described.0)?;
            if asked(&mut conversation)? != described.1 {
                return Err(format!("`{}` describes itself otherwise than before", described.0));
            }
            conversation.ask(&Request::Begin { parameters: None, sides: Some(&sides), gain }, |_| Ok(()))?;
            Ok(Copies::new(conversation))
        };
        ProgramScheme {
            copies: begin().map(|copies| Arc::new(Mutex::new(copies))),
            id: 0,
            described: Arc::clone(described),
            names: ports.map(|ports| ports.outputs.iter().map(|port| port.name.to_string()).collect()),
            sent: PerSide::default(),
            courses: ports.map(|ports| Course::Polynomials(Polynomials::of(vec![[0.0; 4]; ports.inputs.len()], 0))),
            step: MacroStep { index: 0, start: 0.0, length: 0.0 },
            actuator_micro_step: 0.0,
            answered: false,
        }
    }

    /// The exchange of this macro step.
    fn exchange(&mut self) -> Result<(), Failure> {
        // A sample of which a number is none cannot be written down.
        for side in Side::BOTH {
            let none = self.sent[side].y.iter().position(|y| !y.is_finite());
            if let Some(index) = none {
                return Err(Cause::NonFinite { quantity: self.names[side][index].clone().into() }.into());
            }
        }
        let MacroStep { index, start, length } = self.step;
        let actuator_steps = (length / self.actuator_micro_step).round() as usize;
        let request = Request::Inputs {
            step: Step { index, start_s: start, length_s: length, actuator_steps },
            mechanics: self.sent.mechanics.line(),
            actuator: self.sent.actuator.line(),
        };
        let copies = self.copies.as_ref().map_err(|message| Failure::reported(message.clone()))?;
        let mut copies = copies.lock().unwrap_or_else(PoisonError::into_inner);
        let (forces, motion) = (self.names.actuator.len(), self.names.mechanics.len());
        let asked = copies.of(self.id).and_then(|program| {
            program.ask(&request, |reply| {
                let mechanics = wanted(reply.mechanics, "mechanics")?.course(forces, "mechanics")?;
                let actuator = wanted(reply.actuator, "actuator")?.course(motion, "actuator")?;
                Ok(PerSide { mechanics, actuator })
            })
        });
        self.courses = asked.map_err(Failure::reported)?;
        self.answered = true;
        Ok(())
    }
}

impl Inputs {
    /// What a program says of the inputs of a side, of which there are so many.
    fn course(self, inputs: usize, whose: &str) -> Result<Course, String> {
        match self {
            Inputs { polynomials: Some(rows), pieces: None } => {
                if rows.len() != inputs {
                    return Err(format!("{} `polynomials` of the {whose} instead of {inputs}", rows.len()));
                }
                if let Some(row) = rows.iter().find(|row| row.is_empty() || row.len() > 4) {
                    let what = format!("{} coefficients in a polynomial of the {whose}", row.len());
                    return Err(format!("{what}; valid: 1 to 4, those of 1, τ, τ², τ³"));
                }
                let degree = rows.iter().map(Vec::len).max().unwrap_or(1) - 1;
                let cubic = |row: &Vec<f64>| std::array::from_fn(|power| row.get(power).copied().unwrap_or(0.0));
                Ok(Course::Polynomials(Polynomials::of(rows.iter().map(cubic).collect(), degree)))
            }
            Inputs { polynomials: None, pieces: Some(rows) } => {
                if !(1..=MOST_PIECES).contains(&rows.len()) {
                    return Err(format!("{} `pieces` of the {whose}; valid: 1 to {MOST_PIECES}", rows.len()));
                }
                if let Some(row) = rows.iter().find(|row| row.len() != inputs) {
                    return Err(format!("{} inputs in a piece of the {whose} instead of {inputs}", row.len()));
                }
                let mut pieces = Transmission::new(inputs, rows.len());
                rows.iter().for_each(|row| pieces.push(row));
                Ok(Course::Pieces(pieces))
            }
            _ => Err(format!("no inputs of the {whose}; valid: either `polynomials` or `pieces`")),
        }
    }
}

impl CouplingScheme for ProgramScheme {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let sent = &mut self.sent[from];
        sent.time = sample.time;
        sent.y.clear();
        sent.y.extend_from_slice(sample.y);
        // What is sent ahead comes without.
        if let Some(model) = sample.model {
            sent.model = Some(Model::of(model).map_err(Failure::reported)?);
        }
        if let Some(rates) = sample.rates {
            let (rate, feedthrough) = (rates.rate.clone(), rates.feedthrough.clone());
            sent.rates = Some(Rates { rate, feedthrough, rate_gain: rates.rate_gain.clone() });
        }
        (self.step, self.actuator_micro_step) = (sample.step, sample.actuator_micro_step);
        self.answered = false;
        Ok(())
    }

    fn input(&mut self, to: Side, at: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        // Nobody asks for an input at the last communication point, and so nobody need answer there.
        if !self.answered {
            self.exchange()?;
        }
        match &self.courses[to] {
            Course::Polynomials(polynomials) => polynomials.mean(at, u),
            Course::Pieces(pieces) => pieces.mean_over(at.index, at.count, u),
        }
        Ok(())
    }

    fn course(&self, to: Side, at: MicroStep, course: &mut [Cubic]) -> bool {
        match &self.courses[to] {
            Course::Polynomials(polynomials) => polynomials.within(at, course),
            Course::Pieces(_) => false,
        }
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport::default()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        if !self.described.1.state {
            return None;
        }
        // A program that fails here has said that it gives its state away: what is made of it fails when it is used, and says why.
        let copies = self.copies.clone();
        let id =
            copies.as_ref().map_or(0, |copies| copies.lock().unwrap_or_else(PoisonError::into_inner).copy(self.id));
        Some(Box::new(ProgramScheme {
            copies,
            id,
            described: Arc::clone(&self.described),
            names: self.names.clone(),
            sent: self.sent.clone(),
            courses: self.courses.clone(),
            ..*self
        }))
    }
}

impl Drop for ProgramScheme {
    fn drop(&mut self) {
        if let Ok(copies) = &self.copies {
            copies.lock().unwrap_or_else(PoisonError::into_inner).drop_copy(self.id);
        }
    }
}
