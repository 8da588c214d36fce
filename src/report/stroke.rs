//! Turns outlines into areas for the raster image: dashes, and the polygons a stroked line covers.

use super::drawing::{Dash, Point, Stroke};

/// Cuts a polyline into its dashes; a solid line comes back whole.
pub fn dashes(points: &[Point], pattern: Dash) -> Vec<Vec<Point>> {
    if pattern.is_empty() || pattern.iter().sum::<f64>() <= 0.0 {
        return vec![points.to_vec()];
    }
    let (mut pieces, mut piece) = (Vec::new(), Vec::new());
    let (mut slot, mut left) = (0, pattern[0]);
    for pair in points.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        loop {
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            let drawn = slot % 2 == 0;
            if drawn && piece.is_empty() {
                piece.push(from);
            }
            if length < left {
                left -= length;
                if drawn {
                    piece.push(to);
                }
                break;
            }
            let share = if length > 0.0 { left / length } else { 0.0 };
            from = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            if drawn {
                piece.push(from);
                pieces.push(std::mem::take(&mut piece));
            }
            slot += 1;
            left = pattern[slot % pattern.len()];
        }
    }
    if piece.len() > 1 {
        pieces.push(piece);
    }
    pieces
}

/// Lists polygons of equal orientation whose union is the stroked line: butt caps, round joins.
pub fn outline(points: &[Point], closed: bool, stroke: &Stroke) -> Vec<Vec<Point>> {
    let mut path = points.to_vec();
    if closed && let Some(&first) = points.first() {
        path.push(first);
    }
    let half = 0.5 * stroke.width;
    let mut polygons = Vec::new();
    let whole_ring = closed && stroke.dash.is_empty();
    for piece in dashes(&path, stroke.dash) {
        for pair in piece.windows(2) {
            polygons.extend(segment(pair[0], pair[1], half));
        }
        let joints = if whole_ring { piece.len() } else { piece.len().saturating_sub(1) };
        for &corner in piece.get(1..joints).unwrap_or_default() {
            polygons.push(round(corner, half));
        }
    }
    polygons
}

fn segment(from: Point, to: Point, half: f64) -> Option<Vec<Point>> {
    let length = (to.0 - from.0).hypot(to.1 - from.1);
    if length == 0.0 {
        return None;
    }
    let (nx, ny) = (-(to.1 - from.1) / length * half, (to.0 - from.0) / length * half);
    let corners = [(from, -1.0), (to, -1.0), (to, 1.0), (from, 1.0)];
    Some(corners.iter().map(|&(p, side)| (p.0 + side * nx, p.1 + side * ny)).collect())
}

fn round(centre: Point, radius: f64) -> Vec<Point> {
    let corners = (6.0 + 4.0 * radius).ceil();
    let angle = |k: usize| std::f64::consts::TAU * k as f64 / corners;
    (0..corners as usize).map(|k| (centre.0 + radius * angle(k).cos(), centre.1 + radius * angle(k).sin())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signed_area(polygon: &[Point]) -> f64 {
        let next = polygon.iter().cycle().skip(1);
        polygon.iter().zip(next).map(|(a, b)| 0.5 * (a.0 * b.1 - b.0 * a.1)).sum()
    }

    #[test]
    fn dashes_continue_around_a_corner() {
        let pieces = dashes(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)], &[8.0, 1.0]);
        assert_eq!(pieces.len(), 3);
        assert_eq!(pieces[0], vec![(0.0, 0.0), (8.0, 0.0)]);
        assert_eq!(pieces[1], vec![(9.0, 0.0), (10.0, 0.0), (10.0, 7.0)]);
    }

    #[test]
    fn every_polygon_of_an_outline_turns_the_same_way() {
        use super::super::drawing::Color;
        let zigzag = [(0.0, 0.0), (5.0, 9.0), (-3.0, 2.0), (4.0, -7.0)];
        let polygons = outline(&zigzag, true, &Stroke::solid(Color::INK, 2.0));
        assert!(polygons.iter().all(|polygon| signed_area(polygon) > 0.0));
    }
}
