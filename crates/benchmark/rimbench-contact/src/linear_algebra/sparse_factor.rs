//! Factorisation of a principal submatrix of a sparse matrix, in one order and one pattern for all of them.

use super::symmetric_rows::{EliminationOrder, SymmetricPattern, SymmetricRows};
use std::ops::Range;
use std::sync::Arc;

/// `x −= y l` over the positions of the entries.
#[inline(always)]
fn scatter(l: &[f64], y: f64, positions: &[u32], x: &mut [f64]) {
    for (&position, l) in positions.iter().zip(l) {
        x[position as usize] -= l * y;
    }
}

/// `c − Σ l x` over the positions of the entries. The first one is subtracted last: it is mostly that which has just
/// been computed, and all others need not wait for it.
#[inline(always)]
fn less_gathered(mut c: f64, l: &[f64], positions: &[u32], x: &[f64]) -> f64 {
    let (Some((&l_first, l)), Some((&first, positions))) = (l.split_first(), positions.split_first()) else { return c };
    let mut sums = [0.0; 2];
    let (l_pairs, l_rest) = l.as_chunks::<2>();
    let (place_pairs, place_rest) = positions.as_chunks::<2>();
    for (l, positions) in l_pairs.iter().zip(place_pairs) {
        for k in 0..2 {
            sums[k] += l[k] * x[positions[k] as usize];
        }
    }
    if let (&[l], &[position]) = (l_rest, place_rest) {
        c -= l * x[position as usize];
    }
    c - (sums[0] + sums[1]) - l_first * x[first as usize]
}

/// `M_AA = L D Lᵀ` for a set A that rows enter and leave, in the order of all rows.
///
/// ```text
/// k enters:  l_k, d_k and the column below by one pass over row k;   L₃₃ D₃₃ L₃₃ᵀ − d_k c cᵀ
/// k leaves:  L₃₃ D₃₃ L₃₃ᵀ + d_k c cᵀ                                 c: column k of L, below k
/// ```
/// Rows that are not in A are unit rows of L. Of a column the entries of members are kept, in order, from where it
/// starts for all rows: of all that L has room for these are two fifths in a heap that presses, and a fifth where half
/// of the contacts are open. Nothing is allocated after construction, unless for another pattern.
/// # Source
/// Davis, Hager, *Row modifications of a sparse Cholesky factorization*, SIAM J. Matrix Anal. Appl. 26 (2005); the
/// change of rank one is method C1 of Gill, Golub, Murray, Saunders 1974.
#[derive(Debug, Clone)]
pub struct SparseFactor {
    order: Arc<EliminationOrder>,
    l: Vec<f64>,
    positions: Vec<u32>,
    /// How many entries each column has.
    counts: Vec<u32>,
    d: Vec<f64>,
    active: Vec<bool>,
    /// By positions; zero between calls.
    x: Vec<f64>,
    /// While factorising: the first column whose next entry is that of a row, the next such column after it, and where
    /// that entry stands.
    first: Vec<u32>,
    next: Vec<u32>,
    at: Vec<usize>,
}

/// No column.
const NONE: u32 = u32::MAX;

impl SparseFactor {
    /// Makes the factor of no row.
    pub fn new(pattern: &SymmetricPattern) -> Self {
        let (n, order) = (pattern.size(), pattern.elimination_order().clone());
        SparseFactor {
            l: vec![0.0; order.entries()],
            positions: vec![0; order.entries()],
            counts: vec![0; n],
            d: vec![1.0; n],
            active: vec![false; n],
            x: vec![0.0; n],
            first: vec![NONE; n],
            next: vec![NONE; n],
            at: vec![0; n],
            order,
        }
    }

    /// Goes over to matrices of this pattern, with the factor of no row, unless it is that of the order at hand.
    pub fn change_pattern(&mut self, pattern: &SymmetricPattern) {
        let order = pattern.elimination_order();
        if !Arc::ptr_eq(&self.order, order) {
            *self = SparseFactor::new(pattern);
        }
    }

    /// Tells whether a row of the matrix is in A.
    #[inline]
    pub fn contains(&self, row: usize) -> bool {
        self.active[self.order.position_of[row] as usize]
    }

    /// Copies another factor, without allocating if it is of equal order.
    pub fn copy_from(&mut self, other: &Self) {
        if !Arc::ptr_eq(&self.order, &other.order) {
            self.clone_from(other);
            return;
        }
        for k in 0..other.d.len() {
            let column = other.column(k);
            self.l[column.clone()].copy_from_slice(&other.l[column.clone()]);
            self.positions[column.clone()].copy_from_slice(&other.positions[column]);
        }
        self.counts.copy_from_slice(&other.counts);
        self.d.copy_from_slice(&other.d);
        self.active.copy_from_slice(&other.active);
    }

    /// Where the entries of a column stand.
    #[inline]
    fn column(&self, k: usize) -> Range<usize> {
        let start = self.order.starts[k];
        start..start + self.counts[k] as usize
    }

    /// Factorises `m` plus `shift` on its diagonal anew for the rows of which `wanted` says so, leaving out those whose
    /// pivot is at most `dependent` times their diagonal; returns how many are in.
    pub fn factorise(
        &mut self,
        m: SymmetricRows<'_>,
        shift: f64,
        dependent: f64,
        wanted: impl Fn(usize) -> bool,
    ) -> usize {
        let mut others = false;
        for (active, &row) in self.active.iter_mut().zip(&self.order.row_at) {
            let is_wanted = wanted(row as usize);
            others |= is_wanted != *active;
            *active = is_wanted;
        }
        if others {
            (0..self.d.len()).for_each(|k| self.list_entries(k));
        }
        self.factorise_active(m, shift, dependent)
    }

    /// Factorises for the rows in A, apart from the test for them, which the compiler would inline with all of this.
    fn factorise_active(&mut self, m: SymmetricRows<'_>, shift: f64, dependent: f64) -> usize {
        let Self { order, l, positions, counts, d, active, x, first, next, at } = self;
        let EliminationOrder { row_at, position_of, starts, .. } = &**order;
        let (positions, x) = (&positions[..], &mut x[..]);
        let (mut count, mut wanted) = (0, 0);
        for (k, &row) in row_at.iter().enumerate() {
            if !active[k] {
                continue;
            }
            wanted += 1;
            let row = row as usize;
            for (other, entry) in m.row(row) {
                let position = position_of[other] as usize;
                if position >= k && active[position] {
                    x[position] = entry;
                }
            }
            let mut waiting = std::mem::replace(&mut first[k], NONE);
            while waiting != NONE {
                let j = waiting as usize;
                waiting = next[j];
                let entries = at[j]..starts[j] + counts[j] as usize;
                let y = l[entries.start] * d[j];
                if y != 0.0 {
                    scatter(&l[entries.clone()], y, &positions[entries.clone()], x);
                }
                at[j] += 1;
                if at[j] < entries.end {
                    next[j] = std::mem::replace(&mut first[positions[at[j]] as usize], j as u32);
                }
            }
            let pivot = std::mem::take(&mut x[k]) + shift;
            let column = starts[k]..starts[k] + counts[k] as usize;
            // False for NaN.
            active[k] = pivot > dependent * (m.diagonal(row) + shift);
            let inverse = if active[k] { 1.0 / pivot } else { 0.0 };
            for (l, &position) in l[column.clone()].iter_mut().zip(&positions[column.clone()]) {
                *l = std::mem::take(&mut x[position as usize]) * inverse;
            }
            d[k] = if active[k] { pivot } else { 1.0 };
            if active[k] {
                count += 1;
                if let Some(&row) = positions[column.clone()].first() {
                    (at[k], next[k]) = (column.start, std::mem::replace(&mut first[row as usize], k as u32));
                }
            }
        }
        if count < wanted {
            self.drop_dependent();
        }
        count
    }

    /// Lists the rows of A in a column of L, and makes it that of a unit matrix if its row is not in A.
    fn list_entries(&mut self, k: usize) {
        let Self { order, positions, counts, d, active, .. } = self;
        let start = order.starts[k];
        let mut end = start;
        if active[k] {
            for &position in &order.positions[start..order.starts[k + 1]] {
                positions[end] = position;
                end += usize::from(active[position as usize]);
            }
        } else {
            d[k] = 1.0;
        }
        counts[k] = (end - start) as u32;
    }

    /// Takes the rows that were found to depend on others, and are not in A any more, out of all columns of L.
    fn drop_dependent(&mut self) {
        let Self { order, l, positions, counts, active, .. } = self;
        for (k, count) in counts.iter_mut().enumerate() {
            let start = order.starts[k];
            let mut end = start;
            for at in start..start + *count as usize {
                if active[k] && active[positions[at] as usize] {
                    (l[end], positions[end]) = (l[at], positions[at]);
                    end += 1;
                }
            }
            *count = (end - start) as u32;
        }
    }

    /// Takes up a row that is not in A and does not depend on it, with `shift` on its diagonal.
    pub fn enter(&mut self, m: SymmetricRows<'_>, row: usize, shift: f64) {
        let Self { order, l, positions, counts, d, active, x, .. } = self;
        let k = order.position_of[row] as usize;
        debug_assert!(!active[k], "row {row} is in the set");
        active[k] = true;
        for (other, entry) in m.row(row) {
            let position = order.position_of[other] as usize;
            if active[position] {
                x[position] = entry;
            }
        }
        for &j in order.columns_of(k) {
            let j = j as usize;
            if !active[j] {
                continue;
            }
            let y = std::mem::take(&mut x[j]);
            let column = order.starts[j]..order.starts[j] + counts[j] as usize;
            let mut entry = 0.0;
            if y != 0.0 {
                scatter(&l[column.clone()], y, &positions[column.clone()], x);
                entry = y / d[j];
                x[k] -= y * entry;
            }
            let at = column.start + positions[column.clone()].partition_point(|&position| (position as usize) < k);
            l.copy_within(at..column.end, at + 1);
            positions.copy_within(at..column.end, at + 1);
            (l[at], positions[at]) = (entry, k as u32);
            counts[j] += 1;
        }
        d[k] = std::mem::take(&mut x[k]) + shift;
        self.list_entries(k);
        let column = self.column(k);
        for (&position, l) in self.positions[column.clone()].iter().zip(&mut self.l[column]) {
            *l = std::mem::take(&mut self.x[position as usize]) / self.d[k];
        }
        self.change_by_column(k, -self.d[k]);
    }

    /// Removes a row from A.
    pub fn leave(&mut self, row: usize) {
        let k = self.order.position_of[row] as usize;
        debug_assert!(self.active[k], "row {row} is not in the set");
        self.change_by_column(k, self.d[k]);
        let Self { order, l, positions, counts, d, active, .. } = self;
        for &j in order.columns_of(k) {
            let j = j as usize;
            if active[j] {
                let column = order.starts[j]..order.starts[j] + counts[j] as usize;
                let at = column.start + positions[column.clone()].partition_point(|&position| (position as usize) < k);
                l.copy_within(at + 1..column.end, at);
                positions.copy_within(at + 1..column.end, at);
                counts[j] -= 1;
            }
        }
        (counts[k], d[k], active[k]) = (0, 1.0, false);
    }

    /// Adds `α c cᵀ` to what follows column k of L, where c is that column.
    fn change_by_column(&mut self, k: usize, mut alpha: f64) {
        let column = self.column(k);
        for (&position, l) in self.positions[column.clone()].iter().zip(&self.l[column]) {
            self.x[position as usize] = *l;
        }
        let mut j = k;
        // The rows of a column are all on the way from the first of them to the last of all.
        while let Some(&next) = self.positions[self.column(j)].first() {
            j = next as usize;
            let v = std::mem::take(&mut self.x[j]);
            if v == 0.0 {
                continue;
            }
            let d = self.d[j] + alpha * v * v;
            let beta = alpha * v / d;
            alpha *= self.d[j] / d;
            self.d[j] = d;
            let column = self.column(j);
            let Self { l, positions, x, .. } = self;
            let x = &mut x[..];
            for (&position, l) in positions[column.clone()].iter().zip(&mut l[column]) {
                let x = &mut x[position as usize];
                *x -= v * *l;
                *l += beta * *x;
            }
        }
    }

    /// Replaces `b` by `M_AA⁻¹ b_A`, zero elsewhere; `b` has an entry for each row of the matrix.
    pub fn solve(&mut self, b: &mut [f64]) {
        let mut x = std::mem::take(&mut self.x);
        for ((x, &row), &active) in x.iter_mut().zip(&self.order.row_at).zip(&self.active) {
            *x = if active { b[row as usize] } else { 0.0 };
        }
        for k in 0..x.len() {
            if x[k] != 0.0 {
                let column = self.column(k);
                scatter(&self.l[column.clone()], x[k], &self.positions[column], &mut x);
            }
        }
        self.solve_backward(&mut x);
        for (x, &row) in x.iter_mut().zip(&self.order.row_at) {
            b[row as usize] = std::mem::take(x);
        }
        self.x = x;
    }

    /// Writes `M_AA⁻¹ M_Aj` for a row j that is not in A, [by positions](Self::position) of the order, zero elsewhere.
    pub fn response(&self, m: SymmetricRows<'_>, j: usize, p: &mut [f64]) {
        let Self { order, l, positions, active, .. } = self;
        let k = order.position_of[j] as usize;
        debug_assert!(!active[k], "row {j} is in the set");
        p.fill(0.0);
        for (row, entry) in m.row(j) {
            let position = order.position_of[row] as usize;
            p[position] = if active[position] { entry } else { 0.0 };
        }
        // A row takes part in the columns with an entry in it, and in those on the path in the elimination tree from the
        // first of its own column.
        for &column in order.columns_of(k) {
            let y = p[column as usize];
            if y != 0.0 {
                let column = self.column(column as usize);
                scatter(&l[column.clone()], y, &positions[column], p);
            }
        }
        let own = &order.positions[order.starts[k]..order.starts[k + 1]];
        let mut next = own.iter().find(|&&position| active[position as usize]);
        while let Some(&at) = next {
            let column = self.column(at as usize);
            scatter(&l[column.clone()], p[at as usize], &positions[column.clone()], p);
            next = positions[column].first();
        }
        self.solve_backward(p);
    }

    /// Returns the place of a row in the order of elimination.
    #[inline]
    pub fn position(&self, row: usize) -> usize {
        self.order.position_of[row] as usize
    }

    /// Rows of the matrix in the order of elimination.
    pub fn rows_in_order(&self) -> &[u32] {
        &self.order.row_at
    }

    /// Replaces x by `L⁻ᵀ D⁻¹ x`, by positions.
    fn solve_backward(&self, x: &mut [f64]) {
        let Self { order, l, positions, counts, d, active, .. } = self;
        let columns = order.starts.iter().zip(counts).map(|(&start, &count)| start..start + count as usize);
        for (k, column) in columns.enumerate().rev() {
            if active[k] {
                x[k] = less_gathered(x[k] / d[k], &l[column.clone()], &positions[column], x);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Contacts on a grid of bodies: `A M⁻¹ Aᵀ` with two bodies in each row.
    fn grid(width: usize, rng: &mut impl RngExt) -> (SymmetricPattern, Vec<f64>) {
        let mut pairs = Vec::new();
        for body in 0..width * width {
            pairs.push((body, None));
            if body % width + 1 < width {
                pairs.push((body, Some(body + 1)));
            }
            if body + width < width * width {
                pairs.push((body, Some(body + width)));
            }
        }
        let bodies = |i: usize| -> Vec<usize> { [Some(pairs[i].0), pairs[i].1].into_iter().flatten().collect() };
        let meet = |i: usize, j: usize| bodies(i).iter().any(|body| bodies(j).contains(body));
        let n = pairs.len();
        let neighbours: Vec<Vec<usize>> = (0..n).map(|i| (0..n).filter(|&j| meet(i, j)).collect()).collect();
        let coordinates = 2 * width * width;
        let mut coefficient =
            |i: usize, c: usize| if bodies(i).contains(&(c / 2)) { rng.random_range(-1.0..1.0) } else { 0.0 };
        let a: Vec<f64> = (0..n * coordinates).map(|at| coefficient(at / coordinates, at % coordinates)).collect();
        let row = |i: usize| &a[i * coordinates..][..coordinates];
        let pattern = SymmetricPattern::new(&neighbours);
        let entries = (0..n).flat_map(|i| pattern.columns(i).iter().map(move |&j| (i, j as usize)));
        let entries = entries.map(|(i, j)| row(i).iter().zip(row(j)).map(|(a, b)| a * b).sum()).collect();
        (pattern, entries)
    }

    /// Checks what has to hold between calls.
    fn check_lists(factor: &SparseFactor) {
        assert!(factor.x.iter().all(|x| *x == 0.0) && factor.first.iter().all(|first| *first == NONE));
        let order = &factor.order;
        for k in 0..factor.d.len() {
            let room = order.positions[order.starts[k]..order.starts[k + 1]].iter().copied();
            let expected: Vec<u32> =
                room.filter(|&position| factor.active[k] && factor.active[position as usize]).collect();
            assert_eq!(factor.positions[factor.column(k)], expected);
            assert!(factor.active[k] || factor.d[k] == 1.0);
        }
    }

    /// Checks the lists, and that the factor is that of its set, with `shift` on the diagonal.
    fn check(m: SymmetricRows<'_>, shift: f64, factor: &mut SparseFactor) {
        check_lists(factor);
        let set: Vec<usize> = (0..m.size()).filter(|&i| factor.contains(i)).collect();
        let mut x: Vec<f64> = (0..m.size()).map(|i| libm::sin(i as f64)).collect();
        let b = x.clone();
        factor.solve(&mut x);
        let product = |i: usize| set.iter().map(|&j| m.entry(i, j) * x[j]).sum::<f64>() + shift * x[i];
        let error = set.iter().map(|&i| (product(i) - b[i]).abs()).fold(0.0, f64::max);
        let scale = 1.0 + set.iter().map(|&i| x[i].abs()).fold(0.0, f64::max);
        assert!(error < 1e-9 * scale, "{error:e} of {scale}: {set:?}");
        assert!((0..m.size()).all(|i| set.contains(&i) || x[i] == 0.0));
        check_lists(factor);
    }

    #[test]
    fn rows_enter_and_leave_in_any_order_and_the_factor_is_that_of_the_set() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(7);
        for width in [2, 5, 7] {
            let (pattern, entries) = grid(width, &mut rng);
            let m = SymmetricRows { pattern: &pattern, entries: &entries };
            let mut factor = SparseFactor::new(&pattern);
            // More rows than the bodies can tell apart: some are left out.
            let kept = factor.factorise(m, 0.0, 1e-9, |_| true);
            assert!(kept > width * width && (width == 2 || kept < m.size()), "{kept} of {}", m.size());
            check(m, 0.0, &mut factor);
            // Once more for this set, and for another one.
            let same: Vec<bool> = (0..m.size()).map(|i| factor.contains(i)).collect();
            assert_eq!(factor.factorise(m, 0.0, 1e-9, |i| same[i]), kept);
            check(m, 0.0, &mut factor);
            factor.factorise(m, 0.0, 1e-9, |i| i % 2 == 0);
            for _ in 0..200 {
                let row = rng.random_range(0..m.size());
                if factor.contains(row) {
                    factor.leave(row);
                } else {
                    let mut p: Vec<f64> = (0..m.size()).map(|i| m.entry(i, row)).collect();
                    factor.solve(&mut p);
                    let mut by_places = vec![f64::NAN; m.size()];
                    factor.response(m, row, &mut by_places);
                    let largest = p.iter().fold(0.0_f64, |largest, p| largest.max(p.abs()));
                    assert!((0..m.size()).all(|i| (by_places[factor.position(i)] - p[i]).abs() <= 1e-12 * largest));
                    let d = m.diagonal(row) - m.row(row).map(|(i, entry)| entry * p[i]).sum::<f64>();
                    if d > 1e-2 * m.diagonal(row) {
                        factor.enter(m, row, 0.0);
                    }
                }
                check(m, 0.0, &mut factor);
            }
        }
    }

    /// With a shift no row depends on others, so that nothing needs to be asked before one enters.
    #[test]
    fn nothing_is_left_behind_by_changes_without_a_solution_in_between() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(8);
        let (pattern, entries) = grid(6, &mut rng);
        let (m, shift) = (SymmetricRows { pattern: &pattern, entries: &entries }, 0.5);
        let mut factor = SparseFactor::new(&pattern);
        let mut copy = SparseFactor::new(&pattern);
        for turn in 0..40 {
            for _ in 0..1 + turn % 7 {
                let row = rng.random_range(0..m.size());
                if factor.contains(row) {
                    factor.leave(row)
                } else {
                    factor.enter(m, row, shift)
                }
                check_lists(&factor);
            }
            match turn % 4 {
                // For the set at hand, which has come about by changes, and for another one.
                0 => {
                    let set: Vec<bool> = (0..m.size()).map(|i| factor.contains(i)).collect();
                    let count = factor.factorise(m, shift, 0.0, |i| set[i]);
                    assert_eq!(count, set.iter().filter(|is_in| **is_in).count());
                }
                1 => drop(factor.factorise(m, shift, 0.0, |i| (i + turn) % 3 != 0)),
                // Onto a factor of another set.
                2 => {
                    copy.factorise(m, shift, 0.0, |i| i % 5 < turn % 5);
                    copy.copy_from(&factor);
                    check(m, shift, &mut copy);
                }
                _ => {}
            }
            check_lists(&factor);
            if turn % 3 == 0 {
                check(m, shift, &mut factor);
            }
        }
        check(m, shift, &mut factor);
    }

    #[test]
    fn a_row_that_is_not_a_number_stays_out() {
        let pattern = SymmetricPattern::new(&[vec![1], vec![0, 2], vec![1]]);
        let mut factor = SparseFactor::new(&pattern);
        let wrong = [2.0, f64::NAN, f64::NAN, 2.0, -1.0, -1.0, 2.0];
        assert!(factor.factorise(SymmetricRows { pattern: &pattern, entries: &wrong }, 0.0, 1e-9, |_| true) < 3);
        check_lists(&factor);
        let right = SymmetricRows { pattern: &pattern, entries: &[2.0, -1.0, -1.0, 2.0, -1.0, -1.0, 2.0] };
        assert_eq!(factor.factorise(right, 0.0, 1e-9, |_| true), 3);
        check(right, 0.0, &mut factor);
    }

    #[test]
    fn a_chain_has_no_fill() {
        let neighbours: Vec<Vec<usize>> = (0..50).map(|i: usize| vec![i.saturating_sub(1), (i + 1).min(49)]).collect();
        assert_eq!(EliminationOrder::new(&SymmetricPattern::new(&neighbours)).entries(), 49);
    }
}
