//! The cases with their drawings, in JSON for a page.

use rimbench_cases::cases::{
    Case, Channel, Drawing, Fill, Form, Point, Shape, Solid, camera, coordinate_column, offered_steps_ms,
};
use rimbench_cases::parameter::Value as Number;
use serde_json::{Value, json};

/// Returns a case with its drawing; `refused` are the schemes that it is not run with.
///
/// ```text
/// { name, title, about, shown_ms, steps_ms: [numbers], schemes: [two names], refused: [names], contact: [two texts] or null,
///   force: { column, label, unit, gain }, knobs: { mass, stiffness, friction: [parameter, default, words] or null },
///   drawing: { view: { x, y, follow }, frames: [{ name, parent, x, y, angle }], shapes: [{ kind, … }] } }
/// ```
/// A channel is a number or `{ column, gain, plus }`; a point `[x, y, frame or null]`. A scene has the directions of
/// its camera and solids `{ pose: [six channels], fill, gap, corners, faces }`, `{ …, ball: radius }` or
/// `{ …, rod: [from, to], width }`.
pub fn case(case: &Case, drawing: &Drawing, refused: &[&str]) -> Value {
    let [title, about] = drawing.title;
    let frames = drawing.frames.iter().map(|frame| {
        let [x, y, angle] = frame.pose.map(channel);
        json!({ "name": frame.name, "parent": frame.parent, "x": x, "y": y, "angle": angle })
    });
    let (unit, gain) = if drawing.in_kilonewtons { ("kN", 1e-3) } else { ("N", 1.0) };
    let [x, y] = drawing.view;
    json!({
        "name": case.name,
        "title": title,
        "about": about,
        "shown_ms": case.shown_step_ms,
        "steps_ms": offered_steps_ms(case.defaults.macro_step_s),
        "schemes": drawing.schemes,
        "refused": refused,
        "contact": drawing.contact,
        "force": { "column": case.interface_columns[0].force, "label": drawing.force, "unit": unit, "gain": gain },
        "knobs": knobs(case),
        "drawing": {
            "view": { "x": x, "y": y, "follow": drawing.follow },
            "frames": frames.collect::<Vec<_>>(),
            "shapes": drawing.shapes.iter().map(shape).collect::<Vec<_>>(),
        },
    })
}

/// What has a slider of a machine, each as `[parameter, default, words]` or null.
fn knobs(case: &Case) -> Value {
    let of = |wanted: &[&str]| {
        let is_wanted = |name: &str| wanted.iter().any(|end| name.ends_with(end));
        case.parameters.iter().find_map(|parameter| match parameter.default {
            Number::Number(start) if start > 0.0 && is_wanted(&parameter.name) => {
                Some(json!([&*parameter.name, start, &*parameter.about]))
            }
            _ => None,
        })
    };
    json!({
        "mass": of(&["mass_kg"]),
        "stiffness": of(&["compressibility_a_1_pa", "spring_stiffness_n_m"]),
        "friction": of(&["viscous_friction_n_s_m", "spring_damping_n_s_m"]),
    })
}

fn channel(channel: Channel) -> Value {
    match channel {
        Channel::Fixed(value) => value.into(),
        Channel::Coordinate(index) => json!({ "column": coordinate_column(index), "gain": 1, "plus": 0 }),
        Channel::Column(column, gain, plus) => json!({ "column": column, "gain": gain, "plus": plus }),
    }
}

fn point(([x, y], frame): &Point) -> Value {
    json!([x, y, frame])
}

fn points(points: &[Point]) -> Value {
    points.iter().map(point).collect()
}

fn fill(fill: Fill) -> &'static str {
    match fill {
        Fill::Scheme => "scheme",
        Fill::Metal => "metal",
        Fill::Ground => "ground",
    }
}

fn shape(shape: &Shape) -> Value {
    match shape {
        Shape::Polygon(corners, filling) => {
            json!({ "kind": "polygon", "points": points(corners), "fill": fill(*filling) })
        }
        Shape::Disc { at, radius, spoke, fill: filling } => {
            json!({ "kind": "disc", "at": point(at), "radius": radius, "spoke": spoke, "fill": fill(*filling) })
        }
        Shape::Discs(centres, radius, filling) => {
            let centres = centres.iter().map(|centre| centre.map(channel)).collect::<Vec<_>>();
            json!({ "kind": "discs", "centres": centres, "radius": radius, "fill": fill(*filling) })
        }
        Shape::Line(line) => json!({ "kind": "line", "points": points(line) }),
        Shape::Spring(from, to, width) => {
            json!({ "kind": "spring", "from": point(from), "to": point(to), "width": width })
        }
        Shape::Cylinder { from, to, barrel, width } => {
            json!({ "kind": "cylinder", "from": point(from), "to": point(to), "barrel": barrel, "width": width })
        }
        Shape::Arrow { column, at, along, scale } => {
            json!({ "kind": "arrow", "column": column, "at": point(at), "along": along, "scale": scale })
        }
        Shape::Scene(solids) => {
            json!({ "kind": "scene", "camera": camera(), "solids": solids.iter().map(solid).collect::<Vec<_>>() })
        }
    }
}

fn solid(Solid { pose, form, fill: filling, gap }: &Solid) -> Value {
    let mut solid = json!({ "pose": pose.map(channel), "fill": fill(*filling), "gap": gap });
    match form {
        Form::Hull(corners, faces) => {
            solid["corners"] = json!(corners);
            solid["faces"] = json!(faces);
        }
        Form::Ball(radius) => solid["ball"] = json!(radius),
        Form::Rod(from, to, width) => {
            solid["rod"] = json!([from, to]);
            solid["width"] = json!(width);
        }
    }
    solid
}
