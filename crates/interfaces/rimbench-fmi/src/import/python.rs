//! A side that is a class of Python in a file, in a process of its own.

use super::case_file::{CaseFile, DIGEST};
use super::host::{Ask, Host};
use super::probing::SideNotes;
use super::process::Remote;
use super::side::{ImportedSide, Offers, Shape};
use crate::export::side_name;
use crate::model_parts::ModelSize;
use rimbench_cases::parameter::{Parameters, Value};
use rimbench_core::cosim::{Port, Ports, Quantity, Side};
use rimbench_core::error::{Error, Result};
use rimbench_core::name::Name;
use rimbench_results::checksums::hex;
use rimbench_results::input::read_text;
use serde_json::{Map, json};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What drives an object of Python.
const WORKER: &str = include_str!("python_worker.py");

/// The command that drives a class by an interpreter.
pub(super) fn command(python: &Path) -> [PathBuf; 3] {
    [python.to_owned(), "-c".into(), WORKER.into()]
}

/// One class with what the case makes of it.
pub(super) struct PythonMember {
    pub(super) file: PathBuf,
    class: String,
    pub(super) digest: String,
    pub(super) ports: Ports,
    pub(super) offers: Offers,
    pub(super) model: Option<ModelSize>,
    /// The shortest step in which that is its model, s.
    model_from_s: f64,
    /// What it is given besides the parameters of the case.
    start: Map<String, serde_json::Value>,
    python: PathBuf,
    answer_within: Duration,
}

impl PythonMember {
    /// Makes the class once, to see what it offers.
    pub(super) fn open(
        file: &CaseFile,
        (path, class): (&Path, &str),
        side: Side,
        rows: &[[String; 3]],
        python: &Path,
        usual: &Parameters,
    ) -> Result<Self> {
        let table = file.side(side);
        let wrong = |message: String| Error::file(path, message);
        let text = read_text(path)?;
        if table.needs.len() + table.observe.len() > 0
            || table.probe_step_s.is_some()
            || table.log
            || table.interface_work.is_some()
        {
            return Err(wrong(format!(
                "is a side of Python: [{}] may have python, class, start and direct_feedthrough, and all else is said by the class",
                side_name(side)
            )));
        }
        let scaled = |which: usize| {
            let ends = file.interface.iter().filter_map(|row| row.end(side, which));
            ends.filter_map(|(variable, factor)| factor.map(|factor| (variable, factor))).next()
        };
        if let Some((variable, factor)) = (0..3).find_map(scaled).filter(|(_, factor)| *factor != 1.0) {
            return Err(wrong(format!(
                "is a side of Python, and `{variable}` has factor = {factor}; valid: none, for a class takes and puts out m, m/s and N itself"
            )));
        }
        let list = |which: usize, quantity| rows.iter().map(move |row| Port::new(row[which].clone(), quantity));
        let motion = list(0, Quantity::Position).chain(list(1, Quantity::Velocity)).collect();
        let force = list(2, Quantity::Force).collect();
        let (outputs, inputs) = if side == Side::Mechanics { (motion, force) } else { (force, motion) };
        let mut start = Map::new();
        for (name, value) in &table.start {
            let value = serde_json::to_value(value).map_err(|error| wrong(format!("start of {name}: {error}")))?;
            start.insert(name.clone(), value);
        }
        let mut member = PythonMember {
            file: path.to_owned(),
            class: class.to_owned(),
            digest: hex(&Sha256::digest(&text)[..8]),
            ports: Ports { inputs, outputs, direct_feedthrough: false },
            offers: Offers { copies: true, ..Offers::default() },
            model: None,
            model_from_s: 0.0,
            start,
            python: python.to_owned(),
            answer_within: Duration::from_secs_f64(file.answer_within_s.min(1e9)),
        };
        let mut host = member.host(usual).map_err(&wrong)?;
        let mut told = Vec::new();
        host.ask(Ask::Describe, 0, &[], &mut told).map_err(|message| wrong(message.clone()))?;
        let [through, work, model, rates, engine, from_s, contacts, names @ ..] = &*told else {
            return Err(wrong("says nothing of itself".to_owned()));
        };
        let names: Vec<u8> = names.iter().map(|byte| *byte as u8).collect();
        let names = String::from_utf8_lossy(&names);
        let mut parts = names.split('\0');
        let [names, without_model, made_of] = std::array::from_fn(|_| parts.next().unwrap_or_default());
        if !made_of.is_empty() {
            member.digest = hex(&Sha256::digest(text + made_of)[..8]);
        }
        member.ports.direct_feedthrough = table.direct_feedthrough.unwrap_or(*through == 1.0);
        member.offers.work = *work == 1.0;
        member.offers.rates = *rates == 1.0 && side == Side::Actuator;
        member.model_from_s = *from_s;
        member.offers.observables = names.lines().map(|name| Name::from(name.to_owned())).collect();
        let (contacts, interface) = (*contacts as usize, rows.len());
        let size = ModelSize { contacts, interface, friction: false, plastic: false, engine: *engine == 1.0 };
        member.model = (*model == 1.0 && side == Side::Mechanics).then_some(size);
        member.offers.without =
            (member.model.is_none() && !without_model.is_empty()).then(|| without_model.to_owned().into());
        Ok(member)
    }

    fn host(&self, parameters: &Parameters) -> Result<Remote, String> {
        let mut all = self.start.clone();
        for (parameter, value) in parameters.iter().filter(|(parameter, _)| parameter.name != DIGEST) {
            let value = match value {
                Value::Number(number) => json!(number),
                Value::Choice(choice) => json!(&**choice),
            };
            all.insert(parameter.name.to_string(), value);
        }
        let (outputs, inputs) = (self.ports.outputs.len(), self.ports.inputs.len());
        let file = self
            .file
            .to_str()
            .ok_or_else(|| format!("{}: its path is no text in UTF-8; valid: a path that is", self.file.display()))?;
        let plan = json!({
            "file": file, "class": self.class, "parameters": all, "outputs": outputs, "inputs": inputs,
        });
        let plan = serde_json::to_vec(&plan).map_err(|error| error.to_string())?;
        Remote::started(&plan, &self.file.display().to_string(), &command(&self.python), self.answer_within, false)
    }

    /// Makes an object of it.
    pub(super) fn side(&self, parameters: &Parameters, notes: &SideNotes) -> Result<ImportedSide, String> {
        let shape = Shape { taken: (0..self.ports.inputs.len()).collect(), integrals: Vec::new() };
        let host = Box::new(self.host(parameters)?);
        Ok(ImportedSide::new(host, (&self.file, notes), self.ports.clone(), self.offers.clone(), shape))
    }

    /// Takes back what it says that it offers, where a check has found that it does not. The check takes steps that no
    /// run takes.
    pub(super) fn doubt(&mut self, state: Option<String>, model: Option<String>) {
        self.offers.model_from_s = self.model_from_s;
        if state.is_some() {
            self.offers.without_copies = state;
        }
        if let Some(words) = model {
            (self.model, self.offers.without) = (None, Some(words.into()));
        }
    }
}
