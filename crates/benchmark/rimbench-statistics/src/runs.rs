//! The table of runs: which of them, pooled how.
//!
//! ```text
//! select (label, case and set, macro step, outcome) → group (abscissa, columns) → pool → median, quartiles, range, order, interval
//! ```

use crate::pool::{Pool, by_abscissa};
use crate::table::ResultsTable;
use rimbench_core::cosim::{OutcomeClass, OutcomeKind};
use rimbench_core::error::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The word that selects all cases, or all sets of parameters.
pub const ALL: &str = "all";

/// Some runs of a table. Rows keep the numbers that they have in the table.
#[derive(Debug, Clone)]
pub struct Runs<'t> {
    table: &'t ResultsTable,
    rows: Vec<usize>,
    /// Of every row of the table.
    runs: Arc<[Run<'t>]>,
}

/// What a row of `runs.csv` says of its run. Metrics, counters and options are asked for by name, because whoever asks names them; what
/// the table does not say is empty, or NaN.
#[derive(Debug, Clone, Copy)]
pub struct Run<'t> {
    /// Hash of what determines it.
    pub id: &'t str,
    /// Label of the scheme row.
    pub label: &'t str,
    /// Case and set of parameters.
    pub problem: [&'t str; 2],
    /// The scheme.
    pub scheme: &'t str,
    /// Macro step, s.
    pub macro_step_s: f64,
    /// Communication phase, as it is written.
    pub phase: &'t str,
    /// Error allowed per macro step where the step is controlled.
    pub step_tolerance: f64,
    /// Simulated time asked for, s.
    pub duration_s: f64,
    /// How it ended.
    pub outcome: OutcomeKind,
    /// When it left the path of a completed run, s.
    pub outcome_at_s: f64,
    /// Time of the last communication point reached, s.
    pub ended_at_s: f64,
    /// Whether its model was the mechanics itself.
    pub model_exact: bool,
    /// File of its trace, if one was written.
    pub trace: &'t str,
}

impl<'t> Run<'t> {
    /// Reads all rows of a table.
    fn read(table: &'t ResultsTable) -> Result<Arc<[Self]>> {
        let [case, set, label, step, outcome] = ["case", "set", "label", "macro_step_s", "outcome"];
        [case, set, label, step, outcome].iter().try_for_each(|name| table.column(name).map(drop))?;
        let text = |name| {
            let column = table.column(name).ok();
            move |row: usize| column.map_or("", |column| table.text(row, column))
        };
        let number = |name| {
            let column = table.column(name).ok();
            move |row: usize| column.map_or(f64::NAN, |column| table.number(row, column))
        };
        let [id, label, case, set, scheme] = ["run_id", label, case, set, "scheme"].map(text);
        let [phase, outcome, model_exact, trace] = ["phase", outcome, "model_exact", "trace"].map(text);
        let [step, tolerance, duration] = [step, "step_tolerance", "duration_s"].map(number);
        let [outcome_at, ended_at] = ["outcome_at_s", "ended_at_s"].map(number);
        let run = |row: usize| {
            Ok(Run {
                id: id(row),
                label: label(row),
                problem: [case(row), set(row)],
                scheme: scheme(row),
                macro_step_s: step(row),
                phase: phase(row),
                step_tolerance: tolerance(row),
                duration_s: duration(row),
                outcome: outcome(row)
                    .parse()
                    .map_err(|error| Error::file(table.path(), format!("row {}: {error}", row + 1)))?,
                outcome_at_s: outcome_at(row),
                ended_at_s: ended_at(row),
                model_exact: model_exact(row) == "true",
                trace: trace(row),
            })
        };
        (0..table.len()).map(run).collect()
    }
}

/// What runs at one abscissa come to.
#[derive(Debug, Clone, PartialEq)]
pub struct Pooled {
    /// What the runs have in common, a macro step, say.
    pub x: f64,
    /// Values of those that completed.
    pub pool: Pool,
    /// What became of all of them.
    pub tally: Tally,
}

/// How many runs say what of their coupling.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// It holds.
    pub completed: usize,
    /// It does not hold.
    pub failed: usize,
    /// Nothing, though they were run.
    pub no_answer: usize,
    /// Nothing, because they were not run.
    pub skipped: usize,
}

impl Tally {
    /// Number of runs, skipped ones aside.
    pub fn run(&self) -> usize {
        self.completed + self.failed + self.no_answer
    }

    /// Share of the answers that are failures; 0 without an answer.
    pub fn failed_share(&self) -> f64 {
        let answers = self.completed + self.failed;
        if answers == 0 { 0.0 } else { self.failed as f64 / answers as f64 }
    }

    /// Share of the answers that are completed runs; none without an answer.
    pub fn completed_share(&self) -> Option<f64> {
        let answers = self.completed + self.failed;
        (answers > 0).then(|| self.completed as f64 / answers as f64)
    }

    /// Share of the runs, skipped ones aside, that gave no answer.
    pub fn silent_share(&self) -> f64 {
        if self.run() == 0 { 0.0 } else { self.no_answer as f64 / self.run() as f64 }
    }
}

/// What an error must exceed to say more than that it is small: the uncertainty of the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Floor {
    /// The column with the uncertainty.
    pub uncertainty: &'static str,
    /// The column of the same error in the unit of the uncertainty, where it has another.
    pub in_unit: Option<&'static str>,
}

impl<'t> Runs<'t> {
    /// Takes all runs of a table.
    ///
    /// # Errors
    /// [`Error::File`] for a column that is not there, or a word that is no outcome.
    pub fn of(table: &'t ResultsTable) -> Result<Self> {
        Ok(Runs { table, rows: (0..table.len()).collect(), runs: Run::read(table)? })
    }

    /// Returns the table.
    pub fn table(&self) -> &'t ResultsTable {
        self.table
    }

    /// Returns the rows of the table that are selected.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Takes other rows of the same table, in the order asked for.
    pub fn with_rows(&self, rows: Vec<usize>) -> Self {
        Runs { rows, runs: Arc::clone(&self.runs), ..*self }
    }

    /// Selects rows.
    pub fn select(&self, keep: impl Fn(usize) -> bool) -> Self {
        self.with_rows(self.rows.iter().copied().filter(|&row| keep(row)).collect())
    }

    /// Selects the runs of a scheme row.
    pub fn of_label(&self, label: &str) -> Self {
        self.select(|row| self.label(row) == label)
    }

    /// Selects the runs of a case with a set of parameters, each by name; [`ALL`], and none, is all of them. Where no set is the one
    /// named, all that have its words are.
    pub fn of_problem(&self, case: Option<&str>, set: Option<&str>) -> Self {
        let of_case = self.select(|row| case.is_none_or(|case| case == ALL || case == self.problem(row)[0]));
        let Some(set) = set.filter(|set| *set != ALL) else { return of_case };
        let named = of_case.select(|row| of_case.problem(row)[1] == set);
        if named.rows.is_empty() { of_case.select(|row| has_words(of_case.problem(row)[1], set)) } else { named }
    }

    /// Selects the runs that reached their end within bounds.
    pub fn completed(&self) -> Self {
        self.select(|row| self.is_completed(row))
    }

    /// Selects the runs of cases with parameters on which no run's model is the mechanics itself.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for results that do not say.
    pub fn without_exact(&self) -> Result<Self> {
        self.table.column("model_exact")?;
        let exact = self.exact_problems();
        Ok(self.select(|row| !exact.contains(&self.problem(row))))
    }

    /// Returns the cases with parameters on which the model of some run is the mechanics itself.
    pub fn exact_problems(&self) -> BTreeSet<[&'t str; 2]> {
        let rows = self.rows.iter().filter(|&&row| self.runs[row].model_exact);
        rows.map(|&row| self.problem(row)).collect()
    }

    /// Returns the cases with their sets of parameters.
    pub fn problems(&self) -> BTreeSet<[&'t str; 2]> {
        self.rows.iter().map(|&row| self.problem(row)).collect()
    }

    /// Returns the labels of the scheme rows, in the order of the table; only the wanted ones, if any are named.
    pub fn labels(&self, wanted: &[String]) -> Vec<&'t str> {
        let mut labels: Vec<&str> = Vec::new();
        for label in self.rows.iter().map(|&row| self.label(row)) {
            let is_wanted = wanted.is_empty() || wanted.iter().any(|name| name == label);
            if is_wanted && !labels.contains(&label) {
                labels.push(label);
            }
        }
        labels
    }

    /// Returns a run.
    pub fn run(&self, row: usize) -> &Run<'t> {
        &self.runs[row]
    }

    /// Returns the selected runs.
    pub fn iter(&self) -> impl Iterator<Item = &Run<'t>> {
        self.rows.iter().map(|&row| &self.runs[row])
    }

    /// Returns the label of a run.
    pub fn label(&self, row: usize) -> &'t str {
        self.runs[row].label
    }

    /// Returns case and set of a run.
    pub fn problem(&self, row: usize) -> [&'t str; 2] {
        self.runs[row].problem
    }

    /// Says what a run counts as.
    pub fn class(&self, row: usize) -> OutcomeClass {
        self.runs[row].outcome.class()
    }

    /// Tells whether a run reached its end within bounds.
    pub fn is_completed(&self, row: usize) -> bool {
        self.class(row) == OutcomeClass::Completed
    }

    /// Tells whether a run was left out for a reason.
    pub fn is_skipped(&self, row: usize) -> bool {
        !self.runs[row].outcome.was_run()
    }

    /// Counts the runs by what they say.
    pub fn tally(&self) -> Tally {
        let mut tally = Tally::default();
        for &row in &self.rows {
            *match self.class(row) {
                OutcomeClass::Completed => &mut tally.completed,
                OutcomeClass::Failed => &mut tally.failed,
                OutcomeClass::NoAnswer if self.is_skipped(row) => &mut tally.skipped,
                OutcomeClass::NoAnswer => &mut tally.no_answer,
            } += 1;
        }
        tally
    }

    /// Returns the macro step of a run, s.
    pub fn macro_step(&self, row: usize) -> f64 {
        self.runs[row].macro_step_s
    }

    /// Returns the macro step of a run, ms, without the round-off of the factor.
    pub fn macro_step_ms(&self, row: usize) -> f64 {
        (self.macro_step(row) * 1e9).round() / 1e6
    }

    /// Returns the share of the runs with an answer that completed; none if none has one.
    pub fn share_completed(&self) -> Option<f64> {
        self.tally().completed_share()
    }

    /// Groups runs with equal abscissas, by ascending abscissa; runs without one are left out.
    pub fn by(&self, x: impl Fn(usize) -> f64) -> Vec<(f64, Self)> {
        let groups = by_abscissa(self.rows.iter().map(|&row| (x(row), row)));
        groups.into_iter().map(|(x, rows)| (x, self.with_rows(rows))).collect()
    }

    /// Groups runs with equal texts in some columns, in the order of the table.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there.
    pub fn by_columns<const N: usize>(&self, names: [&str; N]) -> Result<Vec<([&'t str; N], Self)>> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.table.column(name)?;
        }
        let mut groups: Vec<([&str; N], Vec<usize>)> = Vec::new();
        let mut known = BTreeMap::new();
        for &row in &self.rows {
            let key = columns.map(|column| self.table.text(row, column));
            let index = *known.entry(key).or_insert(groups.len());
            if index == groups.len() {
                groups.push((key, Vec::new()));
            }
            groups[index].1.push(row);
        }
        Ok(groups.into_iter().map(|(key, rows)| (key, self.with_rows(rows))).collect())
    }

    /// Groups runs by what may be drawn independently: cases with what was drawn of their parameters, or phases where there is one case.
    pub fn witnesses(&self, draw_of: &dyn Fn([&'t str; 2]) -> String) -> Vec<Vec<usize>> {
        let by_phase = self.problems().len() == 1;
        let mut witnesses: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        for &row in &self.rows {
            let phase = if by_phase { self.runs[row].phase } else { "" };
            witnesses.entry((draw_of(self.problem(row)), phase)).or_default().push(row);
        }
        witnesses.into_values().collect()
    }

    /// Pools a value of the runs; NaN is none.
    pub fn pool(&self, value: impl Fn(usize) -> f64) -> Pool {
        Pool::grouped(
            self.witnesses(&|problem| problem.join(" ")).into_iter().map(|rows| rows.into_iter().map(&value).collect()),
        )
    }

    /// Pools a value of the completed runs at each abscissa.
    pub fn over(&self, x: impl Fn(usize) -> f64, value: impl Fn(usize) -> f64) -> Vec<Pooled> {
        let pooled = |(x, runs): (f64, Self)| Pooled { x, pool: runs.completed().pool(&value), tally: runs.tally() };
        self.by(x).into_iter().map(pooled).collect()
    }

    /// Returns what an error of a run must exceed to be known; NaN where nothing is known of the reference.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a metric that is not there.
    pub fn floor(&self, row: usize, metric: &str, floor: Floor) -> Result<f64> {
        let error = self.table.number(row, self.table.column(metric)?);
        let number = |name: &str| self.table.column(name).map_or(f64::NAN, |column| self.table.number(row, column));
        let uncertainty = number(floor.uncertainty);
        Ok(floor.in_unit.map_or(uncertainty, |same| uncertainty * error / number(same)))
    }

    /// Tells whether an order of convergence may be fitted to an error of a run: it is finite and above what the reference is uncertain by,
    /// which is rounding at least. Of a metric whose errors have no such uncertainty none may.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a metric that is not there.
    pub fn has_order(&self, row: usize, metric: &str, floor: Option<Floor>) -> Result<bool> {
        let Some(floor) = floor else { return Ok(false) };
        let (error, floor) = (self.table.number(row, self.table.column(metric)?), self.floor(row, metric, floor)?);
        Ok(error.is_finite() && (floor.is_nan() || error > floor))
    }
}

/// Tells whether a set of parameters has all the `key=value` of another; those of none are no words to look for.
pub fn has_words(set: &str, wanted: &str) -> bool {
    !wanted.is_empty() && wanted.split(' ').all(|word| set.split(' ').any(|own| own == word))
}
