//! How long single macro steps take on this machine, against the time they stand for.

use super::cost::Cost;
use super::statistics::{Only, OverPhases, Runs, groups, over};
use super::sweep_figure::with_range;
use crate::chart::{Axis, Figure, Panel, Series};
use crate::drawing::Drawing;
use crate::style::Styles;
use rimbench_core::error::Result;
use serde::Deserialize;
use std::path::Path;

/// Columns of `cost.csv` with the headings of their panels.
const PERCENTILES: [(&str, &str); 3] = [
    ("latency_p50_s", "(a) median macro step"),
    ("latency_p99_s", "(b) 99th percentile"),
    ("latency_max_s", "(c) slowest macro step"),
];

/// Options of a latency figure.
#[derive(Debug, Clone, Deserialize)]
pub struct LatencyFigure {
    width: f64,
    height: f64,
    /// Interval of the vertical axes, µs.
    range_us: Option<[f64; 2]>,
    #[serde(default)]
    labels: Vec<String>,
    /// The case shown, of an experiment with several.
    #[serde(default)]
    only: Only,
}

impl LatencyFigure {
    /// Draws the figure from `runs.csv` and `cost.csv`: median over phases of each percentile, bars from the best to
    /// the worst phase, and the line above which a step misses its deadline. Runs that did not complete are marked.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) naming the column that `cost.csv` lacks.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let runs = Runs::read(folder)?.only(&self.only)?;
        let cost = Cost::read(folder, &runs)?;
        let mut figure = Figure::new(self.width, self.height).columns(PERCENTILES.len());
        for (column, title) in PERCENTILES {
            let latency = cost.column(column)?;
            let y = Axis::log10("wall time per macro step (µs)").within(self.range_us);
            let mut panel = Panel::new(title, Axis::log10("macro step H (ms)"), y);
            let mut steps_ms: Vec<f64> = Vec::new();
            for label in runs.labels(&self.labels) {
                let of_step = |(step, rows): (f64, Vec<usize>)| {
                    let lost = runs.fraction_stable(&rows).map_or(0.0, |share| 1.0 - share);
                    let completed = rows.iter().filter(|&&row| runs.completed(row));
                    let nothing = OverPhases { x: step, median: f64::NAN, least: f64::NAN, most: f64::NAN, lost };
                    let known = over(step, completed.map(|&row| latency[row] * 1e6).collect());
                    known.map_or(nothing, |point| OverPhases { lost, ..point })
                };
                let by_step = groups(&runs.of_label(&label), |row| runs.macro_step_ms(row));
                let points: Vec<OverPhases> = by_step.into_iter().map(of_step).collect();
                steps_ms.extend(points.iter().map(|point| point.x));
                panel = with_range(panel, &points, &label, &styles.shown_name(&label), runs.style(&label, styles));
            }
            steps_ms.sort_by(f64::total_cmp);
            steps_ms.dedup();
            let deadline = steps_ms.into_iter().map(|step| (step, step * 1e3)).collect();
            figure =
                figure.panel(panel.series(Series::new("deadline: real time", deadline, styles.of_label("reference"))));
        }
        figure.draw_if_it_fits()
    }
}
