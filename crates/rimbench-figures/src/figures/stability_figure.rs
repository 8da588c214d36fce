//! Which scheme is stable at which macro step: fraction of phases that complete, hatched where stable but wrong.

use super::keys::*;
use super::statistics::{Bars, ONLY, Only, Part, over_phases, read_runs, style};
use crate::drawing::Drawing;
use crate::heatmap::{Cell, Heatmap, Row};
use crate::style::Styles;
use rimbench_core::error::Result;
use rimbench_statistics::Runs;
use serde::Deserialize;
use std::path::Path;

keys! {
    /// Options of a stability map.
    pub struct StabilityFigure {
        width: f64 = WIDTH,
        height: f64 = HEIGHT,
        title: String = TITLE,
        metric: String = key(
            Takes::Text,
            Usual("\"force_error_rms_of_peak\""),
            "what says whether a stable run is right"
        ),
        wrong_above: f64 =
            key(Takes::Positive, Usual("0.1"), "a cell whose median metric is above this is hatched"),
        hatch_label: String =
            key(Takes::Text, Usual("\"stable, but wrong\""), "what hatching means, in words"),
        across: Across = key(
            Takes::Choice(&["macro-step", "case"]),
            Usual("\"macro-step\""),
            "columns: macro steps, or cases, each with its own macro steps, of which a cell has the largest up to which all runs completed"
        ),
        only: Only = ONLY,
        labels: Vec<String> = LABELS,
    }
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
        let table = read_runs(folder)?;
        let runs = self.only.one_of(&Runs::of(&table)?)?;
        let columns: Vec<f64> = runs.by(|row| runs.macro_step_ms(row)).into_iter().map(|(step, _)| step).collect();
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
            let rows = runs.of_label(label);
            let cell = |&step: &f64| -> Result<Cell> {
                let here = rows.select(|row| runs.macro_step_ms(row) == step);
                let value = here.share_completed();
                let errors = over_phases(&here, |_| step, &self.metric, Part::Absolute, Bars::Range)?;
                let wrong = errors.first().is_some_and(|error| error.median > self.wrong_above);
                Ok(Cell { value, shown: None, hatched: value == Some(1.0) && wrong })
            };
            let cells = map.columns.iter().map(cell).collect::<Result<_>>()?;
            let color = style(&runs, label, styles).color;
            map.rows.push(Row { label: styles.shown_name(label), color, cells });
        }
        map.draw_if_it_fits()
    }

    /// Draws the map with a column for each case: how far up its own grid of macro steps all runs completed, and that step in numbers.
    fn by_case(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let table = read_runs(folder)?;
        let runs = self.only.of(&Runs::of(&table)?)?;
        let problems = runs.problems();
        let several = |case: &str| problems.iter().filter(|[other, _]| *other == case).count() > 1;
        let (mut parts, mut names) = (Vec::new(), Vec::new());
        for &[case, set] in &problems {
            let part = runs.select(|row| runs.problem(row) == [case, set]);
            let steps: Vec<f64> = part.by(|row| part.macro_step_ms(row)).into_iter().map(|(step, _)| step).collect();
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
            let cell = |(part, steps, factor): &(Runs<'_>, Vec<f64>, f64)| -> Result<Cell> {
                let rows = part.of_label(label);
                let at = |step: f64| rows.select(|row| part.macro_step_ms(row) == step);
                let tried: Vec<f64> =
                    steps.iter().copied().filter(|&step| at(step).share_completed().is_some()).collect();
                if tried.is_empty() {
                    return Ok(Cell::default());
                }
                let stable = |step: &&f64| at(**step).share_completed() == Some(1.0);
                let good = tried.iter().take_while(stable).count();
                let Some(&longest) = tried[..good].last() else {
                    return Ok(Cell { value: Some(0.0), shown: Some(0.0), hatched: false });
                };
                let errors = over_phases(&at(longest), |_| longest, &self.metric, Part::Absolute, Bars::Range)?;
                let hatched = errors.first().is_some_and(|error| error.median > self.wrong_above);
                let shown = Some((longest * factor * 1e6).round() / 1e6);
                Ok(Cell { value: Some(good as f64 / tried.len() as f64), shown, hatched })
            };
            let cells = parts.iter().map(cell).collect::<Result<_>>()?;
            let color = style(&runs, label, styles).color;
            map.rows.push(Row { label: styles.shown_name(label), color, cells });
        }
        map.draw_if_it_fits()
    }
}
