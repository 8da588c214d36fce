//! Draws the signs at data points.

use super::drawing::{Color, Drawing, Point, Stroke};
use crate::line_style::Marker;

/// Draws a marker of the given half size (px). A thin white rim keeps neighbours apart.
pub fn draw(drawing: &mut Drawing, marker: Marker, at: Point, size: f64, color: Color) {
    let rim = Some(Stroke::solid(Color::WHITE, 0.8));
    let bold = Some(Stroke::solid(color, 1.5));
    let paper = Some(Color::WHITE);
    let ring = |corners: usize, radius: f64, first: f64| ring(at, corners, radius * size, first);
    match marker {
        Marker::Circle => drawing.disc(at, size, Some(color), rim),
        Marker::OpenCircle => drawing.disc(at, 0.9 * size, paper, bold),
        Marker::Square => drawing.area(ring(4, 1.25, 45.0), Some(color), rim),
        Marker::OpenSquare => drawing.area(ring(4, 1.1, 45.0), paper, bold),
        Marker::Diamond => drawing.area(ring(4, 1.3, 0.0), Some(color), rim),
        Marker::OpenDiamond => drawing.area(ring(4, 1.2, 0.0), paper, bold),
        Marker::Triangle => drawing.area(ring(3, 1.3, 90.0), Some(color), rim),
        Marker::Pentagon => drawing.area(ring(5, 1.15, -90.0), Some(color), rim),
        Marker::Star => {
            let (tips, notches) = (ring(5, 1.45, -90.0), ring(5, 0.6, -54.0));
            let corners = tips.into_iter().zip(notches).flat_map(|(tip, notch)| [tip, notch]);
            drawing.area(corners.collect(), Some(color), rim);
        }
        Marker::Plus => strokes(drawing, &ring(4, 1.2, 0.0), color),
        Marker::Cross => strokes(drawing, &ring(4, 1.3, 45.0), color),
        Marker::Beyond => drawing.area(self::ring(at, 3, 1.25 * (size + 0.6), -90.0), Some(color), rim),
        Marker::SomeLost => drawing.area(ring(3, 1.0, -90.0), paper, Some(Stroke::solid(color, 1.2))),
        Marker::Silent => {
            let half = 1.1 * size;
            drawing.line(vec![(at.0 - half, at.1), (at.0 + half, at.1)], Stroke::solid(color, 1.6));
        }
    }
}

fn strokes(drawing: &mut Drawing, tips: &[Point], color: Color) {
    drawing.line(vec![tips[0], tips[2]], Stroke::solid(color, 1.6));
    drawing.line(vec![tips[1], tips[3]], Stroke::solid(color, 1.6));
}

fn ring(centre: Point, corners: usize, radius: f64, first_degrees: f64) -> Vec<Point> {
    let angle = |k: usize| (first_degrees + 360.0 * k as f64 / corners as f64).to_radians();
    (0..corners).map(|k| (centre.0 + radius * angle(k).cos(), centre.1 + radius * angle(k).sin())).collect()
}
