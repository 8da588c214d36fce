//! The table of runs, `runs.csv`: a typed row for each run, read by the list of columns by which it is written.

use crate::input::check_regular;
use rimbench_core::cosim::{Outcome, OutcomeKind};
use rimbench_core::error::{Error, Result};
use rimbench_runs::{Finding, Findings, names_of};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A run: what its plan says of it, and what was found.
#[derive(Debug, Clone)]
pub struct Run {
    /// Hash of what determines it.
    pub id: Arc<str>,
    /// Label of the scheme row.
    pub label: Arc<str>,
    /// Case and set of parameters.
    problem: [Arc<str>; 2],
    /// The scheme.
    pub scheme: Arc<str>,
    /// Macro step, s.
    pub macro_step_s: f64,
    /// Communication phase, as it is written.
    pub phase: Arc<str>,
    /// Error allowed per macro step where the step is controlled; NaN where it is not.
    pub step_tolerance: f64,
    /// Simulated time asked for, s; NaN where the table does not say.
    pub duration_s: f64,
    /// What was found.
    pub found: Findings,
    /// File of its trace; empty if none was written.
    pub trace: Arc<str>,
    /// All that its plan says, as it is written there, by [`RunTable::settings`].
    pub settings: Box<[Arc<str>]>,
}

impl Run {
    /// Returns case and set of parameters.
    pub fn problem(&self) -> [&str; 2] {
        self.problem.each_ref().map(|own| &**own)
    }
}

/// The runs of a table, in its order.
#[derive(Debug, Clone)]
pub struct RunTable {
    path: PathBuf,
    header: Vec<String>,
    settings: Vec<usize>,
    runs: Vec<Run>,
}

/// Columns without which rows are no runs.
const NEEDED: [&str; 5] = ["label", "case", "set", "macro_step_s", "outcome"];
/// Columns that are neither a setting nor found.
const ASIDE: [&str; 4] = ["run_id", "label", "wall_limit_s", "trace"];

impl RunTable {
    /// Reads the `runs.csv` in a folder of results.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub fn read_from(folder: &Path) -> Result<Self> {
        Self::read(&folder.join("runs.csv"))
    }

    /// Reads a table of runs. What it has no column of is NaN, or empty.
    ///
    /// # Errors
    /// [`Error::File`] if it is missing or not rectangular, for a column that runs need and it lacks, and with row,
    /// column and what is valid for a cell that says something else.
    pub fn read(path: &Path) -> Result<Self> {
        check_regular(path)?;
        Self::of(path, csv::Reader::from_path(path).map_err(|error| Error::file(path, error))?)
    }

    /// Reads the text of a table; `path` is what errors name.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        Self::of(path, csv::Reader::from_reader(text.as_bytes()))
    }

    fn of(path: &Path, mut reader: csv::Reader<impl Read>) -> Result<Self> {
        let wrong = |error: csv::Error| Error::file(path, error);
        let header: Vec<String> = reader.headers().map_err(wrong)?.iter().map(str::to_owned).collect();
        let place = |name: &str| header.iter().position(|own| own == name);
        if NEEDED.iter().all(|name| place(name).is_none()) {
            let needed = NEEDED.join(", ");
            return Err(Error::file(
                path,
                format!("is no table of runs: its first line has none of the columns {needed}"),
            ));
        }
        if let Some(lacking) = NEEDED.iter().find(|name| place(name).is_none()) {
            return Err(Error::file(path, Error::unknown("column", lacking, header.iter().map(String::as_str))));
        }
        let nothing = Findings { ended_at_s: f64::NAN, ..Findings::nothing(&Outcome::Completed) };
        let found = names_of(|each| nothing.clone().columns(each));
        let places: Vec<Option<usize>> = found.iter().map(|name| place(name)).collect();
        let is_setting = |name: &String| !ASIDE.contains(&name.as_str()) && !found.contains(&name.as_str());
        let settings: Vec<usize> = (0..header.len()).filter(|&at| is_setting(&header[at])).collect();
        let [id, label, case, set, scheme] = ["run_id", "label", "case", "set", "scheme"].map(place);
        let [phase, trace] = ["phase", "trace"].map(place);
        let mut runs = Vec::new();
        // What rows have in common is held once.
        let mut last: Vec<Arc<str>> = vec!["".into(); header.len()];
        for record in reader.records() {
            let record = record.map_err(wrong)?;
            let invalid = |name: &str, text: &str, valid: &str| {
                Error::file(
                    path,
                    format!("row {}: {}", runs.len() + 1, Error::invalid(name, format!("{text:?}"), valid)),
                )
            };
            for (last, cell) in last.iter_mut().zip(&record).filter(|(last, cell)| ***last != **cell) {
                *last = cell.into();
            }
            let text = |place: Option<usize>| place.map_or_else(|| "".into(), |place| Arc::clone(&last[place]));
            let number = |name: &str| match place(name).map_or("", |place| &record[place]) {
                "" => Ok(f64::NAN),
                cell => cell.parse().map_err(|_| invalid(name, cell, "a number")),
            };
            let mut run = Run {
                id: text(id),
                label: text(label),
                problem: [text(case), text(set)],
                scheme: text(scheme),
                macro_step_s: number("macro_step_s")?,
                phase: text(phase),
                step_tolerance: number("step_tolerance")?,
                duration_s: number("duration_s")?,
                found: nothing.clone(),
                trace: text(trace),
                settings: settings.iter().map(|&place| text(Some(place))).collect(),
            };
            let (mut places, mut unread) = (places.iter(), None);
            run.found.columns(&mut |name, cell| {
                if let Some(&Some(place)) = places.next() {
                    let is_read = cell.read(&record[place]);
                    unread = unread.or((!is_read).then_some((name, place)));
                }
            });
            if let Some((name, place)) = unread {
                return Err(match record[place].parse::<OutcomeKind>() {
                    Err(error) if name == "outcome" => Error::file(path, format!("row {}: {error}", runs.len() + 1)),
                    _ if name == "model_exact" => invalid(name, &record[place], "true or false"),
                    _ => invalid(name, &record[place], "a number"),
                });
            }
            runs.push(run);
        }
        Ok(RunTable { path: path.to_owned(), header, settings, runs })
    }

    /// Says where it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the number of runs.
    pub fn len(&self) -> usize {
        self.runs.len()
    }

    /// Tells whether there is no run.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Returns the runs, in the order of the table.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Names what the plan says of runs, in the order of the columns.
    pub fn settings(&self) -> impl Iterator<Item = &str> {
        self.settings.iter().map(|&column| self.header[column].as_str())
    }

    /// Returns the place of a setting among all.
    ///
    /// # Errors
    /// [`Error::File`] naming the file and its settings.
    pub fn setting(&self, name: &str) -> Result<usize> {
        let found = self.settings().position(|own| own == name);
        found.ok_or_else(|| Error::file(&self.path, Error::unknown("column", name, self.settings())))
    }

    /// Tells whether it has a column of a finding.
    pub fn has(&self, finding: Finding) -> bool {
        self.header.iter().any(|own| own == finding.name())
    }

    /// Checks that it has a column of a finding.
    ///
    /// # Errors
    /// [`Error::File`] naming the file and its columns.
    pub fn check(&self, finding: Finding) -> Result<()> {
        let names = || self.header.iter().map(String::as_str);
        let unknown = || Err(Error::file(&self.path, Error::unknown("column", finding.name(), names())));
        if self.has(finding) { Ok(()) } else { unknown() }
    }
}
