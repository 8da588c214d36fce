//! A run as it is kept: one typed row, and one list of its columns by which it is written and read.
//!
//! ```text
//! RunRow ─► a line of the store          all columns
//!        ─► runs.csv                     what was found, behind what the plan says of the run
//!        ─► cost.csv, provenance.csv     what it cost, where it was made
//! ```

use super::provenance::RunOrigin;
use rimbench_cases::runs::{Columns, Costs, EvaluatedRun, Fact, Findings, RunSpec, facts_of};
use rimbench_core::cosim::{Outcome, OutcomeKind};
use std::sync::Arc;
use std::time::Duration;

/// One finished run. What a plan says of it (its label, its settings) is no part of its row.
#[derive(Debug, Clone, PartialEq)]
pub struct RunRow {
    /// [`RunSpec::id`].
    pub run_id: Arc<str>,
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

    /// Tells whether it came to an end, or was given so much time.
    pub fn had_time(&self, wall_limit: Option<Duration>) -> bool {
        self.allowed_s() >= wall_limit.map_or(f64::INFINITY, |limit| limit.as_secs_f64())
    }

    /// Whether it says at least as much as an earlier row of the same run.
    pub(crate) fn replaces(&self, earlier: &Self) -> bool {
        self.allowed_s() >= earlier.allowed_s()
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
