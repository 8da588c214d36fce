//! What the cases with a spring actuator share.

use super::prelude::*;

/// The interface of a carriage and what it pushes.
pub(super) fn interface() -> Vec<InterfaceColumns> {
    vec![InterfaceColumns::new("interface_position_m", "interface_velocity_m_s", "actuator_force_n")]
}

/// The columns of a trace of a carriage and what it pushes.
pub(super) fn trace_columns(own: &str) -> Vec<Name> {
    trace_of(&interface(), "", &[], own)
}

/// What holds a body, drawn: a spring to the carriage and one to the base, each `reach` long where it is relaxed,
/// towards `away` from the body. Without a base the carriage is what shakes.
pub(super) fn springs([x, y]: [f64; 2], away: [f64; 2], reach: f64, base: Option<f64>) -> (Vec<Frame>, Vec<Shape>) {
    let place = |column: &'static str, far: f64| {
        let along = |start: f64, away: f64| match away {
            0.0 => Channel::Fixed(start),
            _ => Channel::Column(column, 1.0, start + away * far),
        };
        [along(x, away[0]), along(y, away[1])]
    };
    let [body, carriage] = [place("interface_position_m", 0.0), place("carriage_position_m", reach)];
    let frames = vec![frame("body", body[0], body[1], 0.0), frame("carriage", carriage[0], carriage[1], 0.0)];
    let (middle, half) = (|name| ([0.0, 0.0], Some(name)), 0.06);
    let size = [0.12, 0.06].map(|length| if away[0] == 0.0 { length } else { 0.18 - length });
    let mut shapes = vec![Shape::Spring(middle("carriage"), middle("body"), half)];
    if let Some(base) = base {
        let end = [(x, away[0]), (y, away[1])].map(|(start, away)| start + base * away.abs() + 2.0 * reach * away);
        shapes.push(Shape::Spring((end, None), middle("carriage"), half));
        let [w, h] = size.map(|length| 0.7 * length);
        shapes.push(wall([end[0] - w, end[1] - h], [end[0] + w, end[1] + h]));
    }
    let fill = if base.is_none() { Fill::Ground } else { Fill::Metal };
    shapes.push(Shape::Polygon(rectangle("carriage", [0.0, 0.0], size), fill));
    (frames, shapes)
}
