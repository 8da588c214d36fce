//! Cuts a line into its dashes; plotters knows one dash and one gap of whole backend units only.

use super::drawing::{DashPattern, Point};

/// Cuts a polyline into its dashes; a solid line comes back whole.
pub fn dashes(points: &[Point], pattern: DashPattern) -> Vec<Vec<Point>> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_continue_around_a_corner() {
        let pieces = dashes(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)], &[8.0, 1.0]);
        assert_eq!(pieces.len(), 3);
        assert_eq!(pieces[0], vec![(0.0, 0.0), (8.0, 0.0)]);
        assert_eq!(pieces[1], vec![(9.0, 0.0), (10.0, 0.0), (10.0, 7.0)]);
    }
}
