//! A program as a side of a case file: what the file says of it, and what it is told when a run begins.

use super::case_file::SideTable;
use super::side::ImportedSide;
use crate::export::side_name;
use crate::program::{CommandLine, Named, ProgramSide};
use rimbench_cases::cases::{Parameters, Value as ParameterValue};
use rimbench_core::cosim::{Ports, Side};
use rimbench_core::error::{Error, Result};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A program, and what it is told when a run begins.
pub(super) struct ProgramMember {
    pub(super) side: ProgramSide,
    /// The file that names it.
    file: PathBuf,
    start: BTreeMap<String, Value>,
    /// Parameters of the case by which the program is told of them; none: all, by their own names.
    parameters: Option<Vec<(String, String)>>,
}

impl ProgramMember {
    /// Asks a program what it is; it knows its inputs and outputs by `names`.
    ///
    /// # Errors
    /// What the file says of it and should not; [`Error::File`] with what the program says and should not.
    pub(super) fn open(
        path: &Path,
        table: &SideTable,
        side: Side,
        ports: &Ports,
        names: [Vec<Named>; 2],
        patience: Duration,
    ) -> Result<Self> {
        let table_name = side_name(side);
        let in_vain = [
            ("fmu", table.fmu.is_some()),
            ("needs", !table.needs.is_empty()),
            ("observe", !table.observe.is_empty()),
            ("interface_work", table.interface_work.is_some()),
            ("direct_feedthrough", table.direct_feedthrough.is_some()),
            ("probe_step_s", table.probe_step_s.is_some()),
        ];
        if let Some((key, _)) = in_vain.iter().find(|(_, given)| *given) {
            return Err(Error::Incompatible(format!(
                "[{table_name}] has a `command`, and so no `{key}`: a program says itself what it is; valid beside command: files, start"
            )));
        }
        let Some(words) = &table.command else {
            return Err(Error::Incompatible(format!("[{table_name}] has no `command`")));
        };
        let command = CommandLine::new(path, words, &table.files, patience)?;
        let side = ProgramSide::open(command, side, ports, names)
            .map_err(|message| Error::file(path, format!("[{table_name}]: {message}")))?;
        let start = table.start.iter().map(|(name, value)| {
            let told = told(value).ok_or_else(|| {
                let valid = "finite numbers, texts, true, false, and lists of these";
                Error::invalid(format!("start of [{table_name}]: {name}"), format!("{value:?}"), valid)
            });
            Ok((name.clone(), told?))
        });
        let start = start.collect::<Result<_>>()?;
        Ok(ProgramMember { side, file: path.to_owned(), start, parameters: None })
    }

    /// Tells it of these parameters of the case only, by the second names.
    ///
    /// # Errors
    /// Two for one name.
    pub(super) fn told_of(self, parameters: Vec<(String, String)>, side: Side) -> Result<Self> {
        for (index, (name, to)) in parameters.iter().enumerate() {
            let twice = parameters[..index].iter().any(|(_, other)| other == to) || self.start.contains_key(to);
            if twice {
                return Err(Error::Incompatible(format!(
                    "`{to}` of [{}] is set twice, by [parameters.{name}] for one",
                    side_name(side)
                )));
            }
        }
        Ok(ProgramMember { parameters: Some(parameters), ..self })
    }

    /// What it is told when a run with these parameters begins.
    fn told(&self, parameters: &Parameters) -> BTreeMap<String, Value> {
        let mut told = self.start.clone();
        for (parameter, value) in parameters.iter() {
            let value = match value {
                ParameterValue::Number(number) => Value::from(*number),
                ParameterValue::Choice(choice) => Value::from(choice.as_ref()),
            };
            match &self.parameters {
                None => drop(told.insert(parameter.name.to_string(), value)),
                Some(list) => {
                    let to = list.iter().filter(|(name, _)| *name == *parameter.name);
                    told.extend(to.map(|(_, to)| (to.clone(), value.clone())));
                }
            }
        }
        told
    }

    /// The side for a run.
    pub(super) fn made(&self, parameters: &Parameters) -> ImportedSide {
        self.side.side(&self.told(parameters))
    }

    /// Lets it begin once.
    ///
    /// # Errors
    /// [`Error::File`] with what keeps it from that.
    pub(super) fn try_to_begin(&self, parameters: &Parameters) -> Result<()> {
        let begun = self.side.begin(&self.told(parameters));
        begun.map(drop).map_err(|message| Error::file(&self.file, message))
    }
}

/// A value of TOML as one of JSON, if it has one.
fn told(value: &toml::Value) -> Option<Value> {
    match value {
        toml::Value::String(text) => Some(text.as_str().into()),
        toml::Value::Integer(number) => Some((*number).into()),
        toml::Value::Float(number) => number.is_finite().then(|| (*number).into()),
        toml::Value::Boolean(truth) => Some((*truth).into()),
        toml::Value::Array(list) => list.iter().map(told).collect::<Option<Vec<_>>>().map(Value::from),
        toml::Value::Datetime(_) | toml::Value::Table(_) => None,
    }
}
