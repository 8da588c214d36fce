//! The entries of a matrix that are not zero, for matrices that meet many right-hand sides.

/// Smallest matrix worth it: below, whole rows are as fast (`benches/solvers.rs`, against size).
const FEWEST_ROWS: usize = 32;
/// Of so many entries at most one may differ from zero, or whole rows are as fast (likewise).
const ENTRIES_PER_NON_ZERO: usize = 4;

/// Row by row, the entries of an n×n matrix that are not zero and their columns.
///
/// Contacts of a pile share a body with few others, so most entries of `M` are zero. Allocates only where it is made
/// and where the size grows.
#[derive(Debug, Clone, Default)]
pub struct SparseRows {
    /// Where each row ends in `columns` and `entries`.
    ends: Vec<usize>,
    columns: Vec<u32>,
    entries: Vec<f64>,
    /// True if the matrix last read is held; false if it is small or has too few zeros.
    holds: bool,
}

impl SparseRows {
    /// Reserves room for matrices up to n×n.
    pub fn new(n: usize) -> Self {
        let mut rows = SparseRows::default();
        rows.reserve(n);
        rows
    }

    /// Makes room for matrices up to n×n.
    pub fn reserve(&mut self, n: usize) {
        if n >= FEWEST_ROWS && n > self.ends.capacity() {
            self.forget();
            self.ends.reserve(n);
            self.columns.reserve(n * n / ENTRIES_PER_NON_ZERO);
            self.entries.reserve(n * n / ENTRIES_PER_NON_ZERO);
        }
    }

    /// Holds nothing any more.
    pub fn forget(&mut self) {
        self.holds = false;
        self.ends.clear();
        self.columns.clear();
        self.entries.clear();
    }

    /// Reads the n×n matrix `m`, and holds it if it is large and has enough zeros.
    pub fn read(&mut self, m: &[f64], n: usize) {
        self.forget();
        if n < FEWEST_ROWS {
            return;
        }
        self.reserve(n);
        let most = n * n / ENTRIES_PER_NON_ZERO;
        for row in m.chunks_exact(n) {
            for (column, &entry) in (0..).zip(row) {
                // NaN is not zero.
                if entry != 0.0 {
                    if self.entries.len() == most {
                        return;
                    }
                    self.columns.push(column);
                    self.entries.push(entry);
                }
            }
            self.ends.push(self.entries.len());
        }
        self.holds = true;
    }

    /// Tells whether the matrix last read is held.
    #[inline]
    pub fn holds(&self) -> bool {
        self.holds
    }

    /// Returns column and value of the entries of row `i`, in order.
    #[inline]
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        let (columns, entries) = (&self.columns[start..self.ends[i]], &self.entries[start..self.ends[i]]);
        columns.iter().zip(entries).map(|(&column, &entry)| (column as usize, entry))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(n: usize) -> Vec<f64> {
        (0..n * n).map(|k: usize| [2.0, -1.0, 0.0][(k / n).abs_diff(k % n).min(2)]).collect()
    }

    #[test]
    fn the_rows_are_those_of_the_matrix() {
        let (n, mut rows) = (40, SparseRows::new(40));
        rows.read(&chain(n), n);
        assert!(rows.holds());
        assert_eq!(rows.row(0).collect::<Vec<_>>(), [(0, 2.0), (1, -1.0)]);
        assert_eq!(rows.row(39).collect::<Vec<_>>(), [(38, -1.0), (39, 2.0)]);
        assert_eq!((0..n).map(|i| rows.row(i).count()).sum::<usize>(), 3 * n - 2);
    }

    #[test]
    fn dense_and_small_matrices_are_not_held() {
        let mut rows = SparseRows::new(40);
        for (m, n) in [(vec![1.0; 1600], 40), (chain(8), 8), (vec![f64::NAN; 1600], 40)] {
            rows.read(&m, n);
            assert!(!rows.holds());
        }
    }
}
