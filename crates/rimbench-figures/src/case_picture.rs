//! Draws a case from what it says of itself: for its page in the book, and for those who find a link to the page of the paper.

use super::clip::Rect;
use super::drawing::{Anchor, Color, Drawing, Point, Stroke, Text};
use super::figures::trace_path;
use super::style::Styles;
use rimbench_cases::cases::{Case, Channel, Drawing as CaseDrawing, Fill, Point as CasePoint, Shape};
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::{ResultsTable, read_table};
use std::collections::BTreeMap;
use std::path::Path;

/// Width of a picture in the book, px.
const WIDTH: f64 = 560.0;
const METAL: Color = Color(0xC9, 0xCE, 0xD4);
const GROUND: Color = Color(0xE4, 0xE7, 0xEA);
/// By how much the preview enlarges what a run does otherwise than the reference.
const ENLARGED: f64 = 12.0;
/// The instant of the preview, s: the box with the smooth model is in the air.
const INSTANT: f64 = 1.75;

/// Draws a case, given the value of each column.
pub fn picture(case: &Case, of: &CaseDrawing, value: &dyn Fn(&str) -> f64) -> Drawing {
    let [x, y] = of.view;
    let height = (WIDTH * (y[1] - y[0]) / (x[1] - x[0])).clamp(90.0, 330.0).round();
    let mut drawing = Drawing::new(WIDTH, height);
    drawing.title = format!("The case {}", case.name);
    drawing.description = format!("{}, as it starts.", case.about);
    let place = Rect { left: 0.0, top: 0.0, right: WIDTH, bottom: height };
    draw(&mut drawing, of, value, place, Color(0x00, 0x72, 0xB2));
    drawing
}

/// Where a frame is: x, y, cosine and sine of its angle.
type Pose = [f64; 4];

/// Draws a case into a place, its scheme in a colour.
fn draw(drawing: &mut Drawing, of: &CaseDrawing, value: &dyn Fn(&str) -> f64, place: Rect, color: Color) {
    let channel = |channel: Channel| match channel {
        Channel::Fixed(value) => value,
        Channel::Column(column, gain, plus) => gain * value(column) + plus,
    };
    let mut poses: BTreeMap<&str, Pose> = BTreeMap::new();
    let within = |[px, py, cos, sin]: Pose, [x, y]: [f64; 2]| [px + cos * x - sin * y, py + sin * x + cos * y];
    for frame in &of.frames {
        let parent = frame.parent.map_or([0.0, 0.0, 1.0, 0.0], |parent| poses[parent]);
        let [x, y] = within(parent, [channel(frame.pose[0]), channel(frame.pose[1])]);
        let (sin, cos) = channel(frame.pose[2]).sin_cos();
        poses.insert(frame.name, [x, y, cos, sin]);
    }
    let [[left, right], [low, high]] = of.view;
    let scale = (place.width() / (right - left)).min(place.height() / (high - low));
    let (middle, follow) = (place.centre(), of.follow.map_or(0.0, value));
    let screen = |[x, y]: [f64; 2]| {
        (middle.0 + scale * (x - follow - 0.5 * (left + right)), middle.1 - scale * (y - 0.5 * (low + high)))
    };
    let at = |(point, frame): &CasePoint| within(frame.map_or([0.0, 0.0, 1.0, 0.0], |frame| poses[frame]), *point);
    let outline = Some(Stroke::solid(Color::INK, 1.1));
    // Ground and cylinders go on beyond the place.
    let kept = |x: f64| x.clamp(place.left, place.right);
    let fill = |fill: Fill| match fill {
        Fill::Scheme => color.mix(Color::WHITE, 0.6),
        Fill::Metal => METAL,
        Fill::Ground => GROUND,
    };
    // Along a line from one point to another, and to its left.
    let beside = |from: [f64; 2], to: [f64; 2]| {
        let [across, up] = [to[0] - from[0], to[1] - from[1]];
        let length = across.hypot(up).max(1e-12);
        let point = move |along: f64, aside: f64| {
            [from[0] + (along * across - aside * up) / length, from[1] + (along * up + aside * across) / length]
        };
        (length, point)
    };
    for shape in &of.shapes {
        match shape {
            Shape::Polygon(points, filling) => {
                let inside = |(x, y): Point| match filling {
                    Fill::Ground => (kept(x), y.clamp(place.top, place.bottom)),
                    _ => (x, y),
                };
                let corners = points.iter().map(|point| inside(screen(at(point)))).collect();
                drawing.area(corners, Some(fill(*filling)), outline);
            }
            Shape::Line(points) => {
                drawing.line(points.iter().map(|point| screen(at(point))).collect(), Stroke::solid(Color::INK, 1.1))
            }
            Shape::Disc { at: centre, radius, fill: filling, .. } => {
                drawing.disc(screen(at(centre)), scale * radius, Some(fill(*filling)), outline);
            }
            Shape::Spring(from, to, width) => {
                let (length, point) = beside(at(from), at(to));
                let turn = |k: u32| {
                    let side = if k.is_multiple_of(2) { 0.5 } else { -0.5 };
                    screen(point(length * (0.16 + 0.068 * f64::from(k)), side * width))
                };
                let mut zigzag = vec![screen(point(0.0, 0.0)), screen(point(0.12 * length, 0.0))];
                zigzag.extend((0..11).map(turn));
                zigzag.extend([screen(point(0.88 * length, 0.0)), screen(point(length, 0.0))]);
                drawing.line(zigzag, Stroke::solid(Color::INK, 1.1));
            }
            Shape::Cylinder { from, to, barrel, width } => {
                let (length, point) = beside(at(from), at(to));
                for (start, end, half) in
                    [(0.2 * (length - barrel).max(0.0), length, 0.15 * width), (0.0, *barrel, 0.5 * width)]
                {
                    let corners = [[start, -half], [end, -half], [end, half], [start, half]];
                    let corners = corners.map(|[along, aside]| screen(point(along, aside))).map(|(x, y)| (kept(x), y));
                    drawing.area(corners.to_vec(), Some(METAL), outline);
                }
            }
            Shape::Arrow { .. } => {}
        }
    }
}

/// Draws what a link to the page of the paper shows, 600 × 315 px: both models of the source paper after touch-down.
///
/// # Errors
/// [`Error::File`] for traces that are not there.
pub fn preview(folder: &Path, of: &CaseDrawing, styles: &Styles) -> Result<Drawing> {
    let trace = |label: &str| -> Result<(ResultsTable, usize)> {
        let table = read_table(&trace_path(folder, label)?)?;
        let time = table.column("time_s")?;
        let row = (0..table.len()).find(|&row| table.number(row, time) >= INSTANT - 1e-9);
        row.map(|row| (table, row)).ok_or_else(|| Error::file(folder, format!("has no row at {INSTANT} s")))
    };
    let number = |(table, row): &(ResultsTable, usize), column: &str| {
        table.column(column).map_or(0.0, |column| table.number(*row, column))
    };
    let reference = trace("reference")?;
    let mut drawing = Drawing::new(600.0, 315.0);
    let question = "How long may the macro step be?";
    drawing.title = question.to_owned();
    drawing.text(Text::new(question, (20.0, 44.0), 27.0).bold());
    let words = "Co-simulation of a machine with contacts: the same macro step, two interface models";
    drawing.text(Text::new(words, (20.0, 70.0), 14.0).colored(Color::SOFT_INK));
    for (label, said, left) in [("rim-smooth", "lifts off", 10.0), ("rim-nonsmooth", "stays down", 305.0)] {
        let (run, color) = (trace(label)?, styles.of_label(label).color);
        let value = |column: &str| {
            let level = number(&reference, column);
            level + ENLARGED * (number(&run, column) - level)
        };
        let place = Rect { left, top: 88.0, right: left + 285.0, bottom: 252.0 };
        let value: &dyn Fn(&str) -> f64 =
            &|column| if of.follow == Some(column) { number(&reference, column) } else { value(column) };
        draw(&mut drawing, of, value, place, color);
        let middle = (left + 142.5, 276.0);
        let name = Text::new(format!("{}: {said}", styles.shown_name(label)), middle, 15.0).bold();
        drawing.text(name.anchored(Anchor::Middle).colored(color));
    }
    let words = format!("rimbench · H = 5 ms, differences from the reference {ENLARGED} times larger");
    drawing.text(Text::new(words, (300.0, 303.0), 11.0).anchored(Anchor::Middle).colored(Color::SOFT_INK));
    Ok(drawing)
}
