//! What accuracy costs: an error metric against wall time and against exact counters, one point per macro step, or per tolerance of
//! a step control.

use super::cost::Cost;
use super::keys::*;
use super::statistics::{Bars, ONLY, Only, name, over_phases, read_runs, rounded, style, unit_of};
use crate::chart::{Axis, Figure, LegendPlace, Mode, Panel, Series};
use crate::drawing::Drawing;
use crate::style::Styles;
use rimbench_core::error::Result;
use rimbench_statistics::Runs;
use std::path::Path;

keys! {
    /// Options of a work-precision figure.
    pub struct WorkPrecisionFigure {
        width: f64 = WIDTH,
        height: f64 = HEIGHT,
        metric: String = key(Takes::Text, Needed, "the error, a column of runs.csv"),
        label: String = METRIC_LABEL,
        range: Option<[f64; 2]> = RANGE,
        labels: Vec<String> = LABELS,
        columns: Option<usize> = COLUMNS,
        panels: Vec<WorkPanel> = panels(WorkPanel::KEYS),
    }
}

keys! {
    struct WorkPanel {
        title: String = TITLE,
        cost: String =
            key(Takes::Text, Needed, "a column of cost.csv, or counters of runs.csv joined by `+`"),
        label: String = key(Takes::Text, Like("cost"), "heading of the horizontal axis"),
        range: Option<[f64; 2]> = key(Takes::PositiveInterval, AUTOMATIC, "horizontal axis, logarithmic"),
        only: Only = ONLY,
    }
}

impl WorkPrecisionFigure {
    /// Draws the figure from `runs.csv` and `cost.csv`. A point is the median over the phases of one macro step and one
    /// tolerance; runs that did not complete are left out.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there, or a run without a row of cost.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let table = read_runs(folder)?;
        let all = Runs::of(&table)?;
        let cost = Cost::read(folder, &table)?;
        let column = table.column("step_tolerance").ok();
        let of_row = |row: usize| column.map(|column| table.number(row, column));
        let tolerance = |row: usize| of_row(row).filter(|tolerance| tolerance.is_finite()).unwrap_or(0.0);
        let mut figure = Figure::new(self.width, self.height)
            .columns(self.columns.unwrap_or(self.panels.len()))
            .legend(LegendPlace::Lines);
        for spec in &self.panels {
            let runs = spec.only.one_of(&all)?;
            let work = cost.of_runs(&spec.cost, &table)?;
            let (x, y) = (Axis::log10(&spec.label).within(spec.range), Axis::log10(&self.label).within(self.range));
            let mut panel = Panel::new(&spec.title, x, y);
            let (unit, factor) = unit_of(&runs);
            for label in runs.labels(&self.labels) {
                let (mut points, mut steps, mut tags): (Vec<(f64, f64)>, Vec<String>, Vec<String>) = Default::default();
                let by_step = runs.of_label(label).by(|row| runs.macro_step_ms(row)).into_iter();
                let by_tolerance = by_step.flat_map(|(step, runs)| {
                    runs.by(tolerance).into_iter().map(move |(tolerance, runs)| (step, tolerance, runs.completed()))
                });
                for (step, controlled, completed) in by_tolerance {
                    let finite = |row: usize| if work[row].is_finite() { work[row] } else { f64::NAN };
                    let error = over_phases(&completed, |_| step, &self.metric, f64::abs, Bars::Range)?;
                    if let Some((work, error)) = completed.pool(finite).median().zip(error.first()) {
                        points.push((work, error.median));
                        let step = rounded(step * factor);
                        steps.push(format!("H = {step} {unit}"));
                        // Of several points at one macro step the tolerance tells them apart, unless it is so large that it never counts.
                        tags.push(if (1e-12..1e6).contains(&controlled) {
                            format!("{controlled:e}")
                        } else {
                            format!("{step}")
                        });
                    }
                }
                // What did not complete has no cost at which to mark it.
                let lost = match all.of_label(label).share_completed() {
                    None if all.of_label(label).tally().run() > 0 => ": no answer",
                    None => ": not run",
                    Some(0.0) => ": all runs diverged",
                    Some(share) if share < 1.0 => ": some runs diverged",
                    Some(_) => "",
                };
                let entry = format!("{}{lost}", name(&runs, label, styles));
                let series = Series::new(entry, points, style(&runs, label, styles)).mode(Mode::LineMarkers);
                panel = panel.series(Series { name: label.to_owned(), notes: steps, tags, ..series });
            }
            figure = figure.panel(panel);
        }
        figure.draw_if_it_fits()
    }
}
