//! The cases with their drawings, in JSON for a page.

use rimbench_cases::cases::{Case, Channel, Drawing, Fill, Form, Point, Shape, Solid, camera, offered_steps_ms};
use std::fmt::Write;

/// Writes a case with its drawing; `refused` are the schemes that it is not run with.
///
/// ```text
/// { name, title, about, of_start, shown_ms, steps_ms: [numbers], schemes: [two names], refused: [names], contact: [two texts] or null,
///   force: { column, label, unit, gain },
///   drawing: { view: { x, y, follow }, frames: [{ name, parent, x, y, angle }], shapes: [{ kind, … }] } }
/// ```
/// A channel is a number or `{ column, gain, plus }`; a point `[x, y, frame or null]`. A scene has the directions of its camera and solids
/// `{ pose: [six channels], fill, gap, corners, faces }`, `{ …, ball: radius }` or `{ …, rod: [from, to], width }`.
pub fn case(case: &Case, drawing: &Drawing, refused: &[&str]) -> String {
    let [title, about] = drawing.title.map(text);
    let column = &case.interface_columns[0].force;
    let frames: Vec<String> = drawing
        .frames
        .iter()
        .map(|frame| {
            let [x, y, angle] = frame.pose.map(channel);
            let (name, parent) = (text(frame.name), frame.parent.map_or("null".to_owned(), text));
            format!("{{\"name\":{name},\"parent\":{parent},\"x\":{x},\"y\":{y},\"angle\":{angle}}}")
        })
        .collect();
    let shapes: Vec<String> = drawing.shapes.iter().map(shape).collect();
    let (unit, gain) = if drawing.in_kilonewtons { ("kN", 1e-3) } else { ("N", 1.0) };
    let mut json = String::new();
    let _ = write!(
        json,
        "{{\"name\":{},\"title\":{title},\"about\":{about},\"of_start\":{},\"shown_ms\":{:?},\"steps_ms\":{:?},\"schemes\":{},\"refused\":{},\"contact\":{},\
         \"force\":{{\"column\":{},\"label\":{},\"unit\":\"{unit}\",\"gain\":{gain:?}}},\
         \"drawing\":{{\"view\":{{\"x\":{:?},\"y\":{:?},\"follow\":{}}},\"frames\":{},\"shapes\":{}}}}}",
        text(&case.name),
        drawing.of_start,
        case.shown_step_ms,
        offered_steps_ms(case.defaults.macro_step_s),
        list(drawing.schemes.map(text)),
        list(refused.iter().map(|name| text(name))),
        drawing.contact.map_or("null".to_owned(), |words| list(words.map(text))),
        text(column),
        text(drawing.force),
        drawing.view[0],
        drawing.view[1],
        drawing.follow.map_or("null".to_owned(), text),
        list(frames),
        list(shapes),
    );
    json
}

/// Writes a list.
pub fn list(items: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", items.into_iter().collect::<Vec<_>>().join(","))
}

/// Names and sentences of cases are written in this crate's sources: quotes and backslashes are all that JSON minds of them.
fn text(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

fn channel(channel: Channel) -> String {
    match channel {
        Channel::Fixed(value) => format!("{value:?}"),
        Channel::Column(column, gain, plus) => {
            format!("{{\"column\":{},\"gain\":{gain:?},\"plus\":{plus:?}}}", text(column))
        }
    }
}

fn point((point, frame): &Point) -> String {
    format!("[{:?},{:?},{}]", point[0], point[1], frame.map_or("null".to_owned(), text))
}

fn fill(fill: Fill) -> &'static str {
    match fill {
        Fill::Scheme => "scheme",
        Fill::Metal => "metal",
        Fill::Ground => "ground",
    }
}

fn shape(shape: &Shape) -> String {
    match shape {
        Shape::Polygon(points, filling) => {
            format!(
                "{{\"kind\":\"polygon\",\"points\":{},\"fill\":\"{}\"}}",
                list(points.iter().map(point)),
                fill(*filling)
            )
        }
        Shape::Disc { at, radius, spoke, fill: filling } => format!(
            "{{\"kind\":\"disc\",\"at\":{},\"radius\":{radius:?},\"spoke\":{spoke},\"fill\":\"{}\"}}",
            point(at),
            fill(*filling)
        ),
        Shape::Line(points) => format!("{{\"kind\":\"line\",\"points\":{}}}", list(points.iter().map(point))),
        Shape::Spring(from, to, width) => {
            format!("{{\"kind\":\"spring\",\"from\":{},\"to\":{},\"width\":{width:?}}}", point(from), point(to))
        }
        Shape::Cylinder { from, to, barrel, width } => format!(
            "{{\"kind\":\"cylinder\",\"from\":{},\"to\":{},\"barrel\":{barrel:?},\"width\":{width:?}}}",
            point(from),
            point(to)
        ),
        Shape::Arrow { column, at, along, scale } => format!(
            "{{\"kind\":\"arrow\",\"column\":{},\"at\":{},\"along\":{along:?},\"scale\":{scale:?}}}",
            text(column),
            point(at)
        ),
        Shape::Scene(solids) => {
            format!("{{\"kind\":\"scene\",\"camera\":{:?},\"solids\":{}}}", camera(), list(solids.iter().map(solid)))
        }
    }
}

fn solid(Solid { pose, form, fill: filling, gap }: &Solid) -> String {
    let form = match form {
        Form::Hull(corners, faces) => format!("\"corners\":{corners:?},\"faces\":{faces:?}"),
        Form::Ball(radius) => format!("\"ball\":{radius:?}"),
        Form::Rod(from, to, width) => format!("\"rod\":[{from:?},{to:?}],\"width\":{width:?}"),
    };
    let gap = gap.map_or("null".to_owned(), text);
    format!("{{\"pose\":{},\"fill\":\"{}\",\"gap\":{gap},{form}}}", list(pose.map(channel)), fill(*filling))
}
