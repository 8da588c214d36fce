//! One `[[schemes]]` of an experiment file: a label, macro steps of its own, and any option that a run has.

use crate::deadline_log::DeadlineLog;
use crate::grid::{MacroSteps, scalar, scalar_text};
use rimbench_core::cosim::{Channel, CommunicationGrid};
use rimbench_core::error::{Error, Result, shortened};
use rimbench_results::input::{beside, read_text};
use rimbench_results::text_place::{line_of, said_at};
use rimbench_runs::catalogue::SchemeFile;
use rimbench_runs::{Given, RunRequest};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// As it stands in the file, with its place.
pub(super) type RawRow = Spanned<BTreeMap<String, toml::Value>>;

/// Keys of a row besides the options of a run.
const OWN_KEYS: [&str; 7] =
    ["label", "macro_steps_s", "step_tolerances", "delivery", "file", "class", "answer_within_s"];

/// Shortest time in which a process of its own can be expected to answer, s.
const SHORTEST_ANSWER: f64 = 1e-3;

/// Logs of computing times that rows name by their path from the file.
pub(super) struct Logs<'a> {
    /// The experiment file.
    pub(super) file: &'a Path,
    /// What the file holds of them, as the copy beside results does.
    pub(super) kept: &'a BTreeMap<String, String>,
    /// Logs that were read from their own files.
    pub(super) read: BTreeMap<String, String>,
    /// In a copy: where files of cases and schemes are from there.
    pub(super) moved: &'a BTreeMap<PathBuf, PathBuf>,
}

impl Logs<'_> {
    /// Returns the text of a log.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read; [`Error::UnknownName`] if the file holds others.
    fn text(&mut self, name: &str) -> Result<&str> {
        if !self.kept.is_empty() {
            let kept = self.kept.get(name).map(String::as_str);
            return kept.ok_or_else(|| Error::unknown("log in [logs]", name, self.kept.keys().map(String::as_str)));
        }
        if !self.read.contains_key(name) {
            self.read.insert(name.to_owned(), read_text(&beside(self.file, name.as_ref()))?);
        }
        Ok(&self.read[name])
    }

    /// Writes what was read as a table of the file; a JSON text is one of TOML as well.
    pub(super) fn table(&self) -> Option<String> {
        let json = |text: &String| serde_json::Value::from(text.as_str()).to_string().replace('\x7f', "\\u007f");
        let lines = self.read.iter().map(|(name, text)| format!("{} = {}\n", json(name), json(text)));
        (!self.read.is_empty()).then(|| format!("\n[logs]\n{}", lines.collect::<String>()))
    }
}

/// Options of a run that a row does not set: the grid does.
const SET_BY_GRID: [&str; 3] = ["case", "macro_step_s", "phase"];

/// One row of schemes.
#[derive(Debug, Clone)]
pub(super) struct SchemeRow {
    /// Line of the file in which it begins, from 1.
    line: usize,
    /// What the file gives, else the scheme's name, with what differs where several rows have that scheme; see
    /// [`with_labels`].
    pub(super) label: String,
    /// Options as they stand in the file, the scheme aside.
    given: BTreeMap<String, String>,
    /// Instead of those of the case or the experiment.
    pub(super) macro_steps_s: Option<MacroSteps>,
    /// Tolerances of a step control, one after the other; none: as the request has it.
    pub(super) step_tolerances: Option<Vec<f64>>,
    /// Whether the file has a table `delivery`.
    pub(super) has_delivery: bool,
    /// Logs that are replayed: the option that they make, what else that says, and the name of the file.
    logs: Vec<(&'static str, Channel, String, DeadlineLog)>,
    /// The class that its scheme is, where a file has it, and that file as it is written.
    pub(super) of_file: Option<(PathBuf, SchemeFile)>,
    /// Everything else.
    pub(super) request: RunRequest,
}

impl SchemeRow {
    /// Reads a row; `source` is the text of the file.
    ///
    /// # Errors
    /// Unknown keys, and values that cannot be read.
    pub(super) fn read(row: RawRow, source: &str, logs: &mut Logs<'_>) -> Result<Self> {
        let line = line_of(source, row.span().start);
        Self::read_keys(row.into_inner(), line, logs).map_err(|error| in_row(line, &error))
    }

    fn read_keys(keys: BTreeMap<String, toml::Value>, line: usize, logs: &mut Logs<'_>) -> Result<Self> {
        let mut row = SchemeRow {
            line,
            label: String::new(),
            given: BTreeMap::new(),
            macro_steps_s: None,
            step_tolerances: None,
            has_delivery: false,
            logs: Vec::new(),
            of_file: None,
            request: RunRequest::default(),
        };
        let mut of_run = Vec::new();
        let (mut file, mut class, mut answer_within_s) = (None, None, None);
        for (key, value) in keys {
            match key.as_str() {
                "file" => file = Some(scalar_text(&key, &value)?),
                "class" => class = Some(scalar_text(&key, &value)?),
                "answer_within_s" => answer_within_s = Some(list::<f64>(&key, value)?),
                "label" => {
                    row.label = scalar_text(&key, &value)?;
                    if row.label.trim().is_empty() {
                        return Err(Error::invalid("label", format!("{:?}", row.label), "text, or no label at all"));
                    }
                }
                "macro_steps_s" => row.macro_steps_s = Some(list(&key, value)?),
                "step_tolerances" => row.step_tolerances = Some(list(&key, value)?),
                "delivery" => {
                    row.has_delivery = true;
                    row.read_delivery(value, logs)?;
                }
                option => {
                    if !options().any(|known| known == option) {
                        return Err(Error::unknown(
                            "key of [[schemes]]",
                            option,
                            OWN_KEYS.into_iter().chain(options()),
                        ));
                    }
                    let value = match value {
                        toml::Value::Table(parts) => Given::Text(parts_text(parts)?),
                        value => scalar(option, &value)?,
                    };
                    if option != "scheme" {
                        row.given.insert(option.to_owned(), value.to_string());
                    }
                    of_run.push((key, value));
                }
            }
        }
        row.request.put_all(&of_run)?;
        match (file, class) {
            (Some(file), Some(class)) => row.read_class(file, class, answer_within_s, logs)?,
            (None, None) if answer_within_s.is_none() => {}
            (file, class) => {
                let found = [file, class].map(|given| given.unwrap_or_else(|| "nothing".to_owned())).join(" and ");
                let expected = "both of a scheme in Python, as in `file = \"mine.py\", class = \"MidHold\"`";
                return Err(Error::invalid("file and class", found, expected));
            }
        }
        if row.request.scheme.as_ref().is_none_or(String::is_empty) {
            let expected = "the name of a scheme, or file = \"….py\" and class, one in Python";
            return Err(Error::invalid("scheme", "nothing", expected));
        }
        if let (Some(_), Some(one)) = (&row.step_tolerances, row.request.step_tolerance) {
            return Err(Error::Incompatible(format!(
                "step_tolerances and step_tolerance = {one}: give one of the two"
            )));
        }
        if row.label.contains(char::is_control) {
            return Err(Error::invalid("label", format!("{:?}", row.label), "text without tabs or line ends"));
        }
        Ok(row)
    }

    /// Takes the scheme that is a class in a file; `scheme` is then how it is called.
    fn read_class(&mut self, file: String, class: String, within: Option<f64>, logs: &Logs<'_>) -> Result<()> {
        let valid = class.chars().all(|c| c.is_alphanumeric() || c == '_') && !class.is_empty();
        if !valid {
            return Err(Error::invalid("class", format!("{class:?}"), "the name of a class of Python"));
        }
        if file.is_empty() {
            return Err(Error::invalid("file", "\"\"", "the path of a file of Python"));
        }
        let file = PathBuf::from(file);
        let place = beside(logs.file, logs.moved.get(&file).unwrap_or(&file));
        let mut scheme = SchemeFile::new(place, class);
        if let Some(within) = within {
            if !(within.is_finite() && within >= SHORTEST_ANSWER) {
                let expected = format!("a finite time of at least {SHORTEST_ANSWER} s");
                return Err(Error::invalid("answer_within_s", within, expected));
            }
            scheme.answer_within_s = within;
        }
        scheme.name = self.request.scheme.get_or_insert(scheme.name).clone();
        self.of_file = Some((file, scheme));
        Ok(())
    }

    /// Reads how samples arrive: a table `delivery` with `up` and `down`, each a table or its text, `late_samples` and
    /// `late_forces`.
    ///
    /// ```text
    /// delivery.up = { delay = 2, jitter = 1, loss = 0.2, seed = 3, missed = [4, 9] }
    /// delivery.up = { log = "times.csv", deadline_s = 5e-3 }
    /// ```
    fn read_delivery(&mut self, value: toml::Value, logs: &mut Logs<'_>) -> Result<()> {
        let keys = [("up", "delivery_up"), ("down", "delivery_down"), ("late_samples", ""), ("late_forces", "")];
        let toml::Value::Table(table) = value else {
            return Err(Error::invalid("delivery", value.type_str(), "a table, as in `delivery.up = { delay = 2 }`"));
        };
        for (key, value) in table {
            let Some(&(known, option)) = keys.iter().find(|(known, _)| *known == key) else {
                return Err(Error::unknown("key of delivery", &key, keys.iter().map(|(known, _)| *known)));
            };
            let option: &'static str = if option.is_empty() { known } else { option };
            let by_key = |error: Error| match error {
                Error::InvalidValue { found, expected, .. } => {
                    Error::InvalidValue { key: format!("delivery.{key}"), found, expected }
                }
                other => other,
            };
            let (text, log) = match value {
                toml::Value::Table(mut parts) => {
                    let log = (parts.remove("log"), parts.remove("deadline_s"));
                    (parts_text(parts)?, log)
                }
                text => (scalar_text(&key, &text)?, (None, None)),
            };
            let (name, deadline) = match log {
                (None, None) => {
                    self.request.put(option, &text).map_err(by_key)?;
                    self.given.insert(option.to_owned(), text);
                    continue;
                }
                (Some(toml::Value::String(name)), Some(toml::Value::Float(deadline))) => (name, deadline),
                (Some(toml::Value::String(name)), Some(toml::Value::Integer(deadline))) => (name, deadline as f64),
                (log, deadline) => {
                    let found = [log, deadline].map(|value| value.map_or("nothing", |value| value.type_str()));
                    let expected = "a file as text and a time as a number together, as in `log = \"times.csv\", deadline_s = 5e-3`";
                    return Err(Error::invalid("log and deadline_s", found.join(" and "), expected));
                }
            };
            if !option.starts_with("delivery") {
                return Err(Error::invalid(&key, "a log", "delivery.up or delivery.down, with the log in it"));
            }
            if name.trim().is_empty() {
                return Err(Error::invalid(format!("log of delivery.{key}"), &name, "the path of a log"));
            }
            let channel = if text.is_empty() { Channel::default() } else { text.parse().map_err(by_key)? };
            let log = DeadlineLog::read(logs.text(&name)?, deadline).map_err(|why| Error::file(&name, why))?;
            self.logs.push((option, channel, name.clone(), log));
            self.given.insert(option.to_owned(), [text, format!("log:{name},deadline_s:{deadline}")].join(","));
        }
        Ok(())
    }

    /// Puts the logs of a row into a request, as they are for a run on a grid; returns what is to be said of them.
    ///
    /// # Errors
    /// [`Error::File`] naming a log whose rows are not those of the macro steps.
    pub(super) fn replay(&self, grid: &CommunicationGrid, request: &mut RunRequest) -> Result<Vec<String>> {
        let mut notes = Vec::new();
        for (option, channel, name, log) in &self.logs {
            let mut channel = channel.clone();
            channel.check(option, grid.macro_steps())?;
            let note = log.replay(grid, &mut channel).map_err(|why| Error::file(name, why))?;
            notes.extend(note.map(|note| format!("{name} {note}")));
            request.put(option, &channel.to_string())?;
        }
        Ok(notes)
    }

    /// What determines its runs.
    fn settings(&self) -> impl PartialEq + '_ {
        (&self.request, &self.logs, &self.of_file)
    }

    /// Whether it replays logs.
    pub(super) fn has_logs(&self) -> bool {
        !self.logs.is_empty()
    }

    /// What the file asks of its runs, once per tolerance.
    pub(super) fn requests(&self) -> Vec<RunRequest> {
        let Some(tolerances) = &self.step_tolerances else { return vec![self.request.clone()] };
        let with = |&tolerance: &f64| RunRequest { step_tolerance: Some(tolerance), ..self.request.clone() };
        tolerances.iter().map(with).collect()
    }

    /// An error about its label, with its place.
    pub(super) fn misnamed(&self, why: &str) -> Error {
        in_row(
            self.line,
            &Error::invalid("label", format!("{:?}", self.label), format!("a label of its own: this one {why}")),
        )
    }

    /// An error about the file of its scheme, with its place.
    pub(super) fn place_of_file(&self, error: &Error) -> Error {
        in_row(self.line, error)
    }

    /// An error about this row in a case, with its place.
    pub(super) fn place(&self, error: &Error, case: &str) -> Error {
        let (line, label, case) = (self.line, shortened(&self.label), shortened(case));
        Error::Incompatible(format!("[[schemes]] in line {line} (`{label}` on case `{case}`): {error}"))
    }
}

/// Writes a table as the text of an option that is made of parts.
fn parts_text(table: toml::Table) -> Result<String> {
    let parts = table.into_iter().map(|(name, part)| match part {
        toml::Value::Array(steps) => {
            let steps: Result<Vec<String>> = steps.iter().map(|step| scalar_text(&name, step)).collect();
            Ok(format!("{name}:{}", steps?.join("+")))
        }
        part => Ok(format!("{name}:{}", scalar_text(&name, &part)?)),
    });
    Ok(parts.collect::<Result<Vec<String>>>()?.join(","))
}

/// Reads an axis of the grid that a row has for itself.
fn list<T: serde::de::DeserializeOwned>(key: &str, value: toml::Value) -> Result<T> {
    value
        .try_into()
        .map_err(|error: toml::de::Error| Error::Incompatible(format!("{key}: {}", said_at("", None, error.message()))))
}

/// Gives the rows without a label one: the scheme's name, and behind a slash the options by which rows of one scheme
/// without a label differ.
///
/// # Errors
/// Two rows of one label that are not the same.
pub(super) fn with_labels(mut rows: Vec<SchemeRow>) -> Result<Vec<SchemeRow>> {
    let made: Vec<Option<String>> =
        rows.iter().map(|row| row.label.is_empty().then(|| made_label(row, &rows))).collect();
    for (row, made) in rows.iter_mut().zip(made) {
        row.label = made.unwrap_or_else(|| std::mem::take(&mut row.label));
    }
    for (index, row) in rows.iter().enumerate() {
        let same = |other: &&SchemeRow| other.label == row.label && other.settings() != row.settings();
        if let Some(earlier) = rows[..index].iter().find(same) {
            return Err(in_row(
                row.line,
                &Error::Incompatible(format!(
                    "label `{}` is that of line {}, which has other settings: their runs could not be told apart",
                    row.label, earlier.line
                )),
            ));
        }
    }
    Ok(rows)
}

fn made_label(row: &SchemeRow, rows: &[SchemeRow]) -> String {
    let alike: Vec<&SchemeRow> =
        rows.iter().filter(|other| other.label.is_empty() && other.request.scheme == row.request.scheme).collect();
    let differs = |key: &str| alike.iter().any(|other| other.given.get(key) != row.given.get(key));
    let options = row.given.iter().filter(|(key, _)| differs(key)).map(|(key, value)| format!("{key}={value}"));
    let options: Vec<String> = options.collect();
    let scheme = row.request.scheme.as_deref().unwrap_or_default();
    if options.is_empty() { scheme.to_owned() } else { format!("{scheme}/{}", options.join(" ")) }
}

fn in_row(line: usize, error: &Error) -> Error {
    Error::Incompatible(format!("[[schemes]] in line {line}: {error}"))
}

/// Options that a row may set.
fn options() -> impl Iterator<Item = &'static str> {
    RunRequest::OPTIONS.iter().map(|option| option.key).filter(|key| !SET_BY_GRID.contains(key))
}
