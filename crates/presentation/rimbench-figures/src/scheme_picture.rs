//! Draws what each side knows between two exchanges, from a scheme's own facts: a timeline for its page in the book.

use super::drawing::{Anchor, Color, Drawing, Point, Stroke, Text};
use rimbench_core::cosim::{ForceReturn, Sequence, Side};
use rimbench_core::error::Result;
use rimbench_core::iterative::IterativeDriver;
use rimbench_core::schemes::{InformationClass, SchemeEntry};

const SIZE: [f64; 2] = [560.0, 196.0];
/// Heights of mechanics and actuator, and where the communication points `k − 2` to `k + 1` are.
const LANES: [f64; 2] = [40.0, 112.0];
const POINTS: [f64; 4] = [120.0, 215.0, 310.0, 500.0];
const NAMES: [&str; 4] = ["t(k−2)", "t(k−1)", "t(k)", "t(k+1)"];
const USED: Color = Color(0x00, 0x72, 0xB2);
const TEXT: f64 = 12.0;

/// Draws the timeline of a scheme as it is used by default: samples that it uses, who steps first, what is passed on
/// within the step, and in two sentences what each side knows of the other meanwhile.
///
/// # Errors
/// As [`SchemeEntry::sequence_and_return`].
pub fn timeline(scheme: &SchemeEntry) -> Result<Drawing> {
    let (sequence, back) = scheme.sequence_and_return(None, None)?;
    let [actuator, mechanics] = known(scheme, back);
    let mut drawing = Drawing::new(SIZE[0], SIZE[1]);
    drawing.title = format!("What each side knows between two exchanges with {}", scheme.name);
    drawing.description = format!("{actuator} {mechanics}");
    let [from, to] = [POINTS[2], POINTS[3]];
    for (lane, name) in LANES.into_iter().zip(["mechanics", "actuator"]) {
        drawing.text(Text::new(name, (6.0, lane + 4.0), TEXT).bold());
        drawing.line(vec![(POINTS[0] - 20.0, lane), (to + 20.0, lane)], Stroke::solid(Color::SOFT_INK, 1.0));
        for (place, x) in POINTS.into_iter().enumerate().take(3) {
            let is_used = 2 - place < scheme.samples;
            let fill = if is_used { USED } else { Color::WHITE };
            drawing.disc((x, lane), 4.5, Some(fill), Some(Stroke::solid(USED, 1.2)));
        }
        drawing.disc((to, lane), 4.5, Some(Color::WHITE), Some(Stroke::solid(Color::INK, 1.2)));
    }
    for (x, name) in POINTS.into_iter().zip(NAMES) {
        drawing.text(Text::new(name, (x, LANES[1] + 24.0), TEXT).anchored(Anchor::Middle).colored(Color::SOFT_INK));
    }
    let [up, down] = [(LANES[1] - 8.0, LANES[0] + 8.0), (LANES[0] + 8.0, LANES[1] - 8.0)];
    let mut step = |lane: usize, order: &str| {
        arrow(&mut drawing, (from + 9.0, LANES[lane]), (to - 9.0, LANES[lane]), 2.4);
        let at = (0.5 * (from + to), LANES[lane] - 8.0);
        drawing.text(Text::new(order, at, TEXT).anchored(Anchor::Middle));
    };
    let first = match (scheme.driver, sequence) {
        (IterativeDriver::Monolithic, _) => ["both in one, micro step by micro step"; 2],
        (IterativeDriver::Iterated(_), _) => ["steps, again until both agree"; 2],
        (_, Sequence::Jacobi) => ["steps at once"; 2],
        (_, Sequence::GaussSeidel { first: Side::Actuator }) => ["steps second", "steps first"],
        (_, Sequence::GaussSeidel { first: Side::Mechanics }) => ["steps first", "steps second"],
    };
    step(0, first[0]);
    step(1, first[1]);
    // Outputs of t(k) cross over; what the first side found at t(k+1) crosses before the second steps.
    arrow(&mut drawing, (from - 4.0, down.0), (from - 4.0, down.1), 1.2);
    arrow(&mut drawing, (from + 4.0, up.0), (from + 4.0, up.1), 1.2);
    if let (Sequence::GaussSeidel { first }, IterativeDriver::NonIterative) = (sequence, scheme.driver) {
        let (begin, end) = if first == Side::Actuator { up } else { down };
        arrow(&mut drawing, (to, begin), (to, end), 1.8);
    }
    drawing.text(Text::new(actuator, (6.0, SIZE[1] - 28.0), TEXT));
    drawing.text(Text::new(mechanics, (6.0, SIZE[1] - 10.0), TEXT));
    Ok(drawing)
}

/// Says what the actuator knows of the mechanics within a macro step, and the mechanics of the actuator.
fn known(scheme: &SchemeEntry, back: ForceReturn) -> [String; 2] {
    let samples = match scheme.samples {
        1 => "the last sample".to_owned(),
        count => format!("the last {count} samples"),
    };
    let of_mechanics = match InformationClass::of(scheme) {
        InformationClass::Samples => samples.clone(),
        InformationClass::Derivatives => format!("{samples}, and how its outputs follow its inputs"),
        InformationClass::Inside => format!("{samples}, and its own chambers as lines"),
        InformationClass::Model => format!("{samples}, and a reduced model of the mechanics"),
        InformationClass::Repetition => "the other's last attempt at this step".to_owned(),
        InformationClass::Whole => "the mechanics itself".to_owned(),
    };
    let of_actuator = match (InformationClass::of(scheme), back) {
        (InformationClass::Repetition, _) => "the other's last attempt at this step".to_owned(),
        (InformationClass::Whole, _) => "the actuator itself".to_owned(),
        (_, ForceReturn::Held) => samples,
        (_, ForceReturn::End) => "the force at the end of this step".to_owned(),
        (_, ForceReturn::Mean) => "the mean force of this step".to_owned(),
        (_, ForceReturn::Profile | ForceReturn::Pieces) => "the force within this step, in pieces".to_owned(),
    };
    [format!("The actuator knows {of_mechanics}."), format!("The mechanics knows {of_actuator}.")]
}

fn arrow(drawing: &mut Drawing, from: Point, to: Point, width: f64) {
    let (along, across) = ((to.0 - from.0, to.1 - from.1), 3.5 + width);
    let length = along.0.hypot(along.1);
    let (x, y) = (along.0 / length, along.1 / length);
    let neck = (to.0 - 2.0 * across * x, to.1 - 2.0 * across * y);
    let side = |sign: f64| (neck.0 - sign * 0.7 * across * y, neck.1 + sign * 0.7 * across * x);
    drawing.line(vec![from, neck], Stroke::solid(Color::INK, width));
    drawing.area(vec![side(1.0), to, side(-1.0)], Some(Color::INK), None);
}
