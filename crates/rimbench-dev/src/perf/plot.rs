//! The history as a figure: instructions and times relative to the first record, with the steps found in them.

use super::history::{History, Row};
use super::steps::steps;
use rimbench_figures::chart::{Axis, Figure, Guide, LegendPlace, Mode, Panel, Series};
use rimbench_figures::days::day_of;
use rimbench_figures::drawing::Drawing;
use rimbench_figures::style::{SeriesStyle, style_in_list};

/// 180 mm, two columns of a page.
const WIDTH: f64 = 680.0;
/// Of one panel, px.
const HEIGHT: f64 = 310.0;
/// Relative change of a time below which no step is drawn: code layout alone does as much.
pub(super) const TIME_FLOOR: f64 = 0.05;

/// Draws the records of the newest target and compiler, of the times only those of the newest machine; the records are
/// numbered as in the whole history.
///
/// Steps are vertical lines labelled with the ratio of the levels; of several at one place with their count and the largest. A panel
/// without a curve is left out.
pub fn draw_history(history: &History) -> Drawing {
    let records = history.records();
    let last = history.rows.last();
    let alike =
        |row: &&Row| row.is_ok() && last.is_some_and(|last| (&row.target, &row.rustc) == (&last.target, &last.rustc));
    let here = |row: &Row| last.is_some_and(|last| row.machine == last.machine);
    let rows: Vec<&Row> = history.rows.iter().filter(alike).collect();
    let mut names: Vec<&str> = Vec::new();
    for row in &rows {
        if !names.contains(&row.benchmark.as_str()) {
            names.push(&row.benchmark);
        }
    }
    let number = |row: &Row| records.iter().position(|record| *record == row.record).map(|at| at as f64 + 1.0);
    let curves = |value: &dyn Fn(&Row) -> Option<f64>| -> Vec<Curve<'_>> {
        let of = |name: &&str| {
            rows.iter().filter(|row| row.benchmark == *name).filter_map(|row| number(row).zip(value(row))).collect()
        };
        names
            .iter()
            .enumerate()
            .map(|(index, name)| Curve { name, style: style_in_list(index), points: of(name) })
            .collect()
    };
    let counts = curves(&|row| row.instructions.map(|count| count as f64));
    let times = curves(&|row| row.time_ratio.filter(|_| here(row)));
    let revision = |record: Option<&&str>| {
        let row = record.and_then(|record| history.rows.iter().find(|row| row.record == **record));
        row.map_or("", |row| row.git_revision.get(..8).unwrap_or(&row.git_revision))
    };
    let day = |record: Option<&&str>| {
        let row = record.and_then(|record| history.rows.iter().find(|row| row.record == **record));
        row.map_or_else(String::new, |row| day_of(row.recorded_at_unix_s))
    };
    let [first, newest] =
        [records.first(), records.last()].map(|record| format!("{} of {}", revision(record), day(record)));
    let across = format!("record, from revision {first} (1) to {newest} ({})", records.len());
    let panel = |title: &str, curves: &[Curve<'_>], floor| {
        let x = Axis::count(&across).range(0.5, records.len() as f64 + 0.5);
        relative_to_first(Panel::new(title, x, y_axis(curves)), curves, floor)
    };
    let panels = [("instructions", &counts, 0.0), ("wall time over yardstick", &times, TIME_FLOOR)];
    // One record is no history.
    let drawn = panels.into_iter().filter(|(_, curves, _)| curves.iter().any(|curve| curve.points.len() > 1));
    let panels: Vec<Panel> = drawn
        .zip(["(a)", "(b)"])
        .map(|((title, curves, floor), letter)| panel(&format!("{letter} {title}"), curves, floor))
        .collect();
    let figure = Figure::new(WIDTH, HEIGHT * panels.len().max(1) as f64).columns(1).legend(LegendPlace::Lines);
    panels.into_iter().fold(figure, Figure::panel).draw()
}

/// Values of one benchmark over the number of the record.
struct Curve<'a> {
    name: &'a str,
    style: SeriesStyle,
    points: Vec<(f64, f64)>,
}

impl Curve<'_> {
    /// The points over the first value.
    fn relative(&self) -> impl Iterator<Item = (f64, f64)> {
        let first = self.points.first().map_or(1.0, |(_, first)| *first);
        self.points.iter().map(move |(x, value)| (*x, value / first))
    }

    fn label(&self) -> String {
        self.name.replace('/', " ")
    }
}

/// With room for labels above the curves.
fn y_axis(curves: &[Curve<'_>]) -> Axis {
    let values = || curves.iter().flat_map(Curve::relative).map(|(_, value)| value);
    let (low, high) = (values().fold(0.95, f64::min), values().fold(1.05, f64::max));
    Axis::linear("relative to first record").range(low - 0.05 * (high - low), high + 0.25 * (high - low))
}

/// Adds the curves, and a line wherever some of them step.
fn relative_to_first(mut panel: Panel, curves: &[Curve<'_>], floor: f64) -> Panel {
    let mut found: Vec<(f64, f64)> = Vec::new();
    for curve in curves {
        let values: Vec<f64> = curve.points.iter().map(|(_, value)| *value).collect();
        found.extend(steps(&values, floor).iter().map(|step| (curve.points[step.at].0 - 0.5, step.ratio)));
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.ln().abs().total_cmp(&a.1.ln().abs())));
    for here in found.chunk_by(|a, b| a.0 == b.0) {
        let (x, ratio) = &here[0];
        let label = match here.len() {
            1 => format!("× {ratio:.3}"),
            steps => format!("{steps} step, × {ratio:.3}"),
        };
        panel = panel.guide(Guide::Vertical { x: *x, label });
    }
    for curve in curves.iter().filter(|curve| !curve.points.is_empty()) {
        let series = Series::new(curve.label(), curve.relative().collect(), curve.style);
        panel = panel.series(series.mode(Mode::LineMarkers));
    }
    panel
}
