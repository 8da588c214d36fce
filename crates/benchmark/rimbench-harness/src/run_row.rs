//! A run as it is kept: one typed row, and one list of its columns by which it is written and read.
//!
//! ```text
//! RunRow ─► a line of the store          all columns
//!        ─► runs.csv                     what was found, behind what the plan says of the run
//!        ─► cost.csv, provenance.csv     what it cost, where it was made
//! ```

use super::provenance::RunOrigin;
use rimbench_core::cosim::{Outcome, OutcomeKind};
use rimbench_runs::{Cell, Columns, Costs, EvaluatedRun, Fact, FactValue, Findings, RunSpec, facts_of};
use std::sync::Arc;
use std::time::Duration;

/// One finished run. What a plan says of it (its label, its settings) is no part of its row.
#[derive(Debug, Clone, PartialEq)]
pub struct RunRow {
    /// [`RunSpec::id`].
    pub run_id: Arc<str>,
    /// Further requests.
    pub asked: Asked,
    /// Wall time that it was given and that was not enough, s; none of a run that came to an end.
    pub wall_limit_s: Option<f64>,
    /// The trace that was written with it.
    pub trace: Option<TraceMark>,
    /// What was found.
    pub found: Findings,
    /// What it cost.
    pub costs: Costs,
    /// Where it was made.
    pub origin: RunOrigin,
}

/// Requests of a run beyond its settings: each fills columns and is no part of the run's id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Asked {
    /// The growth that its linearised coupling predicts.
    pub growth: bool,
    /// Its error divided into that of the coupling and that of the mechanics' own step.
    pub division: bool,
}

impl Asked {
    /// What is asked of a run.
    pub(crate) fn of(spec: &RunSpec) -> Self {
        Asked { growth: spec.predict_growth, division: spec.divide_error }
    }

    /// Whether it is all that is `wanted`.
    fn covers(self, wanted: Self) -> bool {
        (self.growth || !wanted.growth) && (self.division || !wanted.division)
    }
}

impl Cell for Asked {
    fn value(&self) -> Option<FactValue> {
        let asked = [("growth", self.growth), ("division", self.division)];
        let words: Vec<&str> = asked.into_iter().filter_map(|(word, asked)| asked.then_some(word)).collect();
        (!words.is_empty()).then(|| FactValue::Text(words.join(" ")))
    }

    fn read(&mut self, text: &str) -> bool {
        *self = Asked::default();
        text.split_whitespace().all(|word| {
            self.growth |= word == "growth";
            self.division |= word == "division";
            ["growth", "division"].contains(&word)
        })
    }
}

/// By what a trace is known again.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TraceMark {
    /// Distance of its rows, s.
    pub every_s: f64,
    /// SHA-256 of the file.
    pub sha256: String,
}

impl RunRow {
    /// Makes the row of a run of which nothing is known.
    pub fn blank(run_id: &str) -> Self {
        RunRow {
            run_id: run_id.into(),
            asked: Asked::default(),
            wall_limit_s: None,
            trace: None,
            found: Findings::nothing(&Outcome::Completed),
            costs: Costs::default(),
            origin: RunOrigin::default(),
        }
    }

    /// The row of a run that has just ended.
    pub(crate) fn of(
        run_id: &str,
        spec: &RunSpec,
        run: &EvaluatedRun,
        origin: RunOrigin,
        trace: Option<TraceMark>,
    ) -> Self {
        let limit = spec.wall_limit.filter(|_| run.outcome.kind() == OutcomeKind::Timeout);
        RunRow {
            run_id: run_id.into(),
            asked: Asked::of(spec),
            wall_limit_s: limit.map(|limit| limit.as_secs_f64()),
            trace,
            found: run.found.clone(),
            costs: run.costs,
            origin,
        }
    }

    /// Goes through all columns of a line of the store.
    pub(crate) fn columns(&mut self, each: Columns<'_>) {
        each("run_id", &mut self.run_id);
        each("asked", &mut self.asked);
        each("wall_limit_s", &mut self.wall_limit_s);
        let mark = self.trace.take();
        let (mut every_s, mut sha256) = (mark.as_ref().map(|mark| mark.every_s), mark.map(|mark| mark.sha256));
        each("trace_every_s", &mut every_s);
        each("trace_sha256", &mut sha256);
        self.trace = every_s.zip(sha256).map(|(every_s, sha256)| TraceMark { every_s, sha256 });
        self.found.columns(each);
        self.costs.columns(each);
        self.origin.columns(each);
    }

    /// Tells whether a run need not be computed again: this row came to its end or was given as much time as that may
    /// take, and holds what is asked of it besides.
    pub fn answers(&self, asked: Asked, wall_limit: Option<Duration>) -> bool {
        let wanted_s = wall_limit.map_or(f64::INFINITY, |limit| limit.as_secs_f64());
        self.allowed_s() >= wanted_s && self.asked.covers(asked)
    }

    /// Whether it says at least as much as an earlier row of the same run of which the same was asked.
    pub(crate) fn replaces(&self, earlier: &Self) -> bool {
        let says = |row: &Self| (!row.is_defect(), row.allowed_s());
        says(self) >= says(earlier)
    }

    /// Whether it ended by a defect of the program: of what was run it says nothing, and another build may say
    /// something.
    pub(crate) fn is_defect(&self) -> bool {
        self.found.outcome == OutcomeKind::Panicked
    }

    /// Wall time that it was given before it was ended, s; infinite if it came to an end.
    fn allowed_s(&self) -> f64 {
        self.wall_limit_s.unwrap_or(f64::INFINITY)
    }
}

/// Writes columns as one row of a table, without its line end.
pub(crate) fn line_of(columns: impl FnOnce(Columns<'_>)) -> String {
    row(&facts_of(columns).iter().map(Fact::cell).collect::<Vec<_>>())
}

/// One CSV row without its line end. Control characters become spaces: a row is one line.
pub(crate) fn row<T: AsRef<str>>(cells: &[T]) -> String {
    // Most have nothing that would have to be quoted.
    let plain = |cell: &T| !cell.as_ref().contains(|c: char| c.is_control() || c == ',' || c == '"');
    if cells.len() > 1 && cells.iter().all(plain) {
        let mut row = String::with_capacity(cells.iter().map(|cell| cell.as_ref().len() + 1).sum());
        for (index, cell) in cells.iter().enumerate() {
            row += if index == 0 { "" } else { "," };
            row += cell.as_ref();
        }
        return row;
    }
    let mut writer = csv::WriterBuilder::new().from_writer(Vec::new());
    let cells = cells.iter().map(|cell| cell.as_ref().replace(char::is_control, " "));
    // Writing to memory cannot fail.
    let bytes = writer.write_record(cells).ok().and_then(|()| writer.into_inner().ok()).unwrap_or_default();
    String::from_utf8_lossy(&bytes).trim_end_matches('\n').to_owned()
}
