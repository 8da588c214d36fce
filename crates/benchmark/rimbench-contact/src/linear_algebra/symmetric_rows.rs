//! A symmetric matrix of which most entries are zero for good.

mod elimination_order;

pub use elimination_order::EliminationOrder;

use std::sync::{Arc, OnceLock};

/// Where the entries of a symmetric matrix stand: row by row, columns in order, the diagonal always among them.
#[derive(Debug, Clone)]
pub struct SymmetricPattern {
    starts: Vec<usize>,
    columns: Vec<u32>,
    diagonal: Vec<usize>,
    /// Found at the first request, once for all that share the pattern.
    order: OnceLock<Arc<EliminationOrder>>,
}

impl PartialEq for SymmetricPattern {
    fn eq(&self, other: &Self) -> bool {
        self.starts == other.starts && self.columns == other.columns
    }
}

impl Eq for SymmetricPattern {}

impl SymmetricPattern {
    /// Lays out the matrix whose row `i` has entries in the columns `neighbours[i]`, and on the diagonal.
    pub fn new(neighbours: &[Vec<usize>]) -> Self {
        let mut pattern =
            SymmetricPattern { starts: vec![0], columns: Vec::new(), diagonal: Vec::new(), order: OnceLock::new() };
        for (i, neighbours) in neighbours.iter().enumerate() {
            let mut row: Vec<usize> = neighbours.iter().copied().chain([i]).collect();
            row.sort_unstable();
            row.dedup();
            let start = pattern.columns.len();
            pattern.diagonal.push(start + row.partition_point(|&column| column < i));
            pattern.columns.extend(row.iter().map(|&column| column as u32));
            pattern.starts.push(pattern.columns.len());
        }
        pattern
    }

    /// Returns the size of the matrix.
    #[inline]
    pub fn size(&self) -> usize {
        self.diagonal.len()
    }

    /// Returns the order in which matrices of this pattern are factorised.
    #[inline]
    pub fn elimination_order(&self) -> &Arc<EliminationOrder> {
        self.order.get_or_init(|| Arc::new(EliminationOrder::new(self)))
    }

    /// Returns where the entry of `row` and `column` stands, if it is not zero for good.
    #[inline]
    pub fn position(&self, row: usize, column: usize) -> Option<usize> {
        let (start, end) = (self.starts[row], self.starts[row + 1]);
        self.columns[start..end].binary_search(&(column as u32)).ok().map(|at| start + at)
    }

    /// Returns the number of entries.
    #[inline]
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// Returns the columns of a row, in order.
    #[inline]
    pub fn columns(&self, row: usize) -> &[u32] {
        &self.columns[self.starts[row]..self.starts[row + 1]]
    }
}

/// A symmetric matrix with a fixed [`SymmetricPattern`], its entries borrowed. Both triangles are there, so that a row
/// is a column.
#[derive(Debug, Clone, Copy)]
pub struct SymmetricRows<'a> {
    /// Where the entries stand.
    pub pattern: &'a SymmetricPattern,
    /// The entries, where the pattern says.
    pub entries: &'a [f64],
}

impl<'a> SymmetricRows<'a> {
    /// Returns the size of the matrix.
    #[inline]
    pub fn size(&self) -> usize {
        self.pattern.size()
    }

    /// Returns one entry.
    #[inline]
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        self.pattern.position(row, column).map_or(0.0, |at| self.entries[at])
    }

    /// Returns one entry of the diagonal.
    #[inline]
    pub fn diagonal(&self, row: usize) -> f64 {
        self.entries[self.pattern.diagonal[row]]
    }

    /// Returns columns and entries of a row, in order.
    #[inline]
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> + use<'a> {
        let (start, end) = (self.pattern.starts[row], self.pattern.starts[row + 1]);
        let (columns, entries) = (&self.pattern.columns[start..end], &self.entries[start..end]);
        columns.iter().zip(entries).map(|(&column, &entry)| (column as usize, entry))
    }

    /// Adds `factor · row` to `target`.
    #[inline]
    pub fn add_row(&self, row: usize, factor: f64, target: &mut [f64]) {
        for (column, entry) in self.row(row) {
            target[column] += factor * entry;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_stand_where_the_pattern_says_and_are_zero_elsewhere() {
        let pattern = SymmetricPattern::new(&[vec![2], vec![], vec![0, 2]]);
        let rows = SymmetricRows { pattern: &pattern, entries: &[4.0, -1.0, 3.0, -1.0, 5.0] };
        let dense: Vec<f64> = (0..9).map(|k| rows.entry(k / 3, k % 3)).collect();
        assert_eq!(dense, [4.0, 0.0, -1.0, 0.0, 3.0, 0.0, -1.0, 0.0, 5.0]);
        assert_eq!((rows.diagonal(2), pattern.position(0, 1), pattern.columns(2)), (5.0, None, &[0, 2][..]));
        let mut sum = [1.0; 3];
        rows.add_row(2, 2.0, &mut sum);
        assert_eq!(sum, [-1.0, 1.0, 11.0]);
    }
}
