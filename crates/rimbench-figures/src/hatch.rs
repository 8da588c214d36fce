//! Hatching: parallel diagonals across a rectangle.

use super::clip::{self, Rect};
use super::drawing::Point;

/// Lists diagonals (rising to the right) across a rectangle, `distance` apart along x.
pub fn diagonals(place: &Rect, distance: f64) -> Vec<(Point, Point)> {
    let count = ((place.width() + place.height()) / distance).floor() as usize;
    let line = |k: usize| {
        let foot = place.left - place.height() + (k as f64 + 0.5) * distance;
        clip::segment((foot, place.bottom), (foot + place.height(), place.top), place)
    };
    (0..=count).filter_map(line).filter(|(from, to)| from != to).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hatching_stays_inside_its_cell() {
        let place = Rect { left: 3.0, top: 5.0, right: 40.0, bottom: 25.0 };
        let lines = diagonals(&place, 6.0);
        assert!(lines.len() > 5 && lines.iter().all(|(a, b)| place.contains(*a) && place.contains(*b)));
    }
}
