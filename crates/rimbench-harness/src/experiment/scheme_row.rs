//! One `[[schemes]]` of an experiment file: a label, macro steps of its own, and any option that a run has.

use crate::grid::{MacroSteps, scalar_text};
use rimbench_cases::runs::RunRequest;
use rimbench_core::error::{Error, Result};
use std::collections::BTreeMap;
use toml::Spanned;

/// As it stands in the file, with its place.
pub(super) type RawRow = Spanned<BTreeMap<String, toml::Value>>;

/// Keys of a row besides the options of a run.
const OWN_KEYS: [&str; 2] = ["label", "macro_steps_s"];

/// Options of a run that a row does not set: the grid does.
const SET_BY_GRID: [&str; 3] = ["case", "macro_step_s", "phase"];

/// One row of schemes.
#[derive(Debug, Clone)]
pub(super) struct SchemeRow {
    /// Line of the file in which it begins, from 1.
    line: usize,
    /// The scheme's name unless the file gives another.
    pub(super) label: String,
    /// Instead of those of the case or the experiment.
    pub(super) macro_steps_s: Option<MacroSteps>,
    /// Everything else.
    pub(super) request: RunRequest,
}

impl SchemeRow {
    /// Reads a row; `source` is the text of the file.
    ///
    /// # Errors
    /// Unknown keys, and values that cannot be read.
    pub(super) fn read(row: RawRow, source: &str) -> Result<Self> {
        let line = 1 + source[..row.span().start].matches('\n').count();
        Self::read_keys(row.into_inner(), line).map_err(|error| in_row(line, &error))
    }

    fn read_keys(keys: BTreeMap<String, toml::Value>, line: usize) -> Result<Self> {
        let mut row = SchemeRow { line, label: String::new(), macro_steps_s: None, request: RunRequest::default() };
        for (key, value) in keys {
            match key.as_str() {
                "label" => row.label = scalar_text(&key, &value)?,
                "macro_steps_s" => {
                    let steps = value.try_into().map_err(|error| Error::Incompatible(format!("{key}: {error}")))?;
                    row.macro_steps_s = Some(steps);
                }
                option => {
                    if !options().any(|known| known == option) {
                        return Err(Error::unknown(
                            "key of [[schemes]]",
                            option,
                            OWN_KEYS.into_iter().chain(options()),
                        ));
                    }
                    row.request.put(option, &scalar_text(option, &value)?)?;
                }
            }
        }
        let Some(scheme) = &row.request.scheme else {
            return Err(Error::invalid("scheme", "nothing", "the name of a scheme"));
        };
        if row.label.is_empty() {
            row.label.clone_from(scheme);
        }
        if row.label.is_empty() || row.label.contains(char::is_control) {
            return Err(Error::invalid("label", format!("{:?}", row.label), "text without tabs or line ends"));
        }
        Ok(row)
    }

    /// An error about this row, with its place.
    pub(super) fn place(&self, error: &Error) -> Error {
        in_row(self.line, error)
    }
}

fn in_row(line: usize, error: &Error) -> Error {
    Error::Incompatible(format!("[[schemes]] in line {line}: {error}"))
}

/// Options that a row may set.
fn options() -> impl Iterator<Item = &'static str> {
    RunRequest::OPTIONS.iter().map(|option| option.key).filter(|key| !SET_BY_GRID.contains(key))
}
