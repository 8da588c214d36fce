//! What accuracy costs: an error metric against wall time and against exact counters, one point per macro step, or per tolerance of
//! a step control.

use super::cost::Cost;
use super::statistics::{Bars, Only, Part, Runs, groups, over};
use crate::chart::{Axis, Figure, Mode, Panel, Series};
use crate::drawing::Drawing;
use crate::style::Styles;
use rimbench_core::error::Result;
use serde::Deserialize;
use std::path::Path;

/// Options of a work-precision figure.
#[derive(Debug, Clone, Deserialize)]
pub struct WorkPrecisionFigure {
    width: f64,
    height: f64,
    /// The error metric, a column of `runs.csv`.
    metric: String,
    /// Heading of the vertical axis.
    label: String,
    range: Option<[f64; 2]>,
    #[serde(default)]
    labels: Vec<String>,
    /// Panels per row; all in one if absent.
    columns: Option<usize>,
    panels: Vec<WorkPanel>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct WorkPanel {
    title: String,
    /// Cost: a column of `cost.csv`, or counters of `runs.csv` joined by `+`.
    cost: String,
    /// Heading of the horizontal axis.
    label: String,
    range: Option<[f64; 2]>,
    /// The case shown, of an experiment with several.
    #[serde(default)]
    only: Only,
}

impl WorkPrecisionFigure {
    /// Draws the figure from `runs.csv` and `cost.csv`. A point is the median over the phases of one macro step and one
    /// tolerance; runs that did not complete are left out.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there, or a run without a row of cost.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let all = Runs::read(folder)?;
        let mut figure = Figure::new(self.width, self.height).columns(self.columns.unwrap_or(self.panels.len()));
        for spec in &self.panels {
            let runs = all.only(&spec.only)?;
            let work = Cost::read(folder, &runs)?.of_runs(&spec.cost, &runs)?;
            let (x, y) = (Axis::log10(&spec.label).within(spec.range), Axis::log10(&self.label).within(self.range));
            let mut panel = Panel::new(&spec.title, x, y);
            let column = runs.table.column("step_tolerance").ok();
            let of_row = |row: usize| column.map(|column| runs.table.number(row, column));
            let tolerance = |row: usize| of_row(row).filter(|tolerance| tolerance.is_finite()).unwrap_or(0.0);
            let longest = (0..runs.table.len()).map(|row| runs.macro_step_ms(row)).fold(0.0, f64::max);
            for label in runs.labels(&self.labels) {
                let (mut points, mut steps, mut tags): (Vec<(f64, f64)>, Vec<String>, Vec<String>) = Default::default();
                let rows = runs.of_label(&label);
                let by_step = groups(&rows, |row| runs.macro_step_ms(row)).into_iter();
                let by_tolerance = by_step
                    .flat_map(|(step, rows)| groups(&rows, tolerance).into_iter().map(move |(_, rows)| (step, rows)));
                for (step, rows) in by_tolerance {
                    let rows_of_point = rows[0];
                    let completed: Vec<usize> = rows.into_iter().filter(|&row| runs.completed(row)).collect();
                    let work = over(step, completed.iter().map(|&row| work[row]).collect());
                    let error = runs.over_phases(&completed, |_| step, &self.metric, Part::Absolute, Bars::Range)?;
                    if let Some((work, error)) = work.zip(error.first()) {
                        points.push((work.median, error.median));
                        let (unit, factor) = if longest < 0.1 { ("µs", 1e3) } else { ("ms", 1.0) };
                        let step = (step * factor * 1e6).round() / 1e6;
                        steps.push(format!("H = {step} {unit}"));
                        // Of several points at one macro step the tolerance tells them apart, unless it is so large that it never counts.
                        let controlled = tolerance(rows_of_point);
                        tags.push(if (1e-12..1e6).contains(&controlled) {
                            format!("{controlled:e}")
                        } else {
                            format!("{step}")
                        });
                    }
                }
                // What did not complete has no cost at which to mark it.
                let lost = match all.fraction_stable(&all.of_label(&label)) {
                    None => ": not run",
                    Some(0.0) => ": all runs diverged",
                    Some(share) if share < 1.0 => ": some runs diverged",
                    Some(_) => "",
                };
                let entry = format!("{}{lost}", styles.shown_name(&label));
                let series = Series::new(entry, points, runs.style(&label, styles)).mode(Mode::LineMarkers);
                panel = panel.series(series.named(&label).notes(steps).tags(tags));
            }
            figure = figure.panel(panel);
        }
        figure.draw_if_it_fits()
    }
}
