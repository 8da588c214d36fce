//! A metric against a parameter of the case, or against a number of an option: median over phases, with the range from best to worst
//! phase.

use super::keys::*;
use super::statistics::{
    Bars, FRACTION_STABLE, ONLY, Only, OverPhases, over_phases, read_runs, refuse_several, share_usable, style,
};
use super::sweep_figure::{panel_of, with_range};
use crate::chart::{Axis, Figure, Guide, Panel};
use crate::drawing::Drawing;
use crate::style::Styles;
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::{ResultsTable, read_table};
use rimbench_statistics::Runs;
use std::convert::identity;
use std::path::Path;

keys! {
    /// Options of a parameter figure.
    pub struct ParameterFigure {
        width: f64 = WIDTH,
        height: f64 = HEIGHT,
        parameter: String = key(
            Takes::Text,
            Needed,
            "the parameter across, by name; or a number of an option, as in `delivery_up:delay`"
        ),
        x_label: String = key(Takes::Text, Like("parameter"), "heading of the horizontal axis"),
        lines: Vec<Line> = key(
            Takes::Tables(Line::KEYS),
            Then("one per scheme row"),
            "lines of several scheme rows that differ in the option across"
        ),
        panels: Vec<ParameterPanel> = panels(ParameterPanel::KEYS),
    }
}

keys! {
    struct ParameterPanel {
        title: String = TITLE,
        metric: String = METRIC,
        label: String = METRIC_LABEL,
        range: Option<[f64; 2]> = key(
            Takes::Interval,
            AUTOMATIC,
            "vertical axis; logarithmic, so above 0, but for `fraction_stable`"
        ),
        labels: Vec<String> = LABELS,
        only: Only = ONLY,
        symlog: Option<[f64; 2]> = SYMLOG,
        within: Option<f64> = WITHIN,
        border: Option<Border> = key(Takes::Table(Border::KEYS), Then("none"), "a border across the panel"),
        macro_step_s: Option<f64> =
            key(Takes::Positive, Then("the only one there is"), "macro step of the runs shown, s"),
    }
}

keys! {
    struct Line {
        labels: Vec<String> = key(Takes::Labels, Needed, "scheme rows; the last gives the style"),
        label: String = key(Takes::Text, Needed, "what the legend says"),
    }
}

keys! {
    struct Border {
        at: f64 = key(Takes::Positive, Needed, "value of the parameter"),
        label: String = key(Takes::Text, Needed, "what stands beside it"),
    }
}

/// Column of `runs.csv` that says how contacts were detected. With it as the parameter the margin is across: the last part of a label then
/// is no part of the series, and runs without a margin are level lines.
const MARGIN: &str = "contact_detection";

/// The values that there are, ascending.
fn abscissae(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

impl ParameterFigure {
    /// Draws the figure from `runs.csv` and `parameters.csv`.
    ///
    /// # Errors
    /// [`Error::File`] for a column or parameter that is not there.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let table = read_runs(folder)?;
        let all = Runs::of(&table)?;
        let values = self.values(&table, folder)?;
        // A logarithmic axis has no place for what is in time, or loses nothing.
        let across = if values.contains(&0.0) { Axis::linear } else { Axis::log10 };
        let mut figure = Figure::new(self.width, self.height).columns(self.panels.len());
        for spec in &self.panels {
            let runs = if self.lines.is_empty() { spec.only.of(&all)? } else { spec.only.one_of(&all)? };
            let x = across(self.x_label.clone());
            let mut panel = match spec.metric == FRACTION_STABLE {
                true => Panel::new(&spec.title, x, Axis::linear(&spec.label).within(spec.range)),
                false => panel_of(&spec.title, x, &spec.label, (spec.symlog, spec.within, spec.range)),
            };
            if let Some(Border { at, label }) = &spec.border {
                panel = panel.guide(Guide::Vertical(*at, label.clone()));
            }
            let wanted_ms = spec.macro_step_s.map(|step| step * 1e3);
            let shown = |row: usize| wanted_ms.is_none_or(|step| (runs.macro_step_ms(row) / step - 1.0).abs() < 1e-9);
            for line in &self.lines {
                let rows = line.labels.iter().flat_map(|label| runs.of_label(label).rows().to_vec());
                let rows = runs.with_rows(rows.collect()).select(shown);
                let points = match spec.within {
                    Some(within) => share_usable(&rows, |row| values[row], &spec.metric, within)?,
                    None => over_phases(&rows, |row| values[row], &spec.metric, identity, Bars::Range)?,
                };
                let last = line.labels.last().map_or("", String::as_str);
                panel = with_range(panel, &points, last, &line.label, style(&runs, last, styles));
            }
            let single = if self.lines.is_empty() { self.series(&runs, &values, &spec.labels) } else { Vec::new() };
            for (label, rows) in single {
                let rows = rows.select(shown);
                refuse_several(&rows, "macro_step_s", |row| format!("{} ms", runs.macro_step_ms(row)))?;
                // One value of the parameter is one problem: no other case, and nothing else that differs.
                let problem = |row: usize| runs.problem(row).join(" ");
                let points = match rows.rows().iter().any(|&row| values[row].is_finite()) {
                    true => {
                        for (_, rows) in rows.by(|row| values[row]) {
                            refuse_several(&rows, "case and set", problem)?;
                        }
                        over_phases(&rows, |row| values[row], &spec.metric, identity, Bars::Range)?
                    }
                    // What has no value of the parameter is a level across.
                    false => {
                        refuse_several(&rows, "case and set", problem)?;
                        let level = over_phases(&rows, |_| 0.0, &spec.metric, identity, Bars::Range)?;
                        let across = |x: f64| level.iter().map(move |point| OverPhases { x, ..*point });
                        abscissae(runs.rows().iter().map(|&row| values[row])).into_iter().flat_map(across).collect()
                    }
                };
                panel = with_range(panel, &points, label, &styles.shown_name(label), styles.of_label(label));
            }
            figure = figure.panel(panel);
        }
        figure.draw_if_it_fits()
    }

    /// Labels with their rows; with the margin across, what differs in the margin only is one series.
    fn series<'t>(&self, runs: &Runs<'t>, values: &[f64], wanted: &[String]) -> Vec<(&'t str, Runs<'t>)> {
        let mut series: Vec<(&str, Runs<'_>)> = Vec::new();
        for label in runs.labels(wanted) {
            let rows = runs.of_label(label);
            let swept = self.parameter == MARGIN && rows.rows().iter().all(|&row| values[row].is_finite());
            let name = label.rsplit_once('/').filter(|_| swept).map_or(label, |(name, _)| name);
            match series.iter_mut().find(|(known, _)| *known == name) {
                Some((_, known)) => *known = known.with_rows([known.rows(), rows.rows()].concat()),
                None => series.push((name, rows)),
            }
        }
        series
    }

    /// The parameter's value in each run: its row in `parameters.csv`, found by case and set of changed parameters.
    fn values(&self, runs: &ResultsTable, folder: &Path) -> Result<Vec<f64>> {
        let option = if self.parameter == MARGIN { "contact_detection:margin" } else { &self.parameter };
        if let Some((column, part)) = option.split_once(':') {
            let column = runs.column(column)?;
            // What is not said of a run: no margin, the true mass, no delay.
            let absent = match part {
                "margin" => f64::NAN,
                "mass" | "friction" => 1.0,
                _ => 0.0,
            };
            let number = |text: &str| text.strip_prefix(part)?.strip_prefix(':')?.parse().ok();
            let value = |run: usize| runs.text(run, column).split(',').find_map(number).unwrap_or(absent);
            return Ok((0..runs.len()).map(value).collect());
        }
        let path = folder.join("parameters.csv");
        let parameters = read_table(&path)?;
        let rows = parameters.rows_where(parameters.column("parameter")?, &self.parameter);
        if rows.is_empty() {
            return Err(Error::file(path, format!("has no parameter `{}`", self.parameter)));
        }
        let (case, set) = (parameters.column("case")?, parameters.column("set")?);
        let (of_case, of_set) = (runs.column("case")?, runs.column("set")?);
        let value = parameters.column("value")?;
        let value_of = |run: usize| {
            let same = |row: &&usize| {
                parameters.text(**row, case) == runs.text(run, of_case)
                    && parameters.text(**row, set) == runs.text(run, of_set)
            };
            rows.iter().find(same).map_or(f64::NAN, |&row| parameters.number(row, value))
        };
        Ok((0..runs.len()).map(value_of).collect())
    }
}
