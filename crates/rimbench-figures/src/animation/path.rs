//! Corners and curves as the data of a path.

use super::timing::{State, round, thinned};
use std::fmt::Write;

/// Drops points of a curve that nobody sees.
pub(super) fn thin_line(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let states: Vec<(f64, State)> = points.iter().map(|&(x, y)| (x, [0.0, y, 0.0])).collect();
    thinned(&states).into_iter().map(|(x, [_, y, _])| (x, y)).collect()
}

pub(super) fn polygon(corners: &[(f64, f64)]) -> String {
    line(corners) + "z"
}

pub(super) fn line(points: &[(f64, f64)]) -> String {
    let mut path = String::new();
    for (index, (x, y)) in points.iter().enumerate() {
        let _ = write!(path, "{}{} {}", if index == 0 { "M" } else { "L" }, round(*x, 10.0), round(*y, 10.0));
    }
    path
}
