//! Rows by two: the same operations on both, in one register.

use wide::f64x2;

/// The numbers of two successive rows; of the last one twice.
#[inline(always)]
pub(super) fn two(of: &[f64], row: usize) -> f64x2 {
    f64x2::new([of[row], of[(row + 1).min(of.len() - 1)]])
}

/// Writes the numbers of two successive rows, or that of the last one.
#[inline(always)]
pub(super) fn put_two(of: &mut [f64], row: usize, numbers: f64x2) {
    let [first, second] = numbers.to_array();
    of[row] = first;
    if let Some(of) = of.get_mut(row + 1) {
        *of = second;
    }
}

/// Adds the multiples by `factors` of columns of `rows` rows each.
#[inline(always)]
pub(super) fn with_two(mut sum: f64x2, factors: &[f64], columns: &[f64], rows: usize, row: usize) -> f64x2 {
    for (&factor, column) in factors.iter().zip(columns.chunks_exact(rows)) {
        sum += f64x2::splat(factor) * two(column, row);
    }
    sum
}
