//! Which scheme is stable at which macro step: fraction of phases that complete, hatched where stable but wrong.

use super::statistics::{Bars, Only, Part, Runs, groups};
use crate::drawing::Drawing;
use crate::heatmap::{Cell, Heatmap, Row};
use crate::style::Styles;
use rimbench_core::error::Result;
use serde::Deserialize;
use std::path::Path;

/// Options of a stability map.
#[derive(Debug, Clone, Deserialize)]
pub struct StabilityFigure {
    width: f64,
    height: f64,
    title: String,
    /// The metric that says whether a stable run is right.
    metric: String,
    /// A cell is wrong if the median of its metric is above this.
    wrong_above: f64,
    /// What hatching means, in words.
    hatch_label: String,
    /// The case shown, of an experiment with several.
    #[serde(default)]
    only: Only,
    #[serde(default)]
    labels: Vec<String>,
}

impl StabilityFigure {
    /// Draws the map from `runs.csv`. Hatched: all phases complete, and the median of the metric is above the bound.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let runs = Runs::read(folder)?.only(&self.only)?;
        let all: Vec<usize> = (0..runs.table.len()).collect();
        let columns: Vec<f64> = groups(&all, |row| runs.macro_step_ms(row)).into_iter().map(|(step, _)| step).collect();
        let mut map = Heatmap {
            width: self.width,
            height: self.height,
            title: self.title.clone(),
            x_label: "macro step H (ms)".to_owned(),
            value_label: "fraction of phases stable".to_owned(),
            skipped_label: "not run".to_owned(),
            hatch_label: self.hatch_label.clone(),
            show_values: true,
            rows: Vec::new(),
            columns,
        };
        for label in runs.labels(&self.labels) {
            let rows = runs.of_label(&label);
            let cell = |&step: &f64| -> Result<Cell> {
                let here: Vec<usize> = rows.iter().copied().filter(|&row| runs.macro_step_ms(row) == step).collect();
                let value = runs.fraction_stable(&here);
                let errors = runs.over_phases(&here, |_| step, &self.metric, Part::Absolute, Bars::Range)?;
                let wrong = errors.first().is_some_and(|error| error.median > self.wrong_above);
                Ok(Cell { value, hatched: value == Some(1.0) && wrong })
            };
            let cells = map.columns.iter().map(cell).collect::<Result<_>>()?;
            let color = styles.of_label(&label).color;
            map.rows.push(Row { label: styles.shown_name(&label), color, cells });
        }
        map.draw_if_it_fits()
    }
}
