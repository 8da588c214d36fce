//! Rows by two: the same operations on both, in one register.

use wide::f64x2;

/// Does something for every two of so many rows, and for the last one as both; text that is in the loop, where a
/// function would be called.
macro_rules! by_two {
    ($rows:expr, $both:ident => $each:expr) => {{
        let rows = $rows;
        let mut row = 0;
        while row + 1 < rows {
            let $both = [row, row + 1];
            $each;
            row += 2;
        }
        if row < rows {
            let $both = [row, row];
            $each;
        }
    }};
}
pub(super) use by_two;

/// The numbers of two rows.
#[inline(always)]
pub(super) fn two(of: &[f64], [first, second]: [usize; 2]) -> f64x2 {
    f64x2::new([of[first], of[second]])
}

/// Writes the numbers of two rows.
#[inline(always)]
pub(super) fn put_two(of: &mut [f64], rows: [usize; 2], numbers: f64x2) {
    (of[rows[1]], of[rows[0]]) = (numbers.to_array()[1], numbers.to_array()[0]);
}

/// Adds multiples of columns: one of them as it stands, the most frequent number, or each in its turn.
#[inline(always)]
pub(super) fn with_two(sum: f64x2, factors: &[f64], columns: &[f64], length: usize, rows: [usize; 2]) -> f64x2 {
    let add = |sum: f64x2, factor: f64, column: &[f64]| sum + f64x2::splat(factor) * two(column, rows);
    match *factors {
        [factor] => add(sum, factor, &columns[..length]),
        _ => factors
            .iter()
            .enumerate()
            .fold(sum, |sum, (at, &factor)| add(sum, factor, &columns[at * length..][..length])),
    }
}
