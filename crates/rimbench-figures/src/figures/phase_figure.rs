//! Metrics over the phase ensemble: one mark per run, phase across, one panel per metric.

use super::keys::*;
use super::statistics::{ONLY, Only, read_runs, refuse_several, style};
use crate::chart::{Axis, Figure, Losses, Mode, Panel, Series};
use crate::drawing::Drawing;
use crate::style::Styles;
use rimbench_core::error::Result;
use rimbench_statistics::Runs;
use std::path::Path;

keys! {
    /// Options of a phase figure.
    pub struct PhaseFigure {
        width: f64 = WIDTH,
        height: f64 = HEIGHT,
        only: Only = ONLY,
        panels: Vec<PhasePanel> = panels(PhasePanel::KEYS),
    }
}

keys! {
    struct PhasePanel {
        title: String = TITLE,
        metric: String = key(Takes::Text, Needed, "a column of runs.csv"),
        label: String = METRIC_LABEL,
        range: Option<[f64; 2]> = RANGE,
    }
}

impl PhaseFigure {
    /// Draws the figure from `runs.csv`.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let table = read_runs(folder)?;
        let runs = self.only.one_of(&Runs::of(&table)?)?;
        let phase = table.column("phase")?;
        let mut figure = Figure::new(self.width, self.height).columns(self.panels.len());
        for spec in &self.panels {
            let metric = table.column(&spec.metric)?;
            let mut panel = Panel::new(
                &spec.title,
                Axis::linear("phase φ of the communication points").range(0.0, 1.03),
                Axis::log10(&spec.label).within(spec.range),
            );
            for label in runs.labels(&[]) {
                let own = runs.of_label(label);
                let rows = own.rows();
                refuse_several(&own, "macro_step_s", |row| format!("{} ms", runs.macro_step_ms(row)))?;
                // Of a run that broke off what there was up to then, if anything, and a sign that it did.
                let mut points: Vec<(f64, f64)> =
                    rows.iter().map(|&row| (table.number(row, phase), table.number(row, metric))).collect();
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                let style = style(&runs, label, styles);
                let is_lost = |row: &&usize| !runs.is_completed(**row) && !runs.is_skipped(**row);
                let mut lost: Vec<(f64, f64)> =
                    rows.iter().filter(is_lost).map(|&row| (table.number(row, phase), 1.0)).collect();
                lost.sort_by(|a, b| a.0.total_cmp(&b.0));
                if !lost.is_empty() {
                    panel.losses.push(Losses { name: label.to_owned(), points: lost, color: style.color });
                }
                let never = own.share_completed() == Some(0.0);
                let entry = if never { ": never stable" } else { "" };
                let series = Series::new(format!("{}{entry}", styles.shown_name(label)), points, style);
                panel = panel.series(series.named(label).mode(Mode::LineMarkers));
            }
            figure = figure.panel(panel);
        }
        figure.draw_if_it_fits()
    }
}
