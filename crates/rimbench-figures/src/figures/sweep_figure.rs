//! A metric against the macro step: median over phases, with the range from best to worst phase.

use super::band_spec::BandSpec;
use super::statistics::{Bars, Only, OverPhases, Part, Runs};
use crate::chart::{Axis, Band, Figure, Guide, Losses, Mode, Panel, Series};
use crate::drawing::Drawing;
use crate::style::{SeriesStyle, Styles};
use crate::ticks::signed;
use rimbench_core::error::Result;
use rimbench_statistics::order_of_convergence;
use serde::Deserialize;
use std::path::Path;

/// A curve that rises less with H has no order that is worth a number.
const LEAST_ORDER: f64 = 0.25;

/// Options of a sweep figure.
#[derive(Debug, Clone, Deserialize)]
pub struct SweepFigure {
    width: f64,
    height: f64,
    /// Panels per row; all in one if absent.
    columns: Option<usize>,
    /// What the picture says below its panels.
    note: Option<String>,
    panels: Vec<SweepPanel>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepPanel {
    title: String,
    metric: String,
    label: String,
    range: Option<[f64; 2]>,
    /// Signed logarithmic axis: linear within ± the first, shown to ± the second.
    symlog: Option<[f64; 2]>,
    /// The case shown, of an experiment with several.
    #[serde(default)]
    only: Only,
    /// Which values of a signed metric to show; the label should say so.
    #[serde(default)]
    part: Part,
    /// Labels of the scheme rows to show; all if there are none.
    #[serde(default)]
    labels: Vec<String>,
    /// From the least to the largest median of some rows.
    band: Option<BandSpec>,
    #[serde(default)]
    without_exact: bool,
    #[serde(default)]
    bars: Bars,
    /// Interval of H shown, ms.
    macro_steps_ms: Option<[f64; 2]>,
    /// Column with the reference's own uncertainty; that of the metric if absent. The region below it is shaded.
    floor: Option<String>,
    /// Slope triangle: order, and its first corner (H in ms, value).
    slope: Option<(f64, [f64; 2])>,
    /// Interval of H, ms, over which the orders in the legend are fitted; all if absent.
    orders_over_ms: Option<[f64; 2]>,
}

impl SweepFigure {
    /// Draws the figure from `runs.csv`. Runs that did not complete are left out of the medians and marked above them. A figure of one panel
    /// has the observed orders in its legend.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let all = Runs::read(folder)?;
        let columns = self.columns.unwrap_or(self.panels.len());
        let mut figure = Figure::new(self.width, self.height).columns(columns);
        for spec in &self.panels {
            let runs = all.only(&spec.only)?;
            let runs = if spec.without_exact { runs.without_exact()? } else { runs };
            let longest = (0..runs.table.len()).map(|row| runs.macro_step_ms(row)).fold(0.0, f64::max);
            // Steps of microseconds say so.
            let (unit, factor) = if longest < 0.1 { ("µs", 1e3) } else { ("ms", 1.0) };
            let x_axis = Axis::log10(format!("macro step H ({unit})"));
            let x_axis = x_axis.within(spec.macro_steps_ms.map(|interval| interval.map(|step| step * factor)));
            let y_axis = match spec.symlog {
                Some([least, most]) => Axis::symlog(&spec.label, least).range(-most, most),
                None => Axis::log10(&spec.label).within(spec.range),
            };
            let mut panel = Panel::new(&spec.title, x_axis, y_axis);
            if spec.symlog.is_some() {
                panel = panel.guide(Guide::Horizontal { y: 0.0, label: String::new() });
            }
            if let Some(band) = &spec.band {
                let mut band = spec.filled(band, &runs, styles)?;
                band.points.iter_mut().for_each(|(step, _)| *step *= factor);
                panel = panel.band(band);
            }
            for label in runs.labels(&spec.labels) {
                let points = spec.points(&runs, &label, spec.bars)?;
                let order = spec.order(&points).filter(|_| self.panels.len() == 1 && spec.symlog.is_none());
                let levels_off = spec.levels_off(&points);
                let lost = spec.fitted(&points).any(|point| point.lost > 0.0);
                let entry = match order {
                    _ if all.fraction_stable(&all.of_label(&label)) == Some(0.0) => {
                        format!("{}: never stable", styles.shown_name(&label))
                    }
                    Some(_) if levels_off => format!("{}, levels off", styles.shown_name(&label)),
                    Some(order) => {
                        let order = signed(format!("{order:.2}"));
                        let lost = if lost { " where not diverged" } else { "" };
                        format!("{}, order {order}{lost}", styles.shown_name(&label))
                    }
                    None => styles.shown_name(&label),
                };
                let points: Vec<OverPhases> =
                    points.into_iter().map(|point| OverPhases { x: point.x * factor, ..point }).collect();
                panel = with_range(panel, &points, &label, &entry, runs.style(&label, styles));
            }
            let floor = match &spec.floor {
                Some(floor) => Some(runs.table.number(0, runs.table.column(floor)?)),
                None => runs.floor(&spec.metric),
            };
            // Down there a distance from the reference says nothing.
            if let Some(y) = floor.filter(|floor| spec.symlog.is_none() && *floor > spec.lowest(&panel)) {
                let [label, entry] = ["uncertainty of the reference", "below the reference's uncertainty"];
                panel = panel.guide(Guide::Below { y, label: label.into(), entry: entry.into() });
            }
            if let Some((order, [x, y])) = spec.slope {
                panel = panel.guide(Guide::Slope { order, from: (factor * x, y), to_x: 2.0 * factor * x });
            }
            figure = figure.panel(panel);
        }
        Ok(figure.draw_if_it_fits()?.noted(self.note.as_deref().unwrap_or_default()))
    }
}

impl SweepPanel {
    /// The medians of one label over the macro steps shown.
    fn points(&self, runs: &Runs, label: &str, bars: Bars) -> Result<Vec<OverPhases>> {
        let [from, to] = self.macro_steps_ms.unwrap_or([0.0, f64::INFINITY]);
        let shown = |row: &usize| (from..=to).contains(&runs.macro_step_ms(*row));
        let rows: Vec<usize> = runs.of_label(label).into_iter().filter(shown).collect();
        runs.over_phases(&rows, |row| runs.macro_step_ms(row), &self.metric, self.part, bars)
    }

    /// The area from the least to the largest median of some labels.
    fn filled(&self, band: &BandSpec, runs: &Runs, styles: &Styles) -> Result<Band> {
        let mut curves = Vec::new();
        for label in &band.labels {
            let points = self.points(runs, label, Bars::Range)?;
            curves.push(points.into_iter().map(|point| (point.x, point.median)).collect::<Vec<_>>());
        }
        Ok(band.filled(&curves, styles))
    }

    /// About where the vertical axis begins.
    fn lowest(&self, panel: &Panel) -> f64 {
        let points = panel.series.iter().flat_map(|series| &series.points).map(|point| point.1);
        let bars = panel.series.iter().flat_map(|series| &series.bars).map(|(_, [least, _])| *least);
        let least = points.chain(bars).filter(|value| *value > 0.0).fold(f64::INFINITY, f64::min);
        self.range.map_or(least, |[low, _]| low)
    }

    /// Whether the curve has no order where its order would be: at the smallest macro steps of the interval over which it is fitted. At the
    /// largest ones every error ends somewhere, which is no floor.
    fn levels_off(&self, points: &[OverPhases]) -> bool {
        let mut known: Vec<&OverPhases> = self.fitted(points).filter(|point| point.median > 0.0).collect();
        known.sort_by(|a, b| a.x.total_cmp(&b.x));
        let [small, next, ..] = known[..] else { return false };
        (next.median / small.median).ln() < LEAST_ORDER * (next.x / small.x).ln()
    }

    fn order(&self, points: &[OverPhases]) -> Option<f64> {
        order_of_convergence(&self.fitted(points).map(|point| (point.x, point.median)).collect::<Vec<_>>())
    }

    /// The points over which the order is fitted.
    fn fitted<'a>(&self, points: &'a [OverPhases]) -> impl Iterator<Item = &'a OverPhases> {
        let [low, high] = self.orders_over_ms.unwrap_or([0.0, f64::INFINITY]);
        points.iter().filter(move |point| (low..=high).contains(&point.x))
    }
}

/// Adds the medians as a line with markers, a thin bar from the least to the largest value at each, and marks where runs were
/// lost. `name` is the row of the scheme, `entry` what the legend says of it.
pub(super) fn with_range(
    mut panel: Panel,
    points: &[OverPhases],
    name: &str,
    entry: &str,
    style: SeriesStyle,
) -> Panel {
    let bars = points.iter().filter(|point| point.least < point.most).map(|point| (point.x, [point.least, point.most]));
    let lost = points.iter().filter(|point| point.lost > 0.0).map(|point| (point.x, point.lost)).collect::<Vec<_>>();
    if !lost.is_empty() {
        panel.losses.push(Losses { name: name.to_owned(), points: lost, color: style.color });
    }
    let medians = points.iter().map(|point| (point.x, point.median)).collect();
    let note = |point: &OverPhases| match point.lost {
        0.0 => String::new(),
        lost => format!("{:.0} % of the runs diverged", 100.0 * lost),
    };
    let series = Series::new(entry, medians, style).mode(Mode::LineMarkers).named(name).bars(bars.collect());
    panel.series(series.notes(points.iter().map(note).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Medians of an rms force error over the macro steps, N over ms.
    fn points(medians: &[f64]) -> Vec<OverPhases> {
        let steps = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0];
        let point = |(&x, &median): (&f64, &f64)| OverPhases { x, median, least: median, most: median, lost: 0.0 };
        steps.iter().zip(medians).map(point).collect()
    }

    fn panel(more: &str) -> SweepPanel {
        toml::from_str(&format!("title = \"\"\nmetric = \"error\"\nlabel = \"\"\n{more}")).unwrap()
    }

    #[test]
    fn only_what_ends_at_small_steps_levels_off_and_what_ends_at_large_ones_has_an_order() {
        let panel_of_all = panel("");
        let saturated = points(&[2.13, 3.53, 6.69, 16.6, 30.5, 26.5]);
        assert!(!panel_of_all.levels_off(&saturated));
        let order = panel_of_all.order(&saturated).unwrap();
        assert!((0.7..0.9).contains(&order), "{order}");
        for floor in [[36.1, 37.9, 41.4, 43.2, 46.2, 33.5], [0.282, 0.261, 0.259, 0.851, 3.31, 9.70]] {
            assert!(panel_of_all.levels_off(&points(&floor)), "{floor:?}");
        }
    }

    #[test]
    fn where_a_curve_ends_is_looked_for_where_its_order_is_fitted() {
        let floor = points(&[0.282, 0.261, 0.259, 0.851, 3.31, 9.70]);
        assert!(!panel("orders_over_ms = [2.0, 20.0]").levels_off(&floor));
        // One point, or none, says nothing.
        assert!(!panel("orders_over_ms = [10.0, 10.0]").levels_off(&floor));
        assert!(!panel("").levels_off(&points(&[f64::NAN, 1.0])));
        // A step at which nothing completed is no plateau.
        assert!(!panel("").levels_off(&points(&[f64::NAN, 1.0, 2.0, f64::NAN])));
    }
}
