//! A metric against the macro step: median over phases, with the range from best to worst phase.

use super::keys::*;
use super::statistics::{
    Bars, ONLY, Only, OverPhases, floor, name, over_phases, read_runs, share_usable, style, unit_of,
};
use crate::chart::{Axis, Band, Figure, Guide, LegendPlace, Losses, Mode, Panel, Series};
use crate::drawing::{Color, Drawing};
use crate::line_style::LineStyle;
use crate::style::Styles;
use crate::ticks::signed;
use rimbench_cases::metrics::floor_of;
use rimbench_core::error::Result;
use rimbench_statistics::{Runs, order_of_medians};
use std::collections::BTreeMap;
use std::convert::identity;
use std::path::Path;

/// A curve that rises less with H has no order that is worth a number.
const LEAST_ORDER: f64 = 0.25;

keys! {
    /// Options of a sweep figure.
    pub struct SweepFigure {
        width: f64 = WIDTH,
        height: f64 = HEIGHT,
        columns: Option<usize> = COLUMNS,
        note: Option<String> = NOTE,
        panels: Vec<SweepPanel> = panels(SweepPanel::KEYS),
    }
}

keys! {
    /// The area that some scheme rows cover, from the least to the largest value.
    struct BandSpec {
        labels: Vec<String> =
            key(Takes::Labels, Needed, "scheme rows; those lost at a point are left out there"),
        label: String = key(Takes::Text, Needed, "what the legend says"),
    }
}

keys! {
    struct SweepPanel {
        title: String = TITLE,
        metric: String = METRIC,
        label: String = METRIC_LABEL,
        range: Option<[f64; 2]> = RANGE,
        only: Only = ONLY,
        labels: Vec<String> = LABELS,
        band: Option<BandSpec> = key(
            Takes::Table(BandSpec::KEYS),
            Then("none"),
            "an area from the least to the largest of some scheme rows"
        ),
        symlog: Option<[f64; 2]> = SYMLOG,
        within: Option<f64> = WITHIN,
        floor: Option<String> = key(
            Takes::Text,
            Then("that of the metric, where it has one"),
            "column with the uncertainty of the reference; the region below it is shaded"
        ),
        slope: Option<(f64, [f64; 2])> =
            key(Takes::Slope, Then("none"), "slope triangle: order and first corner (H in ms, value)"),
        orders_over_ms: Option<[f64; 2]> =
            key(Takes::Interval, Then("all"), "interval of H, ms, over which orders in the legend are fitted"),
    }
}

impl SweepFigure {
    /// Draws the figure from `runs.csv`. Runs that did not complete are left out of the medians and marked above them. A figure of one panel
    /// has the observed orders in its legend.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let table = read_runs(folder)?;
        let all = Runs::of(&table)?;
        let columns = self.columns.unwrap_or(self.panels.len());
        let mut figure = Figure::new(self.width, self.height).columns(columns).legend(LegendPlace::Lines);
        for spec in &self.panels {
            let runs = spec.only.one_of(&all)?;
            let (unit, factor) = unit_of(&runs);
            let x_axis = Axis::log10(format!("macro step H ({unit})"));
            let mut panel = panel_of(&spec.title, x_axis, &spec.label, (spec.symlog, spec.within, spec.range));
            if let Some(band) = &spec.band {
                let curves = band.labels.iter().map(|label| Ok(scaled(spec.points(&runs, label)?, factor)));
                panel.bands.push(band.filled(&curves.collect::<Result<Vec<_>>>()?, styles));
            }
            for label in runs.labels(&spec.labels) {
                let points = spec.points(&runs, label)?;
                let has_order = self.panels.len() == 1 && spec.symlog.is_none() && spec.within.is_none();
                let order = if has_order { spec.order(&runs.of_label(label))? } else { None };
                let levels_off = spec.levels_off(&points);
                let lost = spec.fitted(&points).any(|point| point.lost.failed > 0.0);
                let shown = name(&runs, label, styles);
                let entry = match order {
                    _ if all.of_label(label).share_completed() == Some(0.0) => {
                        format!("{shown}: never stable")
                    }
                    Some(_) if levels_off => format!("{shown}, levels off"),
                    Some(order) => {
                        let order = signed(format!("{order:.2}"));
                        let lost = if lost { " where not diverged" } else { "" };
                        format!("{shown}, order {order}{lost}")
                    }
                    None => shown,
                };
                let points = scaled(points, factor);
                panel = with_range(panel, &points, label, &entry, style(&runs, label, styles));
            }
            let floor = match &spec.floor {
                Some(floor) => {
                    runs.rows().first().map(|&row| Ok(table.number(row, table.column(floor)?))).transpose()?
                }
                None if spec.within.is_some() => None,
                None => floor(&runs, &spec.metric),
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
    /// The medians of one label over the macro steps, or the shares of its runs that are usable.
    fn points(&self, runs: &Runs<'_>, label: &str) -> Result<Vec<OverPhases>> {
        let (own, step) = (runs.of_label(label), |row| runs.macro_step_ms(row));
        match self.within {
            Some(within) => share_usable(&own, step, &self.metric, within),
            None => over_phases(&own, step, &self.metric, identity, Bars::Range),
        }
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

    /// The order of the runs of a label, without those whose error the reference cannot tell from zero, as a claim has it.
    fn order(&self, runs: &Runs<'_>) -> Result<Option<f64>> {
        let column = runs.table().column(&self.metric)?;
        let floor = floor_of(&self.metric);
        let [low, high] = self.orders_over_ms.unwrap_or([0.0, f64::INFINITY]);
        let mut pairs = Vec::new();
        for &row in runs.completed().rows() {
            let (step, error) = (runs.macro_step_ms(row), runs.table().number(row, column));
            let has_order = runs.has_order(row, &self.metric, floor)?;
            pairs.extend((has_order && (low..=high).contains(&step)).then_some((step, error)));
        }
        Ok(order_of_medians(pairs))
    }

    /// The points over which the order is fitted.
    fn fitted<'a>(&self, points: &'a [OverPhases]) -> impl Iterator<Item = &'a OverPhases> {
        let [low, high] = self.orders_over_ms.unwrap_or([0.0, f64::INFINITY]);
        points.iter().filter(move |point| (low..=high).contains(&point.x))
    }
}

/// How values stand on the vertical axis: of both signs, a share, or logarithmic within an interval.
type Upwards = (Option<[f64; 2]>, Option<f64>, Option<[f64; 2]>);

/// An empty panel.
pub(super) fn panel_of(title: &str, x: Axis, label: &str, (symlog, within, range): Upwards) -> Panel {
    match (symlog, within) {
        (Some([least, most]), _) => {
            Panel::new(title, x, Axis::symlog(label, least).range(-most, most)).guide(Guide::Horizontal(0.0))
        }
        (None, Some(_)) => Panel::new(title, x, Axis::linear(label).range(0.0, 1.0)),
        (None, None) => Panel::new(title, x, Axis::log10(label).within(range)),
    }
}

/// The points with macro steps in another unit.
fn scaled(points: Vec<OverPhases>, factor: f64) -> Vec<OverPhases> {
    points.into_iter().map(|point| OverPhases { x: point.x * factor, ..point }).collect()
}

impl BandSpec {
    /// Fills the area between the least and the largest of the curves at each macro step that one of them has; one that is lost there
    /// is left out, and where all are the band breaks. Its colour is that of the first row.
    fn filled(&self, curves: &[Vec<OverPhases>], styles: &Styles) -> Band {
        // Macro steps are above zero: their bits are in order.
        let mut edges: BTreeMap<u64, [f64; 2]> = BTreeMap::new();
        for point in curves.iter().flatten() {
            let edge = edges.entry(point.x.to_bits()).or_insert([f64::NAN; 2]);
            *edge = [edge[0].min(point.median), edge[1].max(point.median)];
        }
        let points = edges.into_iter().map(|(x, edge)| (f64::from_bits(x), edge)).collect();
        let color = self.labels.first().map_or(Color::SOFT_INK, |label| styles.of_label(label).color);
        Band { label: self.label.clone(), points, color }
    }
}

/// Adds the medians as a line with markers, a thin bar from the least to the largest value at each, and marks where runs were
/// lost. `name` is the row of the scheme, `entry` what the legend says of it.
pub(super) fn with_range(mut panel: Panel, points: &[OverPhases], name: &str, entry: &str, style: LineStyle) -> Panel {
    let bars = points.iter().filter(|point| point.least < point.most).map(|point| (point.x, [point.least, point.most]));
    let lost = points.iter().filter(|point| point.lost.is_any()).map(|point| (point.x, point.lost)).collect::<Vec<_>>();
    if !lost.is_empty() {
        panel.losses.push(Losses { name: name.to_owned(), points: lost, color: style.color });
    }
    let medians = points.iter().map(|point| (point.x, point.median)).collect();
    let note = |point: &OverPhases| point.lost.in_words();
    let (name, bars, notes) = (name.to_owned(), bars.collect(), points.iter().map(note).collect());
    panel.series(Series { mode: Mode::LineMarkers, name, bars, notes, ..Series::new(entry, medians, style) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::Loss;

    /// Medians of an rms force error over the macro steps, N over ms.
    fn points(medians: &[f64]) -> Vec<OverPhases> {
        let steps = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0];
        let point =
            |(&x, &median): (&f64, &f64)| OverPhases { x, median, least: median, most: median, lost: Loss::default() };
        steps.iter().zip(medians).map(point).collect()
    }

    fn panel(more: &str) -> SweepPanel {
        toml::from_str(&format!("title = \"\"\nmetric = \"error\"\nlabel = \"\"\n{more}")).unwrap()
    }

    #[test]
    fn a_band_is_as_wide_as_its_curves_and_breaks_where_all_are_lost() {
        let spec = BandSpec { labels: vec!["rim-smooth".to_owned()], label: "margins".to_owned() };
        let band = spec.filled(&[points(&[1.0, f64::NAN, 2.0]), points(&[3.0, f64::NAN])], &Styles::standard());
        let [first, second, third] = band.points.try_into().unwrap();
        assert_eq!((first, third), ((0.5, [1.0, 3.0]), (2.0, [2.0, 2.0])));
        assert!(second.0 == 1.0 && second.1.iter().all(|edge| edge.is_nan()));
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
        let cells = |row: &str| row.split(',').map(str::to_owned).collect::<Vec<_>>();
        let header = "case,set,label,macro_step_s,outcome,force_error_rms_n,reference_force_uncertainty_n";
        // Second order above an uncertainty of 1 N; a run that diverged is no point.
        let rows = [
            "0.001,completed,1.0,1.0",
            "0.002,completed,4.0,1.0",
            "0.004,completed,16.0,1.0",
            "0.008,diverged,9e9,1.0",
        ];
        let rows = rows.map(|row| cells(&format!("box,,x,{row}"))).to_vec();
        let table = rimbench_statistics::ResultsTable::of(Path::new("runs.csv"), cells(header), rows);
        let panel = |metric: &str, more: &str| -> SweepPanel {
            toml::from_str(&format!("title = \"\"\nmetric = \"{metric}\"\nlabel = \"\"\n{more}")).unwrap()
        };
        let order = |panel: SweepPanel| panel.order(&Runs::of(&table).unwrap()).unwrap();
        assert!((order(panel("force_error_rms_n", "")).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(order(panel("force_error_rms_n", "orders_over_ms = [1.0, 2.0]")), None);
        assert!(panel("nothing", "").order(&Runs::of(&table).unwrap()).is_err());
    }

    #[test]
    fn a_usable_run_completes_within_the_bound_and_a_skipped_one_is_none() {
        let cells = |row: &str| row.split(',').map(str::to_owned).collect::<Vec<_>>();
        let rows = ["completed,0.05", "completed,-0.1", "completed,0.2", "diverged,0.01", "completed,", "skipped,"];
        let rows = rows.map(|row| cells(&format!("box,,x,0.005,{row}"))).to_vec();
        let header = cells("case,set,label,macro_step_s,outcome,error");
        let table = rimbench_statistics::ResultsTable::of(Path::new("runs.csv"), header, rows);
        let panel: SweepPanel = toml::from_str("metric = \"error\"\nwithin = 0.1\n").unwrap();
        let points = panel.points(&Runs::of(&table).unwrap(), "x").unwrap();
        assert_eq!(points.iter().map(|point| (point.x, point.median)).collect::<Vec<_>>(), [(5.0, 0.4)]);
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
