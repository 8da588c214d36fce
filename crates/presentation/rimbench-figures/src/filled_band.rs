//! Draws the area between two curves, behind the data and cut at the frame.

use super::chart::Band;
use super::clip;
use super::data::Frame;
use super::drawing::{Color, Drawing, Point};

/// Share of white in the colour of an area, so that lines of the same colour stand out on it.
const PALE: f64 = 0.78;

/// Returns the colour in which a band of a colour is filled.
pub fn fill(color: Color) -> Color {
    color.mix(Color::WHITE, PALE)
}

/// Draws one band.
pub fn draw(drawing: &mut Drawing, frame: &Frame, band: &Band) {
    for piece in pieces(frame, band) {
        let (upper, lower): (Vec<Point>, Vec<Point>) = piece.into_iter().unzip();
        let outline: Vec<Point> = upper.into_iter().chain(lower.into_iter().rev()).collect();
        let corners = clip::polygon(&outline, &frame.area);
        if corners.len() > 2 {
            drawing.area(corners, Some(fill(band.color)), None);
        }
    }
}

/// Upper and lower edge on the page, between the breaks of the band.
fn pieces(frame: &Frame, band: &Band) -> Vec<Vec<(Point, Point)>> {
    let mut pieces = vec![Vec::new()];
    for &(x, [low, high]) in &band.points {
        let corners = || {
            let x = frame.x.position(x)?;
            Some(((x, frame.y.position(high)?), (x, frame.y.position(low)?)))
        };
        match (corners(), pieces.last_mut()) {
            (Some(corners), Some(piece)) => piece.push(corners),
            _ => pieces.push(Vec::new()),
        }
    }
    pieces.retain(|piece| piece.len() > 1);
    pieces
}
