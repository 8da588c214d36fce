//! A metric against the macro step, a parameter of the case or the cost: median over phases, with the range from best
//! to worst.

use super::abscissa::{Abscissa, Across, abscissae};
use super::statistics::{
    Bars, CountedRuns, Only, OverPhases, floor, name, over_phases, refuse_several, rounded, share_of_runs, style,
    unit_of,
};
use super::valid::{self, refuse};
use super::{FigureOptions, Source};
use crate::chart::{Axis, Figure, Guide, Loss, Mode, Plot, Series};
use crate::drawing::Drawing;
use crate::line_style::LineStyle;
use crate::style::Styles;
use crate::ticks::signed;
use rimbench_core::error::{Error, Result};
use rimbench_results::budget::{forms_of, ratio_within, way_of};
use rimbench_results::selection::{ALL, Runs};
use rimbench_runs::Finding;
use rimbench_statistics::{Pool, order_of_medians};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::convert::identity;

/// A curve that rises less with H has no order that is worth a number.
const LEAST_ORDER: f64 = 0.25;

/// Options of an XY figure.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct XyFigure {
    /// Width, px; 680 px are 180 mm on paper, two columns.
    #[serde(default = "valid::width", deserialize_with = "valid::pixels")]
    width: f64,
    /// Height, px.
    #[serde(default = "valid::height", deserialize_with = "valid::pixels")]
    height: f64,
    /// Panels per row; all panels in one row where it is not given.
    #[serde(default, deserialize_with = "valid::columns")]
    columns: Option<usize>,
    /// What the picture itself says below its panels.
    #[serde(default)]
    note: String,
    /// Panels, from the left.
    #[serde(deserialize_with = "valid::panels")]
    panels: Vec<XyPanel>,
}

/// Several scheme rows that differ in the option across, as one line.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    /// Scheme rows; the last gives the style.
    labels: Vec<String>,
    /// What the legend says.
    label: String,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Border {
    /// Value of the parameter.
    #[serde(deserialize_with = "valid::positive")]
    at: f64,
    /// Text beside it.
    label: String,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct XyPanel {
    /// Heading.
    #[serde(default)]
    title: String,
    /// What is across.
    #[serde(default)]
    x: Across,
    /// A number of a run, a column of runs.csv, or `fraction_stable`.
    #[serde(deserialize_with = "valid::metric")]
    metric: Finding,
    /// Heading of the vertical axis; the metric where it is not given.
    #[serde(default)]
    label: String,
    /// Vertical axis, where it is logarithmic.
    #[serde(default, deserialize_with = "valid::positive_interval")]
    range: Option<[f64; 2]>,
    /// The part of the results shown.
    #[serde(default)]
    only: Only,
    /// Scheme rows shown; all there are where none is given.
    #[serde(default)]
    labels: Vec<String>,
    /// Those that the others are held against: in grey.
    #[serde(default)]
    baselines: Vec<String>,
    /// What rows are called here.
    #[serde(default)]
    names: BTreeMap<String, String>,
    /// What all rows of the panel end in, as in `1ms` of `rim-nonsmooth/1ms`: names and styles are those of the rows
    /// without it.
    #[serde(default)]
    variant: String,
    /// Over a parameter, lines of several scheme rows that differ in the option across.
    #[serde(default, deserialize_with = "valid::panels")]
    lines: Vec<Line>,
    /// A border at a value of the parameter.
    #[serde(default)]
    border: Option<Border>,
    /// Macro step of the runs shown over a parameter, s.
    #[serde(default, deserialize_with = "valid::positive")]
    macro_step_s: Option<f64>,
    /// Vertical axis for values of both signs: linear within ± the first, logarithmic beyond, up to ± the second.
    #[serde(default, deserialize_with = "valid::positive_interval")]
    symlog: Option<[f64; 2]>,
    /// Show the share of the runs that complete with at most this much of the metric instead, on a linear axis.
    #[serde(default, deserialize_with = "valid::positive")]
    within: Option<f64>,
    /// Slope triangle: order and first corner (H in ms, value).
    #[serde(default, deserialize_with = "valid::slope")]
    slope: Option<(f64, [f64; 2])>,
    /// Interval of H, ms, over which orders in the legend are fitted.
    #[serde(default, deserialize_with = "valid::interval")]
    orders_over_ms: Option<[f64; 2]>,
}

impl FigureOptions for XyFigure {
    type Panel = XyPanel;

    /// Draws the figure from `runs.csv`, `parameters.csv` and `cost.csv`. Runs that did not complete are left out of
    /// the medians; where that has a place across, they are marked above them. A figure of one panel has the observed
    /// orders in its legend.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column, parameter or row of cost that is not there.
    fn draw(&self, source: &Source, styles: &Styles) -> Result<Drawing> {
        let all = Runs::of(source.runs()?);
        let figure = Figure::new(self.width, self.height, self.columns);
        let mut figure = Figure { note: self.note.clone(), ..figure };
        for spec in &self.panels {
            let abscissa = spec.x.read(&source.folder, &all)?;
            // Each value of a parameter is a problem of its own.
            let runs = match abscissa {
                Abscissa::Parameter(_) if spec.lines.is_empty() => spec.only.of(&all)?,
                _ => spec.only.one_of(&all)?,
            };
            let (unit, factor) = if spec.x.is_macro_step() { unit_of(&runs) } else { ("", 1.0) };
            // A logarithmic axis has no place for 0 (samples in time, none lost).
            let from_zero = matches!(&abscissa, Abscissa::Parameter(values) if values.contains(&0.0));
            let across = if from_zero { Axis::linear } else { Axis::log10 };
            let x_axis = across(spec.x.heading(unit)).within(spec.x.range);
            let mut panel = Plot::new(&spec.title, x_axis, spec.y_axis());
            if spec.symlog.is_some() {
                panel.marks.push(Guide::Horizontal(0.0));
            }
            if let Some(Border { at, label }) = &spec.border {
                panel.marks.push(Guide::Vertical(*at, label.clone()));
            }
            let counted = &mut CountedRuns::default();
            let curves = match &abscissa {
                Abscissa::MacroStep => spec.over_steps(&runs, &all, self.panels.len() == 1, styles, counted)?,
                Abscissa::Parameter(values) => spec.over_parameter(&runs, values, styles, counted)?,
                Abscissa::Budgets(budgets) => spec.over_budgets(&runs, budgets, &all, styles)?,
                Abscissa::Cost(work) => spec.over_cost(&runs, &all, work, styles)?,
            };
            panel.title = counted.behind(&spec.title);
            for curve in curves {
                let name = spec.without_variant(&curve.name).to_owned();
                let style = style(&all, &name, styles);
                let style = if spec.baselines.contains(&name) { Styles::baseline(style) } else { style };
                let mut curve = Series { name, style, ..curve };
                curve.points.iter_mut().for_each(|(x, _)| *x *= factor);
                curve.bars.iter_mut().for_each(|(x, _)| *x *= factor);
                curve.lost.iter_mut().for_each(|(x, _)| *x *= factor);
                panel = panel.layer(curve);
            }
            let has_floor = spec.within.is_none() && spec.x.is_macro_step() && spec.symlog.is_none();
            let floor = floor(&runs, spec.metric).filter(|floor| has_floor && *floor > spec.lowest(&panel));
            panel.marks.extend(floor.map(Guide::Below));
            if let Some((order, [x, y])) = spec.slope {
                panel.marks.push(Guide::Slope { order, from: (factor * x, y), to_x: 2.0 * factor * x });
            }
            figure = figure.panel(panel);
        }
        figure.draw()
    }

    fn finish(&mut self) -> Result<(), String> {
        for panel in &mut self.panels {
            if panel.label.is_empty() {
                panel.label = valid::metric_name(panel.metric);
            }
            let shown = || panel.labels.iter().chain(panel.lines.iter().flat_map(|line| &line.labels));
            let other = |label: &&String| shown().all(|known| known != *label);
            if let Some(label) = panel.baselines.iter().chain(panel.names.keys()).find(other) {
                return Err(Error::unknown("label", label, shown().map(String::as_str)).to_string());
            }
            let has_parameter = panel.x.parameter.is_some();
            if [has_parameter, panel.x.cost.is_some(), panel.x.budgets.is_some()].into_iter().filter(|own| *own).count()
                > 1
            {
                return Err("panels: x: a parameter, a cost or budgets are across, not several".to_owned());
            }
            if !panel.x.is_macro_step() {
                let of_steps = [("slope", panel.slope.is_some()), ("orders_over_ms", panel.orders_over_ms.is_some())];
                refuse(&of_steps, "needs the macro step across")?;
            }
            if panel.x.cost.is_some() {
                let of_values = [("symlog", panel.symlog.is_some()), ("within", panel.within.is_some())];
                refuse(&of_values, "does not go with a cost across")?;
            }
            if panel.metric == Finding::Completed {
                refuse(&[("within", panel.within.is_some())], "needs a metric that is no share")?;
            }
            if !has_parameter {
                let of_parameters = [
                    ("macro_step_s", panel.macro_step_s.is_some()),
                    ("lines", !panel.lines.is_empty()),
                    ("border", panel.border.is_some()),
                ];
                refuse(&of_parameters, "needs a parameter across; otherwise `only` chooses runs")?;
            }
        }
        Ok(())
    }
}

impl XyPanel {
    /// The row that a row is a variant of, where all of the panel are.
    fn without_variant<'a>(&self, label: &'a str) -> &'a str {
        let variant = label.strip_suffix(&self.variant).and_then(|label| label.strip_suffix('/'));
        variant.filter(|_| !self.variant.is_empty()).unwrap_or(label)
    }

    /// What a row is called.
    fn named(&self, runs: &Runs<'_>, label: &str, styles: &Styles) -> String {
        self.names.get(label).cloned().unwrap_or_else(|| name(runs, label, styles))
    }

    fn y_axis(&self) -> Axis {
        match (self.symlog, self.within) {
            (Some([least, most]), _) => Axis::symlog(&self.label, least).within(Some([-most, most])),
            (None, Some(_)) => Axis::linear(&self.label).within(Some([0.0, 1.05])),
            _ if self.metric == Finding::Completed => Axis::linear(&self.label).within(Some([-0.05, 1.05])),
            _ => Axis::log10(&self.label).within(self.range),
        }
    }

    /// Lines over the macro step, with the observed orders where these are wanted.
    fn over_steps<'t>(
        &self,
        runs: &Runs<'t>,
        all: &Runs<'_>,
        is_alone: bool,
        styles: &Styles,
        counted: &mut CountedRuns<'t>,
    ) -> Result<Vec<Series>> {
        let line = |label: &'t str| {
            let points = self.medians(&runs.of_label(label), |row| runs.macro_step_ms(row), counted)?;
            let has_order = is_alone && self.symlog.is_none() && self.within.is_none();
            // Two points are a line whatever they are.
            let has_order = has_order && self.fitted(&points).filter(|point| point.median.is_finite()).count() > 2;
            let order = if has_order { self.order(&runs.of_label(label)) } else { None };
            let lost = self.fitted(&points).any(|point| point.lost.failed > 0.0);
            let shown = self.named(all, self.without_variant(label), styles);
            let entry = match order {
                _ if all.of_label(label).share_completed() == Some(0.0) => format!("{shown}: never stable"),
                Some(_) if self.levels_off(&points) => format!("{shown}, levels off"),
                Some(order) => {
                    let order = signed(format!("{order:.2}"));
                    let lost = if lost { " of completed runs" } else { "" };
                    format!("{shown}, order {order}{lost}")
                }
                None => shown,
            };
            Ok(curve(label, entry, &points))
        };
        runs.labels(&self.labels).into_iter().map(line).collect()
    }

    /// Lines over the values of a parameter.
    fn over_parameter<'t>(
        &self,
        runs: &Runs<'t>,
        values: &[f64],
        styles: &Styles,
        counted: &mut CountedRuns<'t>,
    ) -> Result<Vec<Series>> {
        let wanted_ms = self.macro_step_s.map(|step| step * 1e3);
        let shown = |row: usize| wanted_ms.is_none_or(|step| (runs.macro_step_ms(row) / step - 1.0).abs() < 1e-9);
        if !self.lines.is_empty() {
            let of_line = |line: &Line| {
                // The last row that there is gives the style.
                let last = runs.labels(&line.labels).pop()?;
                let rows = line.labels.iter().flat_map(|label| runs.of_label(label).rows().to_vec());
                let rows = runs.with_rows(rows.collect()).select(shown);
                let points = self.medians(&rows, |row| values[row], counted);
                Some(points.map(|points| curve(last, line.label.clone(), &points)))
            };
            return self.lines.iter().filter_map(of_line).collect();
        }
        // One value of the parameter is one problem: no other case, and nothing else that differs.
        let refuse_problems = |rows: &Runs<'_>| refuse_several(rows, "case and set", |row| runs.problem(row).join(" "));
        let of_label = |(label, rows): (&'t str, Runs<'t>)| {
            let rows = rows.select(shown);
            refuse_several(&rows, "macro_step_s", |row| format!("{} ms", runs.macro_step_ms(row)))?;
            let points = match rows.rows().iter().any(|&row| values[row].is_finite()) {
                true => {
                    rows.by(|row| values[row]).iter().try_for_each(|(_, rows)| refuse_problems(rows))?;
                    self.medians(&rows, |row| values[row], counted)?
                }
                // What has no value of the parameter is a level across.
                false => {
                    refuse_problems(&rows)?;
                    let level = self.medians(&rows, |_| 0.0, &mut CountedRuns::default())?;
                    let across = |x: f64| level.iter().map(move |point| OverPhases { x, ..*point });
                    abscissae(runs.rows().iter().map(|&row| values[row])).into_iter().flat_map(across).collect()
                }
            };
            Ok(curve(label, self.named(runs, label, styles), &points))
        };
        self.x.series(runs, values, &self.labels).into_iter().map(of_label).collect()
    }

    /// Lines over the cost: a point is the median of one macro step and one tolerance.
    fn over_cost<'t>(&self, runs: &Runs<'t>, all: &Runs<'_>, work: &[f64], styles: &Styles) -> Result<Vec<Series>> {
        let (unit, factor) = unit_of(runs);
        let of_row = |row: usize| runs.run(row).step_tolerance;
        let tolerance = |row: usize| if of_row(row).is_finite() { of_row(row) } else { 0.0 };
        let of_label = |label: &'t str| {
            // What did not complete has no cost at which to mark it.
            let lost = match all.of_label(label).share_completed() {
                None if all.of_label(label).tally().run() > 0 => ": no answer",
                None if all.of_label(label).tally().skipped > 0 => ": left out",
                None => ": not run",
                Some(0.0) => ": all runs failed",
                Some(share) if share < 1.0 => ": some runs failed",
                Some(_) => "",
            };
            let (mut points, mut notes, mut tags) = (Vec::new(), Vec::new(), Vec::new());
            let by_step = runs.of_label(label).by(|row| runs.macro_step_ms(row)).into_iter();
            let by_tolerance = by_step.flat_map(|(step, runs)| {
                runs.by(tolerance).into_iter().map(move |(tolerance, runs)| (step, tolerance, runs.completed()))
            });
            for (step, controlled, completed) in by_tolerance {
                let finite = |row: usize| if work[row].is_finite() { work[row] } else { f64::NAN };
                let error = over_phases(&completed, |_| step, self.metric, f64::abs, Bars::Range)?;
                if let Some((x, error)) = completed.pool(finite).median().zip(error.first()) {
                    let step = rounded(step * factor);
                    points.push(OverPhases { x, least: error.median, most: error.median, ..*error });
                    notes.push(format!("H = {step} {unit}"));
                    // Of several points at one macro step the tolerance tells them apart, unless it is so large that it
                    // never counts.
                    let is_controlled = (1e-12..1e6).contains(&controlled);
                    tags.push(if is_controlled { format!("{controlled:e}") } else { format!("{step}") });
                }
            }
            let entry = format!("{}{lost}", self.named(runs, label, styles));
            Ok(Series { notes, tags, ..curve(label, entry, &points) })
        };
        runs.labels(&self.labels).into_iter().map(of_label).collect()
    }

    /// Lines over the mechanics steps of budgets: how far the best form of a way is from that of the best way.
    fn over_budgets<'t>(
        &self,
        runs: &Runs<'t>,
        budgets: &[[f64; 2]],
        all: &Runs<'_>,
        styles: &Styles,
    ) -> Result<Vec<Series>> {
        runs.table().check(self.metric)?;
        let way = |row: usize| way_of(runs.label(row));
        let shown =
            runs.select(|row| self.labels.is_empty() || self.labels.iter().any(|label| way_of(label) == way(row)));
        let forms = forms_of(&shown, |row| runs.value(row, self.metric));
        let mut ways: Vec<&str> = Vec::new();
        for label in shown.labels(&[]).into_iter().map(way_of) {
            ways.extend((!ways.contains(&label)).then_some(label));
        }
        let of_way = |way: &&str| {
            let point = |budget: &[f64; 2]| {
                let pool = Pool::of(forms.values().filter_map(|of| ratio_within(of, *budget, [*way, ALL])));
                let [least, median, most] = pool.quartiles();
                OverPhases { x: budget[1], median, least, most, lost: Loss::default() }
            };
            let points: Vec<OverPhases> = budgets.iter().map(point).filter(|point| point.median.is_finite()).collect();
            curve(way, self.named(all, way, styles), &points)
        };
        Ok(ways.iter().map(of_way).collect())
    }

    /// The medians of runs over what is across, or shares of them.
    fn medians<'t>(
        &self,
        runs: &Runs<'t>,
        across: impl Fn(usize) -> f64,
        counted: &mut CountedRuns<'t>,
    ) -> Result<Vec<OverPhases>> {
        match self.within.map(|within| (self.metric, within)) {
            None if self.metric != Finding::Completed => over_phases(runs, across, self.metric, identity, Bars::Range),
            within => share_of_runs(runs, across, within, counted),
        }
    }

    /// About where the vertical axis begins.
    fn lowest(&self, panel: &Plot) -> f64 {
        let points = panel.layers.iter().flat_map(|series| &series.points).map(|point| point.1);
        let bars = panel.layers.iter().flat_map(|series| &series.bars).map(|(_, [least, _])| *least);
        let least = points.chain(bars).filter(|value| *value > 0.0).fold(f64::INFINITY, f64::min);
        self.range.map_or(least, |[low, _]| low)
    }

    /// Whether the curve has no order where its order would be: at the smallest macro steps of the interval over which
    /// it is fitted. At the largest ones every error ends somewhere, which is no floor.
    fn levels_off(&self, points: &[OverPhases]) -> bool {
        let mut known: Vec<&OverPhases> = self.fitted(points).filter(|point| point.median > 0.0).collect();
        known.sort_by(|a, b| a.x.total_cmp(&b.x));
        let [small, next, ..] = known[..] else { return false };
        (next.median / small.median).ln() < LEAST_ORDER * (next.x / small.x).ln()
    }

    /// The order of the runs of a label, without those whose error the reference cannot tell from zero, as a claim has
    /// it.
    fn order(&self, runs: &Runs<'_>) -> Option<f64> {
        let [low, high] = self.orders_over_ms.unwrap_or([0.0, f64::INFINITY]);
        let mut pairs = Vec::new();
        for &row in runs.completed().rows() {
            let (step, error) = (runs.macro_step_ms(row), runs.value(row, self.metric));
            let has_order = runs.run(row).found.has_order(self.metric);
            pairs.extend((has_order && (low..=high).contains(&step)).then_some((step, error)));
        }
        order_of_medians(pairs)
    }

    /// The points over which the order is fitted.
    fn fitted<'a>(&self, points: &'a [OverPhases]) -> impl Iterator<Item = &'a OverPhases> {
        let [low, high] = self.orders_over_ms.unwrap_or([0.0, f64::INFINITY]);
        points.iter().filter(move |point| (low..=high).contains(&point.x))
    }
}

/// A scheme row, with what the legend says, as a line with markers: a thin bar from the least to the largest value at each,
/// and where runs were lost.
fn curve(name: &str, entry: String, points: &[OverPhases]) -> Series {
    let bars = points.iter().filter(|point| point.least < point.most).map(|point| (point.x, [point.least, point.most]));
    let lost = points.iter().filter(|point| point.lost != Loss::default()).map(|point| (point.x, point.lost));
    let medians = points.iter().map(|point| (point.x, point.median)).collect();
    Series {
        mode: Mode::LineMarkers,
        name: name.to_owned(),
        bars: bars.collect(),
        lost: lost.collect(),
        notes: points.iter().map(|point| point.lost.in_words()).collect(),
        ..Series::new(entry, medians, LineStyle::of_name(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_results::run_table::RunTable;
    use std::path::Path;

    /// Medians of an rms force error over the macro steps, N over ms.
    fn points(medians: &[f64]) -> Vec<OverPhases> {
        let steps = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0];
        let point =
            |(&x, &median): (&f64, &f64)| OverPhases { x, median, least: median, most: median, lost: Loss::default() };
        steps.iter().zip(medians).map(point).collect()
    }

    fn table(header: &str, rows: &[String]) -> RunTable {
        RunTable::parse(Path::new("runs.csv"), &format!("{header}\n{}", rows.join("\n"))).unwrap()
    }

    fn panel(more: &str) -> XyPanel {
        toml::from_str(&format!("title = \"\"\nmetric = \"velocity_error_rms_m_s\"\nlabel = \"\"\n{more}")).unwrap()
    }

    #[test]
    fn only_what_ends_at_small_steps_levels_off_and_what_ends_at_large_ones_has_an_order() {
        let panel_of_all = panel("");
        let saturated = points(&[2.13, 3.53, 6.69, 16.6, 30.5, 26.5]);
        assert!(!panel_of_all.levels_off(&saturated));
        for floor in [[36.1, 37.9, 41.4, 43.2, 46.2, 33.5], [0.282, 0.261, 0.259, 0.851, 3.31, 9.70]] {
            assert!(panel_of_all.levels_off(&points(&floor)), "{floor:?}");
        }
    }

    #[test]
    fn an_order_is_that_of_completed_runs_whose_error_the_reference_can_tell_from_zero() {
        let header = "case,set,label,macro_step_s,outcome,force_error_rms_n,reference_force_uncertainty_n";
        // Second order above an uncertainty of 1 N; a run that failed is no point.
        let rows = [
            "0.001,completed,1.0,1.0",
            "0.002,completed,4.0,1.0",
            "0.004,completed,16.0,1.0",
            "0.008,diverged,9e9,1.0",
        ];
        let table = table(header, &rows.map(|row| format!("box,,x,{row}")));
        let panel = |metric: &str, more: &str| -> XyPanel {
            toml::from_str(&format!("title = \"\"\nmetric = \"{metric}\"\nlabel = \"\"\n{more}")).unwrap()
        };
        let order = |panel: XyPanel| panel.order(&Runs::of(&table));
        assert!((order(panel("force_error_rms_n", "")).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(order(panel("force_error_rms_n", "orders_over_ms = [1.0, 2.0]")), None);
        assert_eq!(order(panel("position_error_rms_m", "")), None);
    }

    #[test]
    fn a_usable_run_completes_within_the_bound_and_a_skipped_one_is_none() {
        let rows = ["completed,0.05", "completed,-0.1", "completed,0.2", "diverged,0.01", "completed,", "skipped,"];
        let header = "case,set,label,macro_step_s,outcome,velocity_error_rms_m_s";
        let table = table(header, &rows.map(|row| format!("box,,x,0.005,{row}")));
        let panel: XyPanel = toml::from_str("metric = \"velocity_error_rms_m_s\"\nwithin = 0.1\n").unwrap();
        let runs = Runs::of(&table);
        let points = panel.medians(&runs, |row| runs.macro_step_ms(row), &mut CountedRuns::default()).unwrap();
        assert_eq!(points.iter().map(|point| (point.x, point.median)).collect::<Vec<_>>(), [(5.0, 0.4)]);
    }

    /// With friction one scheme had no runs, and the share of its rival was that of more machines.
    #[test]
    fn shares_of_rows_with_other_runs_are_not_drawn_in_one_panel() {
        let header = "case,set,label,macro_step_s,outcome,velocity_error_rms_m_s";
        let row = |row: &str| format!("{row},completed,0.05");
        let rows = ["box,,x,0.005", "box,,y,0.005", "box,friction=0.3,x,0.005", "box,,x,0.01"].map(row);
        let table = table(header, &rows);
        let runs = Runs::of(&table);
        let shares = |metric: &str, only: &str| {
            let panel: XyPanel = toml::from_str(&format!("{metric}\nonly = {{ case = \"all\", {only} }}")).unwrap();
            let (mut counted, runs) = (CountedRuns::default(), panel.only.one_of(&runs)?);
            panel.over_steps(&runs, &runs, false, &Styles::standard(), &mut counted)?;
            Ok::<_, Error>(counted.behind("(a)"))
        };
        let usable = "metric = \"velocity_error_rms_m_s\"\nwithin = 0.1";
        for metric in [usable, "metric = \"fraction_stable\""] {
            let refused = shares(metric, "set = \"all\"").unwrap_err().to_string();
            let said = "`x` over 2 runs and of `y` over 1 that are not the same, as of `box friction=0.3`";
            assert!(refused.contains(said), "{refused}");
            assert_eq!(shares(metric, "without = \"friction\"").unwrap(), "(a), n = 1");
        }
        assert!(shares(usable, "without = \"mass\"").unwrap_err().to_string().contains("valid: friction"));
        // Medians are of whatever completed.
        assert_eq!(shares("metric = \"velocity_error_rms_m_s\"", "set = \"all\"").unwrap(), "(a)");
    }

    #[test]
    fn where_a_curve_ends_is_looked_for_where_its_order_is_fitted() {
        let floor = points(&[0.282, 0.261, 0.259, 0.851, 3.31, 9.70]);
        assert!(!panel("orders_over_ms = [2.0, 20.0]").levels_off(&floor));
        // One point, or none, says nothing.
        assert!(!panel("orders_over_ms = [9.0, 11.0]").levels_off(&floor));
        assert!(!panel("").levels_off(&points(&[f64::NAN, 1.0])));
        // A step at which nothing completed is no plateau.
        assert!(!panel("").levels_off(&points(&[f64::NAN, 1.0, 2.0, f64::NAN])));
    }

    #[test]
    fn a_line_of_several_rows_is_theirs_whatever_the_order_of_the_table() {
        let header = "case,set,label,macro_step_s,outcome,velocity_error_rms_m_s";
        let rows = ["box,,a/1,0.001,completed,1.0", "box,,b/1,0.001,completed,2.0"].map(str::to_owned);
        let table = table(header, &rows);
        let lines = "[[lines]]\nlabels = [\"c/1\"]\nlabel = \"third\"\n[[lines]]\nlabels = [\"b/1\"]\nlabel = \"second\"\n\
                     [[lines]]\nlabels = [\"a/1\"]\nlabel = \"first\"\n";
        let runs = Runs::of(&table);
        let curves =
            panel(lines).over_parameter(&runs, &[5.0, 5.0], &Styles::standard(), &mut CountedRuns::default()).unwrap();
        let found: Vec<_> = curves.iter().map(|curve| (&*curve.label, curve.points[0].1)).collect();
        assert_eq!(found, [("second", 2.0), ("first", 1.0)]);
    }
}
