//! The tableau of Lemke's method, for any matrix: what the problems with and without friction share.

use super::Unsolved;
use crate::linear_algebra::Buffer;

/// Entries of the entering column up to this are zero.
pub(crate) const PIVOT: f64 = 1e-11;
/// `z₀` below this has left as far as rounding can tell.
const VANISHED: f64 = 1e-9;
/// Ratios closer than this, relative to the larger of 1 and the ratio, are tied.
const TIE: f64 = 1e-12;

/// The tableau with its basis.
///
/// ```text
/// [ I  −M  −e | q ]        n rows, 2n + 2 columns
/// ```
/// Variable `w_i` is column `i`, `z_i` is `n + i`, `z₀` is `2n`; the right-hand side is the last column. `INLINE`
/// numbers and `ROWS` rows live inside.
#[derive(Debug, Clone)]
pub(crate) struct LemkeTableau<const INLINE: usize, const ROWS: usize> {
    n: usize,
    entries: Buffer<f64, INLINE>,
    /// Variable of each row.
    basis: Buffer<usize, ROWS>,
    /// Rows still tied in the ratio test.
    tied: Buffer<usize, ROWS>,
}

impl<const INLINE: usize, const ROWS: usize> LemkeTableau<INLINE, ROWS> {
    /// Reserves room for problems up to this size.
    pub(crate) fn new(capacity: usize) -> Self {
        LemkeTableau {
            n: 0,
            entries: Buffer::new(capacity * (2 * capacity + 2)),
            basis: Buffer::new(capacity),
            tied: Buffer::new(capacity),
        }
    }

    fn width(&self) -> usize {
        2 * self.n + 2
    }

    /// Fills the tableau with `−M` and `q`, which `fill` writes row by row: to the second slice `−M`, as the result
    /// `q`.
    pub(crate) fn start(&mut self, n: usize, mut fill: impl FnMut(usize, &mut [f64]) -> f64) {
        self.n = n;
        let width = self.width();
        self.entries.grow(n * width);
        self.basis.grow(n);
        self.tied.grow(n);
        for (i, row) in self.entries[..n * width].chunks_exact_mut(width).enumerate() {
            self.basis[i] = i;
            row[..n].fill(0.0);
            row[i] = 1.0;
            row[2 * n + 1] = fill(i, &mut row[n..2 * n]);
            row[2 * n] = -1.0;
        }
    }

    /// Returns the right-hand side of a row.
    pub(crate) fn rhs(&self, r: usize) -> f64 {
        self.entries[r * self.width() + self.width() - 1]
    }

    /// Returns the variable `z_i` that is basic in a row, if it is one.
    pub(crate) fn basic(&self, r: usize) -> Option<usize> {
        self.basis[r].checked_sub(self.n).filter(|&i| i < self.n)
    }

    /// Pivots until `z₀` has left; returns the number of pivots.
    ///
    /// # Errors
    /// [`Unsolved::NotFound`] on a ray, or after more pivots than small problems can need.
    pub(crate) fn run(&mut self) -> Result<u32, Unsolved> {
        let n = self.n;
        // The lexicographically least row: of equal right-hand sides the last.
        let mut row = (0..n).fold(0, |least, r| if self.rhs(r) <= self.rhs(least) { r } else { least });
        let (mut column, mut pivots) = (2 * n, 0);
        // Exponentially many pivots exist on purpose-built matrices (Fathi, Murty); small ones are seen through.
        let bound = 50 * n as u32 + (1 << n.min(12));
        loop {
            let left = self.basis[row];
            self.pivot(row, column);
            pivots += 1;
            if left == 2 * n {
                return Ok(pivots);
            }
            column = if left < n { left + n } else { left - n };
            match self.leaving_row(column) {
                Some(r) if pivots < bound => row = r,
                // A ray from where rounding kept z₀ from leaving is a solution; the residual decides.
                _ if (0..n).all(|r| self.basis[r] != 2 * n || self.rhs(r) < VANISHED) => return Ok(pivots),
                _ => return Err(Unsolved::NotFound { residual: f64::INFINITY }),
            }
        }
    }

    /// Returns the row that leaves when `column` enters, or `None` on a ray.
    fn leaving_row(&mut self, column: usize) -> Option<usize> {
        let (n, width) = (self.n, self.width());
        let ratio = |tableau: &[f64], r: usize, c: usize| tableau[r * width + c] / tableau[r * width + column];
        let mut count = 0;
        for r in 0..n {
            if self.entries[r * width + column] > PIVOT {
                self.tied[count] = r;
                count += 1;
            }
        }
        // First the right-hand side, then the columns of B⁻¹, until one row is left.
        for c in std::iter::once(2 * n + 1).chain(0..n) {
            if count < 2 {
                break;
            }
            let least =
                self.tied[..count].iter().fold(f64::INFINITY, |least, &r| least.min(ratio(&self.entries, r, c)));
            let limit = least + TIE * least.abs().max(1.0);
            let mut kept = 0;
            for t in 0..count {
                let r = self.tied[t];
                if ratio(&self.entries, r, c) <= limit {
                    self.tied[kept] = r;
                    kept += 1;
                }
            }
            count = kept;
            if c == 2 * n + 1
                && let Some(&r) = self.tied[..count].iter().find(|&&r| self.basis[r] == 2 * n)
            {
                return Some(r);
            }
        }
        (count > 0).then(|| self.tied[0])
    }

    /// Makes `column` basic in row `r`.
    fn pivot(&mut self, r: usize, column: usize) {
        let (n, width) = (self.n, self.width());
        let (above, rest) = self.entries[..n * width].split_at_mut(r * width);
        let (row, below) = rest.split_at_mut(width);
        let inverse = 1.0 / row[column];
        row.iter_mut().for_each(|entry| *entry *= inverse);
        row[column] = 1.0;
        for other in above.chunks_exact_mut(width).chain(below.chunks_exact_mut(width)) {
            let factor = other[column];
            if factor != 0.0 {
                for (entry, pivot) in other.iter_mut().zip(&*row) {
                    *entry -= factor * pivot;
                }
                other[column] = 0.0;
                // The right-hand side of a basis is nonnegative: what is below zero is rounding.
                let rhs = &mut other[width - 1];
                *rhs = rhs.max(0.0);
            }
        }
        self.basis[r] = column;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_apart_by_rounding_are_tied_at_any_size_and_the_lexicographic_rule_decides() {
        for (q, apart, leaves) in [(1e6, 1e-13, 1), (1e6, 1e-9, 0), (1e-6, 1e-7, 1), (1e-6, 1e-5, 0)] {
            let mut tableau = LemkeTableau::<12, 2>::new(2);
            tableau.start(2, |row, entries| {
                entries.fill(1.0);
                if row == 0 { q } else { q * (1.0 + apart) }
            });
            // Of the first column of B⁻¹ the second row has less.
            assert_eq!(tableau.leaving_row(2), Some(leaves), "{q:e} apart by {apart:e}");
        }
    }
}
