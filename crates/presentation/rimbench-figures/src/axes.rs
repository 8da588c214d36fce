//! Draws axes: ticks, grid lines and what stands beside them, in charts, dot plots and maps.

use super::clip::Rect;
use super::data::Frame;
use super::drawing::{Anchor, Color, Drawing, Stroke, Text, Weight};
use super::font;
use super::scale::AxisMap;
use super::ticks::{Tick, Ticks};

/// Size of tick labels, px: 7 pt, at the size that a figure has on paper.
pub const TICK_SIZE: f64 = 9.4;
/// Size of axis labels, px.
pub const LABEL_SIZE: f64 = 10.0;
/// Size of panel titles, px.
pub const TITLE_SIZE: f64 = 10.6;
/// Room below the plotting area for tick labels and the axis label, px.
pub const BELOW: f64 = 35.0;

/// Length of a tick, px.
pub const TICK: f64 = 3.0;
/// The line of an axis.
pub const AXIS: Stroke = Stroke { color: Color::SOFT_INK, width: 0.8, dash: &[] };
/// A line of the grid.
pub const GRID: Stroke = Stroke { color: Color::GRID, width: 0.8, dash: &[] };

/// Draws the background, grid, axes and tick labels of a frame.
pub fn axes(drawing: &mut Drawing, frame: &Frame, x_ticks: &Ticks, y_ticks: &Ticks) {
    let (area, whole) = (&frame.area, frame.whole());
    drawing.area(whole.corners(), Some(Color::WHITE), None);
    ticks_below(drawing, &frame.x, x_ticks, area.bottom, whole.top);
    for tick in &y_ticks.ticks {
        let Some(y) = frame.y.position(tick.value).map(crisp) else { continue };
        if !tick.label.is_empty() {
            drawing.line(vec![(area.left, y), (area.right, y)], GRID);
        }
        drawing.line(vec![(area.left - length(&tick.label), y), (area.left, y)], AXIS);
        drawing.text(tick_label(&tick.label, (area.left - TICK - 4.0, y), Anchor::End));
    }
    drawing.line(vec![(whole.left, whole.top), (whole.right, whole.top), (whole.right, whole.bottom)], GRID);
    if frame.band > 0.0 {
        let edge = Stroke { dash: &[1.5, 2.5], ..AXIS };
        drawing.line(vec![(area.left, area.top), (area.right, area.top)], edge);
        drawing.line(vec![(area.left - TICK, frame.beyond()), (area.left, frame.beyond())], AXIS);
        let size = if frame.band_label == "∞" { 12.0 } else { TICK_SIZE };
        let label = tick_label(frame.band_label, (area.left - TICK - 4.0, frame.beyond() + 0.6), Anchor::End);
        drawing.text(Text { size, ..label });
    }
    drawing.line(vec![(whole.left, whole.top), (whole.left, whole.bottom), (whole.right, whole.bottom)], AXIS);
}

/// Draws the ticks of a horizontal axis, with grid lines up to `top`.
pub fn ticks_below(drawing: &mut Drawing, map: &AxisMap, ticks: &Ticks, bottom: f64, top: f64) {
    for Tick { value, label } in &ticks.ticks {
        let Some(x) = map.position(*value).map(crisp) else { continue };
        if !label.is_empty() {
            drawing.line(vec![(x, bottom), (x, top)], GRID);
        }
        tick_below(drawing, (x, bottom), label);
    }
}

/// Draws one tick of a horizontal axis, and what it says.
pub fn tick_below(drawing: &mut Drawing, (x, bottom): (f64, f64), label: &str) {
    drawing.line(vec![(x, bottom), (x, bottom + length(label))], AXIS);
    drawing.text(tick_label(label, (x, bottom + TICK + 7.5), Anchor::Middle));
}

fn length(label: &str) -> f64 {
    if label.is_empty() { 0.6 * TICK } else { TICK }
}

fn tick_label(content: &str, at: (f64, f64), anchor: Anchor) -> Text {
    Text::new(content, at, TICK_SIZE).colored(Color::SOFT_INK).anchored(anchor).centred()
}

/// Writes the heading above an area and the quantity of its horizontal axis below.
pub fn labels(drawing: &mut Drawing, area: &Rect, title: &str, across: &str) {
    drawing.text(Text::new(title, (area.left, area.top - 6.0), TITLE_SIZE).bold());
    let label = Text::new(across, (area.centre().0, area.bottom + BELOW - 6.0), LABEL_SIZE);
    drawing.text(label.anchored(Anchor::Middle));
}

/// Chooses as many ticks as have labels that do not touch.
pub fn fitting_ticks(map: &AxisMap) -> Ticks {
    let length = (map.end - map.start).abs();
    let fits = |ticks: &Ticks| {
        let labelled = ticks.ticks.iter().filter(|tick| !tick.label.is_empty());
        let spans = labelled.filter_map(|tick| Some((map.position(tick.value)?, label_width(&tick.label))));
        let spans: Vec<(f64, f64)> = spans.collect();
        spans.windows(2).all(|pair| (pair[1].0 - pair[0].0).abs() >= 0.5 * (pair[0].1 + pair[1].1) + 6.0)
    };
    let most = (length / 26.0).max(2.0) as usize;
    let choices = (2..=most).rev().map(|count| map.ticks(count));
    choices.into_iter().find(fits).unwrap_or_else(|| map.ticks(2))
}

/// Width of a tick label, px.
pub fn label_width(label: &str) -> f64 {
    font::width(label, TICK_SIZE, Weight::Regular)
}

/// Moves a hairline onto whole pixels.
pub fn crisp(position: f64) -> f64 {
    position.floor() + 0.5
}
