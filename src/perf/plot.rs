//! The history as a figure: instructions and times relative to the first record, with the steps found in them.

use super::history::{History, Row};
use super::steps::steps;
use crate::report::chart::{Axis, Figure, Guide, LegendPlace, Mode, Panel, Series};
use crate::report::drawing::Drawing;
use crate::report::style::{SeriesStyle, style_in_list};

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 640.0;
/// Relative change of a time below which no step is drawn: code layout alone does as much.
const TIME_FLOOR: f64 = 0.05;

/// Draws the records of the newest machine, target and compiler; the records are numbered as in the whole history.
///
/// Steps are vertical lines labelled with the benchmark and the ratio of the levels.
pub fn draw_history(history: &History) -> Drawing {
    let records = history.records();
    let alike = |row: &&Row| {
        history.rows.last().is_some_and(|last| {
            (&row.machine, &row.target, &row.rustc) == (&last.machine, &last.target, &last.rustc) && row.is_ok()
        })
    };
    let rows: Vec<&Row> = history.rows.iter().filter(alike).collect();
    let mut names: Vec<&str> = Vec::new();
    for row in &rows {
        if !names.contains(&row.benchmark.as_str()) {
            names.push(&row.benchmark);
        }
    }
    let x = || Axis::count("record").range(0.5, records.len() as f64 + 0.5);
    let mut counts = Panel::new("(a) instructions", x(), Axis::linear("relative to first record"));
    let mut times = Panel::new("(b) wall time over yardstick", x(), Axis::linear("relative to first record"));
    for (index, name) in names.into_iter().enumerate() {
        let style = style_in_list(index);
        let of = |value: fn(&Row) -> Option<f64>| -> Vec<(f64, f64)> {
            let number = |row: &Row| records.iter().position(|record| *record == row.record).map(|at| at as f64 + 1.0);
            let rows = rows.iter().filter(|row| row.benchmark == name);
            rows.filter_map(|row| number(row).zip(value(row))).collect()
        };
        let label = name.replace('/', " ");
        counts = with_series(counts, &label, style, &of(|row| row.instructions.map(|count| count as f64)), 0.0);
        times = with_series(times, &label, style, &of(|row| row.time_ratio), TIME_FLOOR);
    }
    Figure::new(WIDTH, HEIGHT).columns(1).legend(LegendPlace::Right).panel(counts).panel(times).draw()
}

fn with_series(mut panel: Panel, name: &str, style: SeriesStyle, points: &[(f64, f64)], floor: f64) -> Panel {
    let Some(&(_, first)) = points.first() else { return panel };
    let values: Vec<f64> = points.iter().map(|(_, value)| *value).collect();
    for step in steps(&values, floor) {
        let label = format!("{name} × {:.3}", step.ratio);
        panel = panel.guide(Guide::Vertical { x: points[step.at].0 - 0.5, label });
    }
    let relative = points.iter().map(|(x, value)| (*x, value / first)).collect();
    panel.series(Series::new(name, relative, style).mode(Mode::LineMarkers))
}
