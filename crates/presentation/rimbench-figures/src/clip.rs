//! Cuts lines and areas at the edges of a rectangle, so that nothing is drawn outside its frame.

use super::drawing::Point;

/// An axis-parallel rectangle on the page, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Right edge.
    pub right: f64,
    /// Lower edge.
    pub bottom: f64,
}

impl Rect {
    /// Width, px.
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    /// Height, px.
    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// Centre.
    pub fn centre(&self) -> Point {
        (0.5 * (self.left + self.right), 0.5 * (self.top + self.bottom))
    }

    /// Whether a point lies in it or on its edge.
    pub fn contains(&self, point: Point) -> bool {
        (self.left..=self.right).contains(&point.0) && (self.top..=self.bottom).contains(&point.1)
    }

    /// Its four corners.
    pub fn corners(&self) -> Vec<Point> {
        vec![(self.left, self.top), (self.right, self.top), (self.right, self.bottom), (self.left, self.bottom)]
    }

    /// The rectangle smaller by `margin` on every side.
    pub fn inset(&self, margin: f64) -> Rect {
        Rect {
            left: self.left + margin,
            top: self.top + margin,
            right: self.right - margin,
            bottom: self.bottom - margin,
        }
    }
}

/// Cuts a polyline into the pieces inside a rectangle, which may be another one for each segment.
pub fn polyline(points: &[Point], inside: impl Fn(usize) -> Rect) -> Vec<Vec<Point>> {
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    let mut open = false;
    for (index, pair) in points.windows(2).enumerate() {
        if pair[0] == pair[1] {
            continue;
        }
        let Some((from, to)) = segment(pair[0], pair[1], &inside(index)) else {
            open = false;
            continue;
        };
        match pieces.last_mut() {
            Some(piece) if open && piece.last() == Some(&from) => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
        open = to == pair[1];
    }
    pieces
}

/// Cuts a segment (Liang and Barsky): the part inside the rectangle, if any.
pub fn segment(from: Point, to: Point, inside: &Rect) -> Option<(Point, Point)> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    let edges = [
        (-dx, from.0 - inside.left),
        (dx, inside.right - from.0),
        (-dy, from.1 - inside.top),
        (dy, inside.bottom - from.1),
    ];
    for (outwards, distance) in edges {
        if outwards == 0.0 {
            if distance < 0.0 {
                return None;
            }
        } else if outwards < 0.0 {
            enter = enter.max(distance / outwards);
        } else {
            leave = leave.min(distance / outwards);
        }
    }
    // Clamped, because a share of a very long segment has round-off of its own.
    let at = |share: f64| {
        let (x, y) = (from.0 + share * dx, from.1 + share * dy);
        (x.clamp(inside.left, inside.right), y.clamp(inside.top, inside.bottom))
    };
    let start = if enter == 0.0 { from } else { at(enter) };
    let end = if leave == 1.0 { to } else { at(leave) };
    (enter <= leave && start != end).then_some((start, end))
}

/// Cuts a polygon (Sutherland and Hodgman). Empty if nothing is inside.
pub fn polygon(corners: &[Point], inside: &Rect) -> Vec<Point> {
    // Signed distance to each edge, positive inside.
    let edges: [&dyn Fn(Point) -> f64; 4] =
        [&|p| p.0 - inside.left, &|p| inside.right - p.0, &|p| p.1 - inside.top, &|p| inside.bottom - p.1];
    let mut polygon = corners.to_vec();
    for distance in edges {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (index, &corner) in polygon.iter().enumerate() {
            let before = polygon[(index + polygon.len() - 1) % polygon.len()];
            let (from, to) = (distance(before), distance(corner));
            if (from < 0.0) != (to < 0.0) {
                let share = from / (from - to);
                kept.push((before.0 + share * (corner.0 - before.0), before.1 + share * (corner.1 - before.1)));
            }
            if to >= 0.0 {
                kept.push(corner);
            }
        }
        polygon = kept;
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Rect = Rect { left: 0.0, top: 0.0, right: 10.0, bottom: 10.0 };

    #[test]
    fn lines_end_at_the_frame_and_go_on_where_they_return() {
        type Line<'a> = &'a [Point];
        for (line, wanted) in [
            // Leaves and returns.
            (
                &[(1.0, 5.0), (3.0, -5.0), (5.0, 5.0), (6.0, 5.0)][..],
                &[&[(1.0, 5.0), (2.0, 0.0)][..], &[(4.0, 0.0), (5.0, 5.0), (6.0, 5.0)]][..] as &[Line<'_>],
            ),
            // Outside, and past a corner.
            (&[(-5.0, -1.0), (20.0, -1.0)], &[]),
            (&[(-5.0, 4.0), (4.0, -9.0)], &[]),
            // Leaves at a point on the edge.
            (&[(8.0, 2.0), (10.0, 3.0), (12.0, 4.0)], &[&[(8.0, 2.0), (10.0, 3.0)]]),
            // A repeated point.
            (&[(1.0, 1.0), (2.0, 1.0), (2.0, 1.0), (3.0, 1.0)], &[&[(1.0, 1.0), (2.0, 1.0), (3.0, 1.0)]]),
        ] {
            assert_eq!(polyline(line, |_| FRAME), wanted);
        }
        // A run that diverges.
        let growing: Vec<Point> = (0..40).map(|k| (f64::from(k) / 4.0, 5.0 + (-8.0_f64).powi(k))).collect();
        let pieces = polyline(&growing, |_| FRAME);
        assert!(!pieces.is_empty() && pieces.iter().flatten().all(|&point| FRAME.contains(point)));
        // A triangle is cut at the edge.
        let cut = polygon(&[(5.0, 5.0), (15.0, 5.0), (5.0, 8.0)], &FRAME);
        assert!(cut.len() == 4 && cut.iter().all(|&point| FRAME.contains(point)));
        assert!(polygon(&[(11.0, 1.0), (12.0, 1.0), (11.0, 2.0)], &FRAME).is_empty());
    }
}
