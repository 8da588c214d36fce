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
    /// What the columns are.
    #[serde(default)]
    across: Across,
}

/// What the columns of a stability map are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Across {
    /// Macro steps; a cell is the share of the runs that completed.
    #[default]
    MacroStep,
    /// Cases with their parameters, each with a grid of macro steps of its own; a cell is how far up that grid all runs completed.
    Case,
}

impl StabilityFigure {
    /// Draws the map from `runs.csv`. Hatched: all phases complete, and the median of the metric is above the bound.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        if self.across == Across::Case {
            return self.by_case(folder, styles);
        }
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
            names: Vec::new(),
        };
        for label in runs.labels(&self.labels) {
            let rows = runs.of_label(&label);
            let cell = |&step: &f64| -> Result<Cell> {
                let here: Vec<usize> = rows.iter().copied().filter(|&row| runs.macro_step_ms(row) == step).collect();
                let value = runs.fraction_stable(&here);
                let errors = runs.over_phases(&here, |_| step, &self.metric, Part::Absolute, Bars::Range)?;
                let wrong = errors.first().is_some_and(|error| error.median > self.wrong_above);
                Ok(Cell { value, shown: None, hatched: value == Some(1.0) && wrong })
            };
            let cells = map.columns.iter().map(cell).collect::<Result<_>>()?;
            let color = runs.style(&label, styles).color;
            map.rows.push(Row { label: styles.shown_name(&label), color, cells });
        }
        map.draw_if_it_fits()
    }

    /// Draws the map with a column for each case: how far up its own grid of macro steps all runs completed, and that step in numbers.
    fn by_case(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let runs = Runs::read(folder)?.chosen(&self.only)?;
        let problems: Vec<(String, String)> =
            runs.problems()?.into_iter().map(|(case, set)| (case.to_owned(), set.to_owned())).collect();
        let several = |case: &str| problems.iter().filter(|(other, _)| other == case).count() > 1;
        let (mut parts, mut names) = (Vec::new(), Vec::new());
        for (case, set) in &problems {
            let only = Only { case: Some(case.clone()), set: Some(set.clone()) };
            let part = runs.chosen(&only)?;
            let all: Vec<usize> = (0..part.table.len()).collect();
            let steps: Vec<f64> =
                groups(&all, |row| part.macro_step_ms(row)).into_iter().map(|(step, _)| step).collect();
            let unit = if steps.last().is_some_and(|longest| *longest < 0.1) { " (µs)" } else { "" };
            let set = if several(case) && !set.is_empty() { format!(", {set}") } else { String::new() };
            names.push(format!("{case}{set}{unit}"));
            parts.push((part, steps, if unit.is_empty() { 1.0 } else { 1e3 }));
        }
        let mut map = Heatmap {
            width: self.width,
            height: self.height,
            title: self.title.clone(),
            x_label: String::new(),
            value_label: "share of its macro steps up to there".to_owned(),
            skipped_label: "not run".to_owned(),
            hatch_label: self.hatch_label.clone(),
            show_values: true,
            rows: Vec::new(),
            columns: (0..names.len()).map(|index| index as f64 + 1.0).collect(),
            names,
        };
        for label in runs.labels(&self.labels) {
            let cell = |(part, steps, factor): &(Runs, Vec<f64>, f64)| -> Result<Cell> {
                let rows = part.of_label(&label);
                let at = |step: f64| -> Vec<usize> {
                    rows.iter().copied().filter(|&row| part.macro_step_ms(row) == step).collect()
                };
                let tried: Vec<f64> =
                    steps.iter().copied().filter(|&step| part.fraction_stable(&at(step)).is_some()).collect();
                if tried.is_empty() {
                    return Ok(Cell::default());
                }
                let stable = |step: &&f64| part.fraction_stable(&at(**step)) == Some(1.0);
                let good = tried.iter().take_while(stable).count();
                let Some(&longest) = tried[..good].last() else {
                    return Ok(Cell { value: Some(0.0), shown: Some(0.0), hatched: false });
                };
                let errors = part.over_phases(&at(longest), |_| longest, &self.metric, Part::Absolute, Bars::Range)?;
                let hatched = errors.first().is_some_and(|error| error.median > self.wrong_above);
                let shown = Some((longest * factor * 1e6).round() / 1e6);
                Ok(Cell { value: Some(good as f64 / tried.len() as f64), shown, hatched })
            };
            let cells = parts.iter().map(cell).collect::<Result<_>>()?;
            let color = runs.style(&label, styles).color;
            map.rows.push(Row { label: styles.shown_name(&label), color, cells });
        }
        map.draw_if_it_fits()
    }
}
