//! A metric against the macro step: median over phases, with the range from best to worst phase.

use crate::error::Result;
use crate::metrics::order_of_convergence;
use crate::report::chart::{Axis, Figure, Guide, Mode, Panel, Series};
use crate::report::drawing::Drawing;
use crate::report::style::{SeriesStyle, style_of};
use crate::results_table::ResultsTable;
use serde::Deserialize;
use std::path::Path;

/// Options of a sweep figure.
#[derive(Debug, Clone, Deserialize)]
pub struct SweepFigure {
    width: f64,
    height: f64,
    panels: Vec<SweepPanel>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepPanel {
    title: String,
    metric: String,
    label: String,
    range: [f64; 2],
    /// Column with the reference's own uncertainty, drawn as a floor.
    floor: Option<String>,
    /// Slope triangle: order, and its first corner (H in ms, value).
    slope: Option<(f64, [f64; 2])>,
}

impl SweepFigure {
    /// Draws the figure from `runs.csv`. Runs that did not complete are left out of the medians.
    ///
    /// # Errors
    /// [`Error::File`](crate::error::Error::File) for a column that is not there.
    pub(super) fn draw(&self, folder: &Path) -> Result<Drawing> {
        let runs = ResultsTable::read(&folder.join("runs.csv"))?;
        let labels = labels(&runs)?;
        let mut figure = Figure::new(self.width, self.height).columns(self.panels.len());
        for spec in &self.panels {
            let mut panel = Panel::new(
                &spec.title,
                Axis::log10("macro step H (ms)"),
                Axis::log10(&spec.label).range(spec.range[0], spec.range[1]),
            );
            for label in &labels {
                let points = medians(&runs, label, &spec.metric)?;
                let style = style_of(label);
                let medians: Vec<(f64, f64)> = points.iter().map(|point| (point.step_ms, point.median)).collect();
                let order =
                    order_of_convergence(&medians).map_or_else(String::new, |order| format!(", order {order:.2}"));
                for point in &points {
                    let thin = SeriesStyle { width: 0.8, dash: &[], ..style };
                    let bar = vec![(point.step_ms, point.least), (point.step_ms, point.most)];
                    panel = panel.series(Series::new("", bar, thin));
                }
                let entry = if self.panels.len() == 1 { format!("{label}{order}") } else { label.clone() };
                panel = panel.series(Series::new(entry, medians, style).mode(Mode::LineMarkers));
            }
            if let Some(floor) = &spec.floor {
                let uncertainty = runs.number(0, runs.column(floor)?);
                panel = panel.guide(Guide::Horizontal { y: uncertainty, label: "uncertainty of the reference".into() });
            }
            if let Some((order, [x, y])) = spec.slope {
                panel = panel.guide(Guide::Slope { order, from: (x, y), to_x: 2.0 * x });
            }
            figure = figure.panel(panel);
        }
        Ok(figure.draw())
    }
}

/// Labels of the scheme rows, in the order of the experiment.
pub(super) fn labels(runs: &ResultsTable) -> Result<Vec<String>> {
    let column = runs.column("label")?;
    let mut labels: Vec<String> = Vec::new();
    for row in 0..runs.len() {
        if !labels.iter().any(|label| label == runs.text(row, column)) {
            labels.push(runs.text(row, column).to_owned());
        }
    }
    Ok(labels)
}

/// A metric over the phases at one macro step.
struct OverPhases {
    step_ms: f64,
    median: f64,
    least: f64,
    most: f64,
}

fn medians(runs: &ResultsTable, label: &str, metric: &str) -> Result<Vec<OverPhases>> {
    let (step, value, outcome) = (runs.column("macro_step_s")?, runs.column(metric)?, runs.column("outcome")?);
    let rows = runs.rows_where(runs.column("label")?, label);
    let mut steps: Vec<f64> = rows.iter().map(|&row| runs.number(row, step)).collect();
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    let mut points = Vec::new();
    for wanted in steps {
        let at_step = rows.iter().filter(|&&row| runs.number(row, step) == wanted);
        let completed = at_step.filter(|&&row| runs.text(row, outcome) == "completed");
        let mut values: Vec<f64> = completed.map(|&row| runs.number(row, value)).filter(|x| x.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        if let (Some(&least), Some(&most)) = (values.first(), values.last()) {
            let n = values.len();
            let median = 0.5 * (values[(n - 1) / 2] + values[n / 2]);
            points.push(OverPhases { step_ms: wanted * 1e3, median, least, most });
        }
    }
    Ok(points)
}
