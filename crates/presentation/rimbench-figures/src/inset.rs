//! Draws a magnified part of a panel inside the panel.

use super::axes::{TICK, axes, crisp, fitting_ticks, label_width};
use super::chart::{Inset, Panel};
use super::clip::Rect;
use super::data::{self, Frame};
use super::drawing::{Color, Drawing, Stroke};
use super::scale::AxisMap;

/// Draws the inset over the panel, tied to the part it magnifies.
pub fn draw(drawing: &mut Drawing, outer: &Frame, panel: &Panel, inset: &Inset) {
    let [left, bottom, width, height] = inset.place;
    let (across, up) = (outer.area.width(), outer.area.height());
    let area = Rect {
        left: crisp(outer.area.left + left * across),
        top: crisp(outer.area.bottom - (bottom + height) * up),
        right: crisp(outer.area.left + (left + width) * across),
        bottom: crisp(outer.area.bottom - bottom * up),
    };
    let ((x0, x1), (y0, y1)) = (inset.x, inset.y);
    let frame = Frame {
        area,
        band: 0.0,
        band_label: "",
        x: AxisMap { scale: panel.x.scale, low: x0, high: x1, start: area.left, end: area.right },
        y: AxisMap { scale: panel.y.scale, low: y0, high: y1, start: area.bottom, end: area.top },
    };
    let places = [outer.x.position(x0), outer.x.position(x1), outer.y.position(y1), outer.y.position(y0)];
    let [Some(from), Some(to), Some(top), Some(base)] = places else { return };
    let clamp = |v: f64, low: f64, high: f64| v.max(low).min(high);
    let source = Rect {
        left: clamp(from, outer.area.left, outer.area.right),
        right: clamp(to, outer.area.left, outer.area.right),
        top: clamp(top, outer.area.top, outer.area.bottom),
        bottom: clamp(base, outer.area.top, outer.area.bottom),
    };
    let thin = Stroke::solid(Color(0x8A, 0x91, 0x98), 0.9);
    let (x_ticks, y_ticks) = (fitting_ticks(&frame.x), frame.y.ticks((area.height() / 28.0) as usize));
    let widest = y_ticks.ticks.iter().map(|tick| label_width(&tick.label)).fold(0.0, f64::max);
    let paper = Rect {
        left: area.left - widest - TICK - 7.0,
        top: area.top - 6.0,
        right: area.right + 6.0,
        bottom: area.bottom + TICK + 17.0,
    };
    drawing.area(paper.corners(), Some(Color::WHITE), None);
    // Two lines from the magnified part to its picture, from the sides that face each other.
    let right_of = area.left >= source.right;
    let (near, far) = if right_of { (source.right, area.left) } else { (source.left, area.right) };
    let beside = right_of || area.right <= source.left;
    if beside {
        drawing.line(vec![(near, source.top), (far, area.top)], thin);
        drawing.line(vec![(near, source.bottom), (far, area.bottom)], thin);
    } else {
        let (near, far) = if area.bottom <= source.top { (source.top, area.bottom) } else { (source.bottom, area.top) };
        drawing.line(vec![(source.left, near), (area.left, far)], thin);
        drawing.line(vec![(source.right, near), (area.right, far)], thin);
    }
    drawing.area(source.corners(), None, Some(thin));
    axes(drawing, &frame, &x_ticks, &y_ticks);
    for series in &panel.series {
        // One of one: no room for signs on steps.
        data::draw(drawing, &frame, series, (0, 1), &[]);
    }
    drawing.area(area.corners(), None, Some(thin));
}
