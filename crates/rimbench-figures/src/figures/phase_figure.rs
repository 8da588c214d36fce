//! Metrics over the phase ensemble: one mark per run, phase across, one panel per metric.

use super::statistics::{Only, Runs};
use crate::chart::{Axis, Figure, Losses, Mode, Panel, Series};
use crate::drawing::Drawing;
use crate::style::Styles;
use rimbench_core::error::Result;
use serde::Deserialize;
use std::path::Path;

/// Options of a phase figure.
#[derive(Debug, Clone, Deserialize)]
pub struct PhaseFigure {
    width: f64,
    height: f64,
    /// The case shown, of an experiment with several.
    #[serde(default)]
    only: Only,
    panels: Vec<PhasePanel>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct PhasePanel {
    title: String,
    metric: String,
    label: String,
    range: Option<[f64; 2]>,
}

impl PhaseFigure {
    /// Draws the figure from `runs.csv`.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let runs = Runs::read(folder)?.only(&self.only)?;
        let phase = runs.table.column("phase")?;
        let mut figure = Figure::new(self.width, self.height).columns(self.panels.len());
        for spec in &self.panels {
            let metric = runs.table.column(&spec.metric)?;
            let mut panel = Panel::new(
                &spec.title,
                Axis::linear("phase φ of the communication points").range(0.0, 1.03),
                Axis::log10(&spec.label).within(spec.range),
            );
            for label in runs.labels(&[]) {
                let rows = runs.of_label(&label);
                runs.refuse_several(&rows, "macro_step_s", |row| format!("{} ms", runs.macro_step_ms(row)))?;
                // Of a run that broke off what there was up to then, if anything, and a sign that it did.
                let mut points: Vec<(f64, f64)> =
                    rows.iter().map(|&row| (runs.table.number(row, phase), runs.table.number(row, metric))).collect();
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                let style = runs.style(&label, styles);
                let is_lost = |row: &&usize| !runs.completed(**row) && !runs.skipped(**row);
                let mut lost: Vec<(f64, f64)> =
                    rows.iter().filter(is_lost).map(|&row| (runs.table.number(row, phase), 1.0)).collect();
                lost.sort_by(|a, b| a.0.total_cmp(&b.0));
                if !lost.is_empty() {
                    panel.losses.push(Losses { name: label.clone(), points: lost, color: style.color });
                }
                let never = runs.fraction_stable(&rows) == Some(0.0);
                let entry = if never { ": never stable" } else { "" };
                let series = Series::new(format!("{}{entry}", styles.shown_name(&label)), points, style);
                panel = panel.series(series.named(&label).mode(Mode::LineMarkers));
            }
            figure = figure.panel(panel);
        }
        figure.draw_if_it_fits()
    }
}
