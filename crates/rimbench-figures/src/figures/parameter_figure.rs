//! A metric against a parameter of the case, or against the contact margin: median over phases, with the range from best to worst
//! phase.

use super::statistics::{Bars, FRACTION_STABLE, Only, OverPhases, Part, Runs, groups};
use super::sweep_figure::with_range;
use crate::chart::{Axis, Figure, Panel};
use crate::drawing::Drawing;
use crate::style::Styles;
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::ResultsTable;
use serde::Deserialize;
use std::path::Path;

/// Options of a parameter figure.
#[derive(Debug, Clone, Deserialize)]
pub struct ParameterFigure {
    width: f64,
    height: f64,
    /// The parameter across, by name; `contact_detection` for the margin, whose last part of a label then is no part of the series,
    /// and across which runs without a margin are drawn as level lines.
    parameter: String,
    /// Heading of the horizontal axis.
    x_label: String,
    panels: Vec<ParameterPanel>,
}

/// Column of `runs.csv` that says how contacts were detected.
const MARGIN: &str = "contact_detection";

/// The values that there are, ascending.
fn abscissae(values: &[f64]) -> Vec<f64> {
    let mut values: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct ParameterPanel {
    title: String,
    /// A metric, or `fraction_stable`.
    metric: String,
    label: String,
    range: Option<[f64; 2]>,
    #[serde(default)]
    part: Part,
    #[serde(default)]
    labels: Vec<String>,
    /// The case shown, of an experiment with several.
    #[serde(default)]
    only: Only,
    /// Macro step of the runs shown, s; needed where there are several.
    macro_step_s: Option<f64>,
}

impl ParameterFigure {
    /// Draws the figure from `runs.csv` and `parameters.csv`.
    ///
    /// # Errors
    /// [`Error::File`] for a column or parameter that is not there.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let all = Runs::read(folder)?;
        let mut figure = Figure::new(self.width, self.height).columns(self.panels.len());
        for spec in &self.panels {
            let y = if spec.metric == FRACTION_STABLE { Axis::linear(&spec.label) } else { Axis::log10(&spec.label) };
            let mut panel = Panel::new(&spec.title, Axis::log10(&self.x_label), y.within(spec.range));
            let runs = all.chosen(&spec.only)?;
            let values = self.values(&runs, folder)?;
            let (case, set) = (runs.table.column("case")?, runs.table.column("set")?);
            let wanted_ms = spec.macro_step_s.map(|step| step * 1e3);
            let shown = |row: usize| wanted_ms.is_none_or(|step| (runs.macro_step_ms(row) / step - 1.0).abs() < 1e-9);
            for (label, rows) in self.series(&runs, &values, &spec.labels) {
                let rows: Vec<usize> = rows.into_iter().filter(|&row| shown(row)).collect();
                runs.refuse_several(&rows, "macro_step_s", |row| format!("{} ms", runs.macro_step_ms(row)))?;
                // One value of the parameter is one problem: no other case, and nothing else that differs.
                let problem = |row: usize| format!("{} {}", runs.table.text(row, case), runs.table.text(row, set));
                let points = match rows.iter().any(|&row| values[row].is_finite()) {
                    true => {
                        for (_, rows) in groups(&rows, |row| values[row]) {
                            runs.refuse_several(&rows, "case and set", problem)?;
                        }
                        runs.over_phases(&rows, |row| values[row], &spec.metric, spec.part, Bars::Range)?
                    }
                    // What has no value of the parameter is a level across.
                    false => {
                        runs.refuse_several(&rows, "case and set", problem)?;
                        let level = runs.over_phases(&rows, |_| 0.0, &spec.metric, spec.part, Bars::Range)?;
                        let across = |x: f64| level.iter().map(move |point| OverPhases { x, ..*point });
                        abscissae(&values).into_iter().flat_map(across).collect()
                    }
                };
                panel = with_range(panel, &points, &label, &styles.shown_name(&label), styles.of_label(&label));
            }
            figure = figure.panel(panel);
        }
        figure.draw_if_it_fits()
    }

    /// Labels with their rows; with the margin across, what differs in the margin only is one series.
    fn series(&self, runs: &Runs, values: &[f64], wanted: &[String]) -> Vec<(String, Vec<usize>)> {
        let mut series: Vec<(String, Vec<usize>)> = Vec::new();
        for label in runs.labels(wanted) {
            let rows = runs.of_label(&label);
            let swept = self.parameter == MARGIN && rows.iter().all(|&row| values[row].is_finite());
            let name = label.rsplit_once('/').filter(|_| swept).map_or(label.as_str(), |(name, _)| name);
            match series.iter_mut().find(|(known, _)| known == name) {
                Some((_, known)) => known.extend(rows),
                None => series.push((name.to_owned(), rows)),
            }
        }
        series
    }

    /// The parameter's value in each run: its row in `parameters.csv`, found by case and set of changed parameters.
    fn values(&self, runs: &Runs, folder: &Path) -> Result<Vec<f64>> {
        if self.parameter == MARGIN {
            let column = runs.table.column(MARGIN)?;
            let width = |run: usize| runs.table.text(run, column).strip_prefix("margin:")?.parse().ok();
            return Ok((0..runs.table.len()).map(|run| width(run).unwrap_or(f64::NAN)).collect());
        }
        let path = folder.join("parameters.csv");
        let parameters = ResultsTable::read(&path)?;
        let rows = parameters.rows_where(parameters.column("parameter")?, &self.parameter);
        if rows.is_empty() {
            return Err(Error::file(path, format!("has no parameter `{}`", self.parameter)));
        }
        let (case, set) = (parameters.column("case")?, parameters.column("set")?);
        let (of_case, of_set) = (runs.table.column("case")?, runs.table.column("set")?);
        let value = parameters.column("value")?;
        let value_of = |run: usize| {
            let same = |row: &&usize| {
                parameters.text(**row, case) == runs.table.text(run, of_case)
                    && parameters.text(**row, set) == runs.table.text(run, of_set)
            };
            rows.iter().find(same).map_or(f64::NAN, |&row| parameters.number(row, value))
        };
        Ok((0..runs.table.len()).map(value_of).collect())
    }
}
