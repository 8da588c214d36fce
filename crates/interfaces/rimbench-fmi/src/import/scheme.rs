//! A coupling scheme that is a class of Python in a file, in a process of its own for each run.

use super::case::Programs;
use super::host::{Ask, Host};
use super::process::Remote;
use crate::model_parts::ModelSize;
use rimbench_core::cosim::{Ports, Sample, Side};
use rimbench_core::error::{Error, Result};
use rimbench_core::schemes::{AnswerForm, Asked, Family, Outside, OutsideScheme, Requirement, SchemeEntry};
use rimbench_results::checksums::hex;
use rimbench_results::input::read_text;
use rimbench_runs::catalogue::SchemeFile;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Reads a scheme from its file, and looks at its class once, of which no object is made yet.
///
/// # Errors
/// [`Error::File`] naming the file: what is wrong with it, and what would be valid.
pub fn read_scheme(file: &SchemeFile, programs: &Programs) -> Result<SchemeEntry> {
    let name = file.path.file_name().unwrap_or_default().to_string_lossy();
    let wrong = |message: String| {
        // A message about its process begins with the name of the file already.
        Error::file(&file.path, message.strip_prefix(&format!("{name}: ")).unwrap_or(&message))
    };
    let text = read_text(&file.path)?;
    let worker =
        Worker { file: file.clone(), python: programs.python.clone().unwrap_or_else(|| PathBuf::from("python3")) };
    let mut told = Vec::new();
    let described = worker.start(&Value::Null).and_then(|mut class| class.ask(Ask::Describe, 0, &[], &mut told));
    described.map_err(&wrong)?;
    let [form, order, samples, model, made_of @ ..] = &*told else {
        return Err(wrong("says nothing of itself".to_owned()));
    };
    let made_of: Vec<u8> = made_of.iter().map(|byte| *byte as u8).collect();
    let digest = hex(&Sha256::digest([text.as_bytes(), &made_of].concat())[..8]);
    let (_, form) = AnswerForm::METHODS[*form as usize];
    let needs = if *model == 1.0 { vec![Requirement::InterfaceModel, Requirement::NoFriction] } else { Vec::new() };
    let about = format!("Class {} in Python", file.class);
    let entry = SchemeEntry::new(file.name.clone(), about, move |construction| {
        let size = construction.model.map(|model| ModelSize::of(model.empty));
        let names = |ports: &Ports| ports.outputs.iter().map(|port| port.name.to_string()).collect::<Vec<_>>();
        let parts = size.iter().flat_map(|size| size.parts().map(|part| (part.name, part.dimensions(*size))));
        let run = json!({
            "mechanics": names(construction.ports.mechanics), "actuator": names(construction.ports.actuator),
            "model": size.map(|_| parts.collect::<Vec<_>>()),
        });
        let who = worker.start(&run).map(|host| {
            Box::new(SchemeProcess { host: Arc::new(Mutex::new(host)), id: 0, input: Vec::new() }) as Box<dyn Outside>
        });
        Ok(Box::new(OutsideScheme::new(who, form, construction.ports)))
    });
    let family = if needs.is_empty() { Family::Signal } else { Family::Model };
    let (order, samples) = (*order as u32, *samples as usize);
    Ok(SchemeEntry { order, samples, family, needs, waits: true, digest: Some(digest.into()), ..entry })
}

/// The least that the start of a process may take.
const START: Duration = Duration::from_secs(60);

/// Starts a process for the class.
struct Worker {
    file: SchemeFile,
    python: PathBuf,
}

impl Worker {
    /// With what the coupling variables are called, for an object of it.
    fn start(&self, run: &Value) -> Result<Remote, String> {
        let SchemeFile { path, class, answer_within_s, .. } = &self.file;
        let file = path.to_str().ok_or_else(|| format!("{}: its path is no text in UTF-8", path.display()))?;
        let plan = json!({ "file": file, "class": class, "scheme": run, "outputs": 0, "inputs": 0 });
        let plan = serde_json::to_vec(&plan).map_err(|error| error.to_string())?;
        // What is kept of a run names no folder of this machine.
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let within = Duration::from_secs_f64(answer_within_s.min(1e9));
        // An interpreter takes its time to start, whatever its answers may take.
        let command = super::python::command(&self.python);
        let remote = Remote::started(&plan, &name, &command, within.max(START), false)?;
        if run.is_null() { Ok(remote) } else { remote.answers_within(within) }
    }
}

/// One object of the class.
struct SchemeProcess {
    host: Arc<Mutex<Remote>>,
    id: u32,
    input: Vec<f64>,
}

impl SchemeProcess {
    fn ask(&self, ask: Ask, told: &mut Vec<f64>) -> Result<(), String> {
        self.host.lock().unwrap_or_else(PoisonError::into_inner).ask(ask, self.id, &self.input, told)
    }
}

fn number_of(side: Side) -> f64 {
    if side == Side::Mechanics { 0.0 } else { 1.0 }
}

impl Outside for SchemeProcess {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), String> {
        let (step, outputs) = (sample.step, sample.y.len() as f64);
        let head = [number_of(from), sample.time, step.index as f64, step.start, step.length, outputs];
        self.input.clear();
        self.input.extend(head);
        self.input.extend(sample.y);
        if let Some(model) = sample.model {
            self.input.push(model.mechanics_step);
            ModelSize::of(model).parts().for_each(|variable| variable.part.append(model, &mut self.input));
        }
        self.ask(Ask::Receive, &mut Vec::new())
    }

    fn answer(&mut self, to: Side, asked: Asked<'_>, told: &mut Vec<f64>) -> Result<usize, String> {
        self.input.clear();
        self.input.push(number_of(to));
        match asked {
            Asked::MacroStep(step, count) => {
                self.input.extend([step.index as f64, count as f64, step.length, step.start]);
            }
            Asked::MicroStep(at, own) => {
                self.input.extend([at.index as f64, at.count as f64, at.length, at.start, at.since_exchange]);
                self.input.extend(own);
            }
        }
        self.ask(Ask::Answer, told)?;
        if told.is_empty() { Err("answers nothing".to_owned()) } else { Ok(told.remove(0) as usize) }
    }

    fn try_clone(&self) -> Option<Box<dyn Outside>> {
        let mut number = Vec::new();
        self.host.lock().unwrap_or_else(PoisonError::into_inner).ask(Ask::Copy, self.id, &[], &mut number).ok()?;
        let id = *number.first()? as u32;
        Some(Box::new(SchemeProcess { host: self.host.clone(), id, input: Vec::new() }))
    }
}

impl Drop for SchemeProcess {
    fn drop(&mut self) {
        if self.id > 0 {
            self.input.clear();
            let _ = self.ask(Ask::Drop, &mut Vec::new());
        }
    }
}
