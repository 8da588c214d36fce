//! A case in motion, a cell for each scheme: every frame is drawn as a still is, and the style sheet of the picture
//! shows one after the other.

use super::case_picture::{Motion, View};
use super::clip::Rect;
use super::drawing::{Anchor, Color, Drawing, Stroke, Text};
use super::vector::svg_of_frames;
use rimbench_cases::cases::Drawing as CaseDrawing;

const WIDTH: f64 = 680.0;
const MARGIN: f64 = 8.0;
const BETWEEN: f64 = 8.0;
const LABEL: f64 = 20.0;
const EDGE: Stroke = Stroke { color: Color(0xC9, 0xCE, 0xD3), width: 1.0, dash: &[] };
/// How long each frame is shown, s.
const SHOWN_S: f64 = 0.15;

/// One run, as it is shown.
#[derive(Debug, Clone)]
pub struct Take {
    /// What stands above it.
    pub name: String,
    /// The colour of its bodies.
    pub color: Color,
    /// Its columns.
    pub motion: Motion,
    /// When it failed, s, and what is said from then on.
    pub failed: Option<(f64, String)>,
}

/// Draws runs side by side over thin outlines of the reference, at these instants (s), as an SVG that moves. Where
/// motion is not wanted, the frame `still` stands.
pub fn film(
    (of, reference): (&CaseDrawing, &Motion),
    takes: &[Take],
    (instants_s, still): (&[f64], usize),
    [title, words]: [&str; 2],
) -> String {
    let columns = takes.len().max(1) as f64;
    let cell = ((WIDTH - 2.0 * MARGIN - BETWEEN * (columns - 1.0)) / columns).floor();
    let [[left, right], [low, high]] = of.view;
    let tall = (cell * (high - low) / (right - left)).round();
    let frame = |&instant: &f64| {
        let mut drawing = Drawing::new(WIDTH, 2.0 * MARGIN + LABEL + tall + LABEL);
        for (column, take) in takes.iter().enumerate() {
            let left = MARGIN + column as f64 * (cell + BETWEEN) + 0.5;
            let place = Rect { left, top: LABEL + 0.5, right: left + cell - 1.0, bottom: LABEL + tall - 0.5 };
            let name = Text::new(&take.name, (left, LABEL - 6.0), 10.6).bold();
            drawing.text(name.colored(take.color.mix(Color::INK, 0.15)));
            drawing.area(place.corners(), None, Some(EDGE));
            let Some(at_reference) = reference.row_at(instant) else { continue };
            let view = View { place, follow: reference.follow[at_reference] };
            let failed = take.failed.as_ref().filter(|(from, _)| instant >= *from);
            let finite = |row: &usize| take.motion.columns.values().all(|values| values[*row].is_finite());
            if let Some(row) = take.motion.row_at(instant).filter(finite) {
                view.draw(&mut drawing, of, &take.motion.row(row), Some(take.color));
            }
            view.draw(&mut drawing, of, &reference.row(at_reference), None);
            if let Some((_, words)) = failed {
                let at = (place.centre().0, place.top + 14.0);
                let text = Text::new(words, at, 10.6).bold().anchored(Anchor::Middle);
                drawing.text(text.colored(Color(0x8A, 0x1C, 0x14)));
            }
        }
        let at = (MARGIN, LABEL + tall + 14.0);
        drawing.text(Text::new(format!("t = {instant:.2} s"), at, 10.6).bold());
        drawing.headed(title, words)
    };
    svg_of_frames(&instants_s.iter().map(frame).collect::<Vec<_>>(), SHOWN_S, still)
}
