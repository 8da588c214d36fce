//! A metric of many schemes at a few macro steps: a row per scheme, ranked, one sign per macro step.

use super::statistics::{
    Bars, CountedRuns, Only, OverPhases, floor, over_phases, rounded, row, share_of_runs, unit_of,
};
use super::valid;
use super::{FigureOptions, Source};
use crate::chart::{Absent, Axis, Cell, Figure, Guide, Mode, Name, Plot, Series};
use crate::drawing::Drawing;
use crate::style::Styles;
use rimbench_core::error::{Error, Result};
use rimbench_results::selection::Runs;
use rimbench_runs::Finding;
use serde::Deserialize;
use std::cmp::Ordering;

/// Options of a dot plot.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DotsFigure {
    /// Width, px; 680 px are 180 mm on paper, two columns.
    #[serde(default = "valid::width", deserialize_with = "valid::pixels")]
    width: f64,
    /// Panels per row; all panels in one row where it is not given.
    #[serde(default, deserialize_with = "valid::columns")]
    columns: Option<usize>,
    /// Scheme rows shown; all there are where none is given.
    #[serde(default)]
    labels: Vec<String>,
    /// Macro steps shown, ms; at most nine.
    #[serde(default, deserialize_with = "valid::some_numbers")]
    macro_steps_ms: Option<Vec<f64>>,
    /// From least to largest value, or the 95 % interval of the median by the bootstrap over cases (of one case: over
    /// runs).
    #[serde(default)]
    bars: Bars,
    /// Every run as a faint mark; needs a single macro step.
    #[serde(default)]
    runs: bool,
    /// What the picture itself says below its panels.
    #[serde(default)]
    note: String,
    /// Panels, from the left.
    #[serde(deserialize_with = "valid::panels")]
    panels: Vec<DotsPanel>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DotsPanel {
    /// Heading.
    #[serde(default)]
    title: String,
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
    /// Leave out cases in which the model of some run is the mechanics itself (`model_exact`).
    #[serde(default)]
    without_exact: bool,
}

/// Macro steps of the panels: most of what a picture can hold.
const MOST_SIGNS: usize = 9;

/// A median of one row, or why there is none.
type Dot = Result<OverPhases, Absent>;

impl FigureOptions for DotsFigure {
    type Panel = DotsPanel;

    /// Draws the figure from `runs.csv`: median over phases, bars from the best to the worst. Runs that did not
    /// complete are counted beside the panel. Rows are ranked by how they do in all panels, failures first, then
    /// errors, the best on top.
    ///
    /// # Errors
    /// [`Error::File`] for a column that is not there, and for more macro steps than there are signs.
    fn draw(&self, source: &Source, styles: &Styles) -> Result<Drawing> {
        let table = source.runs()?;
        let all = Runs::of(table);
        let labels = all.labels(&self.labels);
        let mut parts = Vec::new();
        for spec in &self.panels {
            let runs = spec.only.one_of(&all)?;
            parts.push(if spec.without_exact { runs.without_exact() } else { runs });
        }
        let steps = parts.iter().map(|runs| self.steps(runs)).collect::<Result<Vec<Vec<f64>>>>()?;
        // A case of microseconds beside cases of milliseconds: the signs then are the smallest step, the next, and so
        // on.
        let most = steps.iter().map(Vec::len).max().unwrap_or(0);
        let alike = steps.iter().all(|own| *own == steps[0]);
        let (mut dots, mut titles): (Vec<Vec<Vec<Dot>>>, Vec<String>) = (Vec::new(), Vec::new());
        for ((spec, runs), steps) in self.panels.iter().zip(&parts).zip(&steps) {
            let [mut counted, mut failing] = [CountedRuns::default(), CountedRuns::default()];
            let of_label = |label: &&str| -> Result<Vec<Dot>> {
                let rows = runs.of_label(label);
                let step_of = |row: usize| runs.macro_step_ms(row);
                let points = match spec.metric {
                    Finding::Completed => share_of_runs(&rows, step_of, None, &mut counted)?,
                    metric => over_phases(&rows, step_of, metric, f64::abs, self.bars)?,
                };
                // What stands beside the panel is the share that failed.
                for (step, rows) in rows.select(|row| !runs.is_skipped(row)).by(step_of) {
                    failing.take(step, &rows)?;
                }
                let dot = |index: usize| {
                    let Some(&step) = steps.get(index) else { return Err(Absent::NotRun) };
                    let tally = rows.select(|row| step_of(row) == step).tally();
                    let point = points.iter().find(|point| point.x == step && tally.run() > 0);
                    point.copied().ok_or(Absent::of(tally.skipped))
                };
                Ok((0..most).map(dot).collect())
            };
            dots.push(labels.iter().map(of_label).collect::<Result<_>>()?);
            titles.push(counted.behind(&spec.title));
        }
        let ideals: Vec<f64> = self.panels.iter().map(|panel| panel.metric.ideal()).collect();
        let order = ranked(&dots, &ideals, labels.len());
        let (unit, factor) = unit_of(&parts[0]);
        let sign = |index: usize| match alike {
            true => {
                let step = rounded(steps[0][index] * factor);
                Name { value: step, short: format!("{step}"), label: format!("H = {step} {unit}") }
            }
            false => {
                let number = index + 1;
                let label = format!("macro step {number} of each case");
                Name { value: number as f64, short: format!("{number}"), label }
            }
        };
        let signs: Vec<Name> = (0..most).map(sign).collect();
        let quantity = if alike { format!("macro step H ({unit})") } else { "macro step, by number".to_owned() };
        let mut figure = Figure { note: self.note.clone(), ..Figure::new(self.width, 0.0, self.columns) };
        for ((dots, title), (spec, runs)) in dots.into_iter().zip(titles).zip(self.panels.iter().zip(&parts)) {
            let values = Axis::log10(&spec.label).within(spec.range);
            let mut plot = Plot::new(title, Axis::named(&quantity, signs.clone()), values);
            for &index in &order {
                let dots = signs.iter().zip(&dots[index]);
                let median = |dot: &Dot| dot.map_or(f64::NAN, |point| point.median);
                let range = |dot: &Dot| dot.ok().filter(|point| point.least < point.most);
                let loss = |dot: &Dot| dot.map(|point| point.lost);
                let said = |dot: &Dot| loss(dot).map_or_else(|why| why.in_words().to_owned(), |loss| loss.in_words());
                let points = dots.clone().map(|(sign, dot)| (sign.value, median(dot))).collect();
                let of_runs = runs.of_label(labels[index]).completed();
                let marks = of_runs.rows().iter().filter(|_| self.runs).map(|&row| runs.value(row, spec.metric));
                let bars = dots
                    .clone()
                    .filter_map(|(sign, dot)| range(dot).map(|point| (sign.value, [point.least, point.most])));
                plot = plot.layer(Series {
                    points,
                    bars: bars.collect(),
                    notes: dots.clone().map(|(_, dot)| said(dot)).collect(),
                    cells: dots.map(|(_, dot)| loss(dot).map_or_else(Cell::Absent, Cell::of)).collect(),
                    marks: marks.collect(),
                    ..row(&all, labels[index], styles, Mode::Row)
                });
            }
            let medians = dots.iter().flatten().flatten().map(|point| point.median);
            let least = medians.filter(|value| *value > 0.0).fold(f64::INFINITY, f64::min);
            let lowest = spec.range.map_or(least, |[low, _]| low);
            plot.marks.extend(floor(runs, spec.metric).filter(|floor| *floor > lowest).map(Guide::Below));
            figure = figure.panel(plot);
        }
        figure.draw()
    }

    fn finish(&mut self) -> Result<(), String> {
        let without = self.panels.iter_mut().filter(|panel| panel.label.is_empty());
        without.for_each(|panel| panel.label = panel.metric.name().to_owned());
        Ok(())
    }
}

impl DotsFigure {
    /// The macro steps of a panel, ms, ascending.
    fn steps(&self, runs: &Runs<'_>) -> Result<Vec<f64>> {
        let mut steps: Vec<f64> = runs.rows().iter().map(|&row| runs.macro_step_ms(row)).collect();
        steps.sort_by(f64::total_cmp);
        steps.dedup();
        if let Some(wanted) = &self.macro_steps_ms {
            let is_wanted = |step: &f64| wanted.iter().any(|wanted| (step / wanted - 1.0).abs() < 1e-9);
            steps.retain(is_wanted);
        }
        match steps.len() {
            0 => Err(Error::file(runs.table().path(), "has no run at a macro step that the figure shows")),
            1..=MOST_SIGNS => Ok(steps),
            count => {
                let message =
                    format!("has {count} macro steps and there are {MOST_SIGNS} signs: choose some by macro_steps_ms");
                Err(Error::file(runs.table().path(), message))
            }
        }
    }
}

/// Rows by the share of their runs that fail, in per cent, and of as few failures by their mean rank over all panels
/// and signs: of those that were run there, fewer failures first, and of as few the value nearest to the ideal of its
/// panel. What gave no answer, or was not run, has no rank there; what has none anywhere is last, and of equals the
/// first stays first.
fn ranked(dots: &[Vec<Vec<Dot>>], ideals: &[f64], rows: usize) -> Vec<usize> {
    let mut ranks: Vec<Vec<f64>> = vec![Vec::new(); rows];
    for (panel, ideal) in dots.iter().zip(ideals) {
        let signs = panel.first().map_or(0, Vec::len);
        for dots in (0..signs).map(|sign| panel.iter().map(|row| row[sign]).collect::<Vec<Dot>>()) {
            // A failure is worse than every number.
            let place = |dot: &Dot| match dot {
                Ok(point) if point.lost.failed >= 1.0 => Some([1.0, f64::INFINITY]),
                Ok(point) if point.median.is_finite() => Some([point.lost.failed, (point.median - ideal).abs()]),
                _ => None,
            };
            let places: Vec<Option<[f64; 2]>> = dots.iter().map(place).collect();
            for (own, ranks) in places.iter().zip(&mut ranks).filter_map(|(own, ranks)| Some((own.as_ref()?, ranks))) {
                ranks.push(places.iter().flatten().filter(|other| *other < own).count() as f64);
            }
        }
    }
    let mean = |row: usize| match &ranks[row][..] {
        [] => f64::INFINITY,
        ranks => ranks.iter().sum::<f64>() / ranks.len() as f64,
    };
    let failed = |row: usize| {
        let shares = dots.iter().flat_map(|panel| &panel[row]).flatten().map(|point| point.lost.failed);
        let shares: Vec<f64> = shares.collect();
        (100.0 * shares.iter().sum::<f64>() / shares.len().max(1) as f64).round()
    };
    // What has no rank anywhere is last, whether or not it fails.
    let key = |row: usize| [f64::from(u8::from(mean(row).is_infinite())), failed(row), mean(row)];
    let mut order: Vec<usize> = (0..rows).collect();
    order.sort_by(|&a, &b| {
        key(a).iter().zip(key(b)).map(|(a, b)| a.total_cmp(&b)).find(|one| one.is_ne()).unwrap_or(Ordering::Equal)
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::Loss;

    fn dot(median: f64, failed: f64, silent: f64) -> Dot {
        Ok(OverPhases { x: 1.0, median, least: median, most: median, lost: Loss { failed, silent } })
    }

    #[test]
    fn the_best_row_comes_first_and_what_failed_last() {
        let dot = |value: f64| dot(value, if value.is_nan() { 1.0 } else { 0.0 }, 0.0);
        let panel = [[3.0, 4.0], [f64::NAN, 1.0], [1.0, 2.0]].map(|row| row.map(dot).to_vec()).to_vec();
        assert_eq!(ranked(std::slice::from_ref(&panel), &[0.0], 3), [2, 0, 1]);
        assert_eq!(ranked(&[], &[], 2), [0, 1]);
        // Of a ratio the least is not the best: 3 and 4 are nearer to 3.5 than 1 and 2.
        assert_eq!(ranked(&[panel], &[3.5], 3), [0, 2, 1]);
    }

    /// The best of those that are left says nothing of those that are not.
    #[test]
    fn a_failure_is_worse_than_every_number_and_a_time_out_is_neither() {
        let column = |dots: &[Dot]| vec![dots.iter().map(|dot| vec![*dot]).collect::<Vec<_>>()];
        let some_fail = [dot(1.0, 0.25, 0.0), dot(9.0, 0.0, 0.0), dot(1.0, 0.5, 0.0)];
        assert_eq!(ranked(&column(&some_fail), &[0.0], 3), [1, 0, 2]);
        let some_last = [Err(Absent::NotRun), dot(9.0, 1.0, 0.0), dot(f64::NAN, 0.0, 1.0), dot(2.0, 0.0, 0.5)];
        assert_eq!(ranked(&column(&some_last), &[0.0], 4), [3, 1, 0, 2]);
        // Far ahead at one of two steps, and failing at the other: behind what completes.
        let ahead = [vec![dot(1.0, 0.0, 0.0), dot(1.0, 0.5, 0.0)], vec![dot(2.0, 0.0, 0.0), dot(2.0, 0.0, 0.0)]];
        assert_eq!(ranked(&[ahead.to_vec()], &[0.0], 2), [1, 0]);
        // Not run at one of two steps, and ahead at the other.
        let two = [vec![dot(1.0, 0.0, 0.0), Err(Absent::LeftOut)], vec![dot(2.0, 0.0, 0.0), dot(1.0, 0.0, 0.0)]];
        assert_eq!(ranked(&[two.to_vec()], &[0.0], 2), [0, 1]);
    }
}
