//! Which machine fails with which scheme at which macro step: a row for each case, a panel for each scheme, and in each
//! cell the share of the runs that fail.

use super::statistics::{CountedRuns, Only, name, rounded, unit_of};
use super::valid;
use super::{FigureOptions, Source};
use crate::chart::Absent;
use crate::drawing::{Color, Drawing};
use crate::rows::{Cell, Column, Content, Grid, Row, RowsPanel, RowsPlot};
use crate::style::Styles;
use rimbench_core::error::Result;
use rimbench_results::selection::Runs;
use serde::Deserialize;
use std::collections::BTreeSet;

/// Options of a table of failures.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FailuresFigure {
    /// Width, px; 680 px are 180 mm on paper, two columns.
    #[serde(default = "valid::width", deserialize_with = "valid::pixels")]
    width: f64,
    /// Panels per row; all panels in one row where it is not given.
    #[serde(default, deserialize_with = "valid::columns")]
    columns: Option<usize>,
    /// Scheme rows, a panel for each; all there are where none is given.
    #[serde(default)]
    labels: Vec<String>,
    /// The part of the results shown.
    #[serde(default)]
    only: Only,
}

impl FigureOptions for FailuresFigure {
    type Panel = ();

    /// Draws the tables from `runs.csv`; the case with most failures is on top.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there, and for labels that ran on
    /// other settings of a case than others.
    fn draw(&self, source: &Source, styles: &Styles) -> Result<Drawing> {
        let all = self.only.of(&Runs::of(source.runs()?))?;
        let labels = all.labels(&self.labels);
        let cases: BTreeSet<&str> = all.problems().iter().map(|[case, _]| *case).collect();
        let steps: Vec<f64> = all.by(|row| all.macro_step_ms(row)).into_iter().map(|(step, _)| step).collect();
        let (unit, factor) = unit_of(&all);
        let mut counted = CountedRuns::default();
        for label in &labels {
            let tried = all.of_label(label).select(|row| !all.is_skipped(row));
            tried.by(|row| all.macro_step_ms(row)).iter().try_for_each(|(step, runs)| counted.take(*step, runs))?;
        }
        let n = counted.in_words().unwrap_or_default();
        let cell = |runs: &Runs<'_>, step: f64| {
            let tally = runs.select(|row| runs.macro_step_ms(row) == step).tally();
            match tally.run() {
                0 => Cell::Absent(Absent::of(tally.skipped)),
                _ if tally.no_answer == tally.run() => Cell::Silent,
                _ => Cell::Failed(tally.failed_share()),
            }
        };
        let of_case = |case: &str, label: &str| -> Vec<Cell> {
            let runs = all.of_problem(Some(case), None).of_label(label);
            steps.iter().map(|&step| cell(&runs, step)).collect()
        };
        let mut rows: Vec<(f64, &str, Vec<Vec<Cell>>)> = Vec::new();
        for case in cases {
            let cells: Vec<Vec<Cell>> = labels.iter().map(|label| of_case(case, label)).collect();
            let failed = |cell: &Cell| if let Cell::Failed(share) = cell { *share } else { 0.0 };
            rows.push((cells.iter().flatten().map(failed).sum(), case, cells));
        }
        rows.sort_by(|a, b| b.0.total_cmp(&a.0));
        let column = |step: &f64| Column { label: rounded(step * factor).to_string(), value: *step };
        let panel = |(index, label): (usize, &&str)| RowsPanel {
            title: name(&all, label, styles),
            content: Content::Grid(Grid {
                quantity: format!("macro step H ({unit}), {n} each"),
                columns: steps.iter().map(column).collect(),
                cells: rows.iter().map(|(.., cells)| cells[index].clone()).collect(),
            }),
        };
        let row = |(_, case, _): &(f64, &str, _)| Row {
            label: case.replace('-', " "),
            name: (*case).to_owned(),
            color: Color::WHITE,
        };
        RowsPlot {
            width: self.width,
            columns: self.columns.unwrap_or(labels.len()),
            quantity: String::new(),
            signs: Vec::new(),
            rows: rows.iter().map(row).collect(),
            panels: labels.iter().enumerate().map(panel).collect(),
        }
        .draw_if_it_fits()
    }
}
