//! Columns of traces over time, one panel per column or zoom.

use super::valid;
use super::{FigureOptions, Source};
use crate::chart::{Axis, Figure, Mode, Plot, Series};
use crate::drawing::Drawing;
use crate::style::Styles;
use crate::ticks::signed;
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::{ResultsTable, read_table};
use rimbench_results::selection::Runs;
use rimbench_runs::Finding;
use serde::Deserialize;
use std::path::Path;

/// Options of a trace figure.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TraceFigure {
    /// Width, px; 680 px are 180 mm on paper, two columns.
    #[serde(default = "valid::width", deserialize_with = "valid::pixels")]
    width: f64,
    /// Height, px.
    #[serde(default = "valid::height", deserialize_with = "valid::pixels")]
    height: f64,
    /// Scheme rows, or `reference`; the first at the back.
    series: Vec<String>,
    /// Panels per row; all panels in one row where it is not given.
    #[serde(default, deserialize_with = "valid::columns")]
    columns: Option<usize>,
    /// Panels, from the left.
    #[serde(deserialize_with = "valid::panels")]
    panels: Vec<TracePanel>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TracePanel {
    /// Heading.
    #[serde(default)]
    title: String,
    /// A column of the traces.
    column: String,
    /// Heading of the vertical axis.
    #[serde(default)]
    label: String,
    /// Horizontal axis, s.
    #[serde(default, deserialize_with = "valid::interval")]
    time_s: Option<[f64; 2]>,
    /// Vertical axis.
    #[serde(default, deserialize_with = "valid::interval")]
    range: Option<[f64; 2]>,
    /// Held between communication points instead of joined by lines.
    #[serde(default)]
    steps: bool,
    /// Its distance from the reference instead, on a logarithmic axis.
    #[serde(default)]
    error: bool,
}

impl FigureOptions for TraceFigure {
    type Panel = TracePanel;

    /// Draws the figure from `runs.csv` and the traces it names.
    ///
    /// # Errors
    /// [`Error::File`] for a trace or column that is not there.
    fn draw(&self, source: &Source, styles: &Styles) -> Result<Drawing> {
        let (folder, runs) = (&*source.folder, Runs::of(source.runs()?));
        let traces = self.series.iter().map(|label| Ok((label, trace(folder, &runs, label)?)));
        let traces: Vec<(&String, ResultsTable)> = traces.collect::<Result<_>>()?;
        let mut figure = Figure::new(self.width, self.height, self.columns);
        for spec in &self.panels {
            let mut panel = Plot::new(
                &spec.title,
                Axis::linear("time t (s)").within(spec.time_s),
                if spec.error { Axis::log10(&spec.label) } else { Axis::linear(&spec.label) }.within(spec.range),
            );
            // Only models that are audited have the columns of an audit.
            let lacks = |(_, trace): &&(&String, ResultsTable)| trace.column(&spec.column).is_err();
            let nobody_has = traces.iter().all(|series| lacks(&series));
            let traces = || traces.iter().filter(|series| nobody_has || !lacks(series));
            let known = match spec.error {
                true => Some(trace(folder, &runs, REFERENCE)?.pairs("time_s", &spec.column)?),
                false => None,
            };
            for (label, trace) in traces().filter(|(label, _)| !(spec.error && *label == REFERENCE)) {
                let points = trace.pairs("time_s", &spec.column)?;
                let points = known.as_ref().map_or_else(|| points.clone(), |known| apart(&points, known));
                let mode = if spec.steps { Mode::Steps } else { Mode::Line };
                let entry = format!("{}{}", styles.shown_name(label), ending(&runs, label));
                let series = Series::new(entry, points, styles.of_label(label)).mode(mode);
                panel = panel.layer(Series { name: label.to_string(), ..series });
            }
            let cut = traces().filter(|_| !spec.error);
            let cut = cut.filter_map(|(label, trace)| spec.what_is_cut(&styles.shown_name(label), trace).transpose());
            panel.notes = cut.collect::<Result<_>>()?;
            figure = figure.panel(panel);
        }
        figure.draw()
    }

    fn finish(&mut self) -> Result<(), String> {
        let without = self.panels.iter_mut().filter(|panel| panel.label.is_empty());
        without.for_each(|panel| panel.label.clone_from(&panel.column));
        Ok(())
    }
}

/// The series of the reference.
const REFERENCE: &str = "reference";

/// How far a series is from another, at times that both have, where they differ.
fn apart(points: &[(f64, f64)], known: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let off = |&(t, y): &(f64, f64)| {
        let at = known.partition_point(|(time, _)| *time < t - 1e-9);
        let (_, other) = known.get(at).filter(|(time, _)| *time < t + 1e-9)?;
        Some((t, (y - other).abs())).filter(|(_, off)| *off > 0.0)
    };
    points.iter().filter_map(off).collect()
}

impl TracePanel {
    /// Says how far a series goes beyond the axis.
    fn what_is_cut(&self, name: &str, trace: &ResultsTable) -> Result<Option<String>> {
        let Some([lowest, highest]) = self.range else { return Ok(None) };
        let shown = |t: f64| self.time_s.is_none_or(|[from, to]| (from..=to).contains(&t));
        let points = trace.pairs("time_s", &self.column)?;
        let values = points.iter().filter(|(t, y)| shown(*t) && y.is_finite()).map(|(_, y)| *y);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
        let cut = low < lowest || high > highest;
        Ok(cut.then(|| format!("{name} cut: {} … {}", signed(format!("{low:.0}")), signed(format!("{high:.0}")))))
    }
}

/// The row of the run of a scheme row that did not come to its end, if there is one.
pub(super) fn lost_run(runs: &Runs<'_>, label: &str) -> Option<usize> {
    runs.of_label(label).rows().iter().copied().find(|&row| !runs.is_completed(row))
}

/// What the legend says of a run that did not come to its end, and when it broke off.
fn ending(runs: &Runs<'_>, label: &str) -> String {
    let Some(row) = lost_run(runs, label).filter(|_| label != REFERENCE) else { return String::new() };
    // Where the state left its bounds, which a run may outlive.
    let ends = [Finding::OutcomeAt, Finding::EndedAt].map(|end| runs.value(row, end));
    let when = ends.into_iter().find(|end| end.is_finite()).map_or_else(String::new, |end| format!(" at {end:.2} s"));
    format!(": {}{when}", runs.run(row).found.outcome.name())
}

/// Reads the trace of the run of a scheme row, or of the reference.
///
/// # Errors
/// [`Error::File`] if there is none, or if there are several, which is ambiguous.
pub(super) fn trace(folder: &Path, runs: &Runs<'_>, label: &str) -> Result<ResultsTable> {
    let wrong = |text: String| Err(Error::file(folder.join("runs.csv"), text));
    let several = |count: usize, what: &str| {
        wrong(format!("has {count} {what}; a figure of traces needs an experiment with one"))
    };
    let name = match *runs.of_label(label).rows() {
        _ if label == REFERENCE && runs.problems().len() > 1 => return several(runs.problems().len(), "references"),
        _ if label == REFERENCE => "reference.csv",
        [] => return wrong(format!("has no run labelled `{label}`")),
        [row] => &*runs.run(row).trace,
        ref rows => return several(rows.len(), &format!("runs labelled `{label}`")),
    };
    match name {
        "" => wrong(format!("has no trace of `{label}`")),
        name => read_table(&folder.join("traces").join(name)),
    }
}
