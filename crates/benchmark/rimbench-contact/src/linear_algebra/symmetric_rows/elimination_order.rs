//! Minimum-degree order of elimination, and the pattern of the factor that follows.

use super::SymmetricPattern;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Order of elimination of a [`SymmetricPattern`], and where the entries of its factor stand.
///
/// Minimum degree: the row coupled to fewest others goes next, and those that it is coupled to are then coupled to each
/// other. Found once per pattern; a set of rows only ever leaves entries of the whole matrix's factor out.
/// # Source
/// Tinney, Walker 1967; George, Liu, *The evolution of the minimum degree ordering algorithm*, SIAM Review 31 (1989).
#[derive(Debug)]
pub struct EliminationOrder {
    /// Row of the matrix at each position of the order, and position of each row.
    pub(in super::super) row_at: Vec<u32>,
    pub(in super::super) position_of: Vec<u32>,
    /// Columns of L, positions below the diagonal in order.
    pub(in super::super) starts: Vec<usize>,
    pub(in super::super) positions: Vec<u32>,
    /// Rows of L, columns in order.
    row_starts: Vec<usize>,
    row_columns: Vec<u32>,
}

impl EliminationOrder {
    /// Finds the order for a pattern.
    pub fn new(pattern: &SymmetricPattern) -> Self {
        let n = pattern.size();
        let others = |i: usize| pattern.columns(i).iter().copied().filter(move |&j| j as usize != i);
        let mut known: Vec<Vec<u32>> = (0..n).map(|i| others(i).collect()).collect();
        let mut position_of = vec![u32::MAX; n];
        let (mut row_at, mut columns) = (Vec::with_capacity(n), Vec::with_capacity(n));
        // By how many others they are coupled to; entries that are out of date are passed over.
        let mut waiting: BinaryHeap<_> = (0..n).map(|i| Reverse((known[i].len(), i))).collect();
        while let Some(Reverse((degree, next))) = waiting.pop() {
            if position_of[next] != u32::MAX || degree != known[next].len() {
                continue;
            }
            position_of[next] = row_at.len() as u32;
            row_at.push(next as u32);
            let column = std::mem::take(&mut known[next]);
            for &i in &column {
                known[i as usize] = merged(&known[i as usize], &column, [i, next as u32]);
                waiting.push(Reverse((known[i as usize].len(), i as usize)));
            }
            columns.push(column);
        }
        let (mut starts, mut positions) = (vec![0], Vec::new());
        let mut rows: Vec<Vec<u32>> = vec![Vec::new(); n];
        for (k, column) in columns.into_iter().enumerate() {
            let mut column: Vec<u32> = column.into_iter().map(|i| position_of[i as usize]).collect();
            column.sort_unstable();
            for &position in &column {
                rows[position as usize].push(k as u32);
                positions.push(position);
            }
            starts.push(positions.len());
        }
        let mut row_starts = vec![0];
        let mut row_columns = Vec::new();
        for row in rows {
            row_columns.extend(row);
            row_starts.push(row_columns.len());
        }
        EliminationOrder { row_at, position_of, starts, positions, row_starts, row_columns }
    }

    /// Returns the columns before `k` that have an entry in its row of L.
    pub(in super::super) fn columns_of(&self, k: usize) -> &[u32] {
        &self.row_columns[self.row_starts[k]..self.row_starts[k + 1]]
    }

    /// Sorts rows of the matrix by their position in the order.
    pub fn sort(&self, rows: &mut [u32]) {
        rows.sort_unstable_by_key(|&row| self.position_of[row as usize]);
    }

    /// Returns the number of entries of L below the diagonal.
    pub fn entries(&self) -> usize {
        self.positions.len()
    }
}

/// Both sorted lists in one, without two of their members.
fn merged(a: &[u32], b: &[u32], without: [u32; 2]) -> Vec<u32> {
    let (mut a, mut b) = (a.iter().copied().peekable(), b.iter().copied().peekable());
    let mut all = Vec::with_capacity(a.len() + b.len());
    while let Some(next) = match (a.peek(), b.peek()) {
        (Some(&x), Some(&y)) => Some(x.min(y)),
        (x, y) => x.or(y).copied(),
    } {
        a.next_if_eq(&next);
        b.next_if_eq(&next);
        if !without.contains(&next) {
            all.push(next);
        }
    }
    all
}
