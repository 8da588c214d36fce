//! Draws what is not data into a panel: reference lines, slope triangles, remarks.

use super::chart::Guide;
use super::clip::{self, Rect};
use super::data::Frame;
use super::drawing::{Anchor, Color, Drawing, Stroke, Text};

/// Size of remarks, px.
pub const NOTE_SIZE: f64 = 9.4;
const LINE: Stroke = Stroke { color: Color(0x9A, 0xA1, 0xA8), width: 1.0, dash: &[4.0, 3.0] };

/// Where values say nothing.
pub const SHADE: Color = Color(0xDB, 0xDD, 0xDF);

/// Draws the lines of a guide; they belong behind the data.
pub fn draw(drawing: &mut Drawing, frame: &Frame, guide: &Guide) {
    let whole = frame.whole();
    match guide {
        Guide::Horizontal(y) => {
            if let Some(y) = height(frame, *y) {
                drawing.line(vec![(whole.left, y), (whole.right, y)], LINE);
            }
        }
        Guide::Vertical(x, _) => {
            if let Some(x) = frame.x.position(*x) {
                drawing.line(vec![(x, whole.top), (x, frame.area.bottom)], LINE);
            }
        }
        Guide::Below(y) => {
            let Some(y) = frame.y.position(*y).filter(|y| *y < whole.bottom) else { return };
            let shaded = Rect { top: y.max(frame.area.top), ..frame.area };
            drawing.area(shaded.corners(), Some(SHADE), None);
            if y > frame.area.top {
                drawing.line(vec![(whole.left, y), (whole.right, y)], LINE);
            }
        }
        Guide::Slope { order, from, to_x } => {
            if let Some([left, right, base, tip]) = slope(frame, *order, *from, *to_x) {
                let corners = clip::polygon(&[(left, base), (right, base), (right, tip)], &frame.area);
                let outline = Stroke::solid(Color(0x8A, 0x91, 0x98), 1.0);
                drawing.area(corners, Some(Color(0xF1, 0xF3, 0xF5)), Some(outline));
            }
        }
    }
}

/// Writes what a guide means; this belongs in front of the data.
pub fn label(drawing: &mut Drawing, frame: &Frame, guide: &Guide) {
    let area = &frame.area;
    match guide {
        // The legend says what is shaded: in words only where they hide nothing.
        Guide::Below(y) => {
            let Some(y) = height(frame, *y).filter(|y| y + NOTE_SIZE + 6.0 <= area.bottom) else { return };
            let at = (area.right - 5.0, y + 5.0 + 0.73 * NOTE_SIZE);
            let text = Text::new("uncertainty of the reference", at, NOTE_SIZE).anchored(Anchor::End);
            if text.width() + 10.0 <= area.width() {
                drawing.text(text.colored(Color::SOFT_INK));
            }
        }
        Guide::Horizontal(_) => {}
        Guide::Vertical(x, label) => {
            if let Some(x) = frame.x.position(*x) {
                on_paper(drawing, Text::new(label, (x + 5.0, area.top + 1.4 * NOTE_SIZE), NOTE_SIZE));
            }
        }
        Guide::Slope { order, from, to_x } => {
            let Some([left, right, base, tip]) = slope(frame, *order, *from, *to_x) else { return };
            let (outwards, anchor) = if right > left { (5.0, Anchor::Start) } else { (-5.0, Anchor::End) };
            let rise = Text::new(format!("{order}"), (right + outwards, 0.5 * (base + tip)), NOTE_SIZE);
            on_paper(drawing, rise.anchored(anchor).centred());
            let below = if tip < base { base + 5.0 + 0.73 * NOTE_SIZE } else { base - 5.0 };
            let run = Text::new("1", (0.5 * (left + right), below), NOTE_SIZE);
            on_paper(drawing, run.anchored(Anchor::Middle));
        }
    }
}

/// Draws a remark on a patch of paper, as that of its number from below.
pub fn note(drawing: &mut Drawing, frame: &Frame, number: usize, note: &str) {
    let area = &frame.area;
    let up = 0.04 + 0.06 * number as f64;
    let at = (area.left + 0.03 * area.width(), area.bottom - up * area.height());
    on_paper(drawing, Text::new(note, at, NOTE_SIZE).centred());
}

fn height(frame: &Frame, y: f64) -> Option<f64> {
    frame.y.position(y).filter(|p| (frame.area.top..=frame.area.bottom).contains(p))
}

/// Edges of a slope triangle on the page: x₀, x₁, y₀, y₁.
fn slope(frame: &Frame, order: f64, (x0, y0): (f64, f64), x1: f64) -> Option<[f64; 4]> {
    let y1 = y0 * (x1 / x0).powf(order);
    Some([frame.x.position(x0)?, frame.x.position(x1)?, frame.y.position(y0)?, frame.y.position(y1)?])
}

/// Writes a text on a white patch, so that lines below do not cross the letters.
fn on_paper(drawing: &mut Drawing, text: Text) {
    if text.content.is_empty() {
        return;
    }
    let (left, right) = (text.at.0 - text.lead() - 2.0, text.at.0 - text.lead() + text.width() + 2.0);
    let (top, bottom) = (text.at.1 - 0.8 * text.size, text.at.1 + 0.24 * text.size);
    let patch = vec![(left, top), (right, top), (right, bottom), (left, bottom)];
    drawing.area(patch, Some(Color::WHITE), None);
    drawing.text(text.colored(Color::SOFT_INK));
}
