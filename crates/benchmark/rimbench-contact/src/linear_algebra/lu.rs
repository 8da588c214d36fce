//! Solution of a dense system by Gaussian elimination with row pivoting: plain loops where it is small, faer above.

use super::buffer::Buffer;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor as lu_factor, solve as lu_solve};
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{MatMut, Par, Spec};
use std::fmt;

/// Size from which faer's blocked elimination beats the plain loops: 1.05 times at 64, 1.4 at 128, 2 at 192.
const FAER_FROM: usize = 64;

/// Room to solve systems of up to the size it was made for.
pub struct Lu {
    capacity: usize,
    /// The pivot row of the plain loops.
    row: Buffer<f64, 8>,
    order: Vec<usize>,
    inverse_order: Vec<usize>,
    scratch: MemBuffer,
}

impl Lu {
    /// Makes the room; the only place that allocates, but for one buffer that faer makes per thread.
    pub fn new(capacity: usize) -> Self {
        let blocked = if capacity >= FAER_FROM { capacity } else { 0 };
        let factor = lu_factor::lu_in_place_scratch::<usize, f64>(blocked, blocked, Par::Seq, Spec::default());
        let solve = lu_solve::solve_in_place_scratch::<usize, f64>(blocked, 1, Par::Seq);
        Lu {
            capacity,
            row: Buffer::new(capacity.min(FAER_FROM)),
            order: vec![0; blocked],
            inverse_order: vec![0; blocked],
            scratch: MemBuffer::new(factor.or(solve)),
        }
    }

    /// Makes more room if `n` needs it.
    pub fn grow(&mut self, n: usize) {
        if n > self.capacity {
            *self = Lu::new(n);
        }
    }

    /// Replaces `b` by `A⁻¹ b` and destroys `a` (row-major); false if `A` is singular to working precision.
    pub fn solve(&mut self, a: &mut [f64], b: &mut [f64]) -> bool {
        let n = b.len();
        if n < FAER_FROM { eliminate_by_rows(a, b, &mut self.row) } else { self.solve_by_blocks(a, b) }
    }

    fn solve_by_blocks(&mut self, a: &mut [f64], b: &mut [f64]) -> bool {
        let n = b.len();
        let largest = largest_entry(a);
        let mut lu = MatMut::from_row_major_slice_mut(a, n, n);
        let (order, inverse_order) = (&mut self.order[..n], &mut self.inverse_order[..n]);
        let stack = MemStack::new(&mut self.scratch);
        let (_, order) = lu_factor::lu_in_place(lu.rb_mut(), order, inverse_order, Par::Seq, stack, Spec::default());
        if (0..n).any(|k| !is_pivot(lu[(k, k)], largest)) {
            return false;
        }
        let x = MatMut::from_column_major_slice_mut(b, n, 1);
        lu_solve::solve_in_place(lu.rb(), lu.rb(), order, x, Par::Seq, MemStack::new(&mut self.scratch));
        true
    }
}

impl Clone for Lu {
    fn clone(&self) -> Self {
        Lu::new(self.capacity)
    }
}

impl fmt::Debug for Lu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Lu").field("capacity", &self.capacity).finish_non_exhaustive()
    }
}

/// Returns the largest `|a_k|`; what is not a number does not count.
#[inline]
pub fn largest_entry(a: &[f64]) -> f64 {
    a.iter().fold(0.0_f64, |max, entry| if entry.abs() > max { entry.abs() } else { max })
}

fn is_pivot(entry: f64, largest: f64) -> bool {
    // False for NaN.
    entry.abs() > f64::EPSILON * largest
}

/// Replaces `b` by `A⁻¹ b` and destroys `a`, row by row, so that every sum has one order on every machine; `row` is
/// room for one. False if A is singular to working precision.
pub(crate) fn eliminate_by_rows(a: &mut [f64], b: &mut [f64], row: &mut [f64]) -> bool {
    let n = b.len();
    let largest = largest_entry(a);
    for k in 0..n {
        let pivot = (k..n).fold(k, |best, i| if a[i * n + k].abs() > a[best * n + k].abs() { i } else { best });
        if !is_pivot(a[pivot * n + k], largest) {
            return false;
        }
        if pivot != k {
            let (above, below) = a.split_at_mut(pivot * n);
            above[k * n..(k + 1) * n].swap_with_slice(&mut below[..n]);
            b.swap(k, pivot);
        }
        let tail = n - k;
        row[..tail].copy_from_slice(&a[k * n + k..(k + 1) * n]);
        for i in k + 1..n {
            let target = &mut a[i * n + k..(i + 1) * n];
            let factor = target[0] / row[0];
            for (entry, above) in target.iter_mut().zip(&row[..tail]) {
                *entry -= factor * above;
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k * n + j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k * n + k];
    }
    true
}

/// Does what [`eliminate_by_rows`] does, to the same bits, for a size that the compiler knows. It knows the columns as
/// well where they are few; where not, whole rows are subtracted, also what is not read any more.
pub(crate) fn eliminate_few<const N: usize>(a: &mut [f64], b: &mut [f64]) -> bool {
    let (a, b) = (&mut a.as_chunks_mut::<N>().0[..N], &mut b[..N]);
    let mut most = [0.0_f64; N];
    for line in &*a {
        for (most, entry) in most.iter_mut().zip(line) {
            *most = if entry.abs() > *most { entry.abs() } else { *most };
        }
    }
    let largest = largest_entry(&most);
    macro_rules! columns {
        ($($k:literal)+) => { $(
            if $k < N && !eliminate_column::<N>(a, b, $k, $k + 1, largest) {
                return false;
            }
        )+ };
    }
    if N <= 9 {
        columns!(0 1 2 3 4 5 6 7 8);
    } else if !(0..N).all(|k| eliminate_column::<N>(a, b, k, 0, largest)) {
        return false;
    }
    for k in (0..N).rev() {
        let known: f64 = (k + 1..N).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    true
}

/// Finds the pivot of column `k` and takes its row from those below, from the entry `first` on; false if it is none.
#[inline(always)]
fn eliminate_column<const N: usize>(a: &mut [[f64; N]], b: &mut [f64], k: usize, first: usize, largest: f64) -> bool {
    let (a, b) = (&mut a[..N], &mut b[..N]);
    // Most often the entry on the diagonal is the largest, and no comparison has to wait for another.
    let size = a[k][k].abs();
    let mut pivot = k;
    if (k + 1..N).fold(false, |larger, i| larger | (a[i][k].abs() > size)) {
        pivot = (k..N).fold(k, |best, i| if a[i][k].abs() > a[best][k].abs() { i } else { best });
    }
    if !is_pivot(a[pivot][k], largest) {
        return false;
    }
    if pivot != k {
        a.swap(k, pivot);
        b.swap(k, pivot);
    }
    let (row, right) = (a[k], b[k]);
    for i in k + 1..N {
        let factor = a[i][k] / row[k];
        for j in first..N {
            a[i][j] -= factor * row[j];
        }
        b[i] -= factor * right;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn a_size_that_the_compiler_knows_gives_the_same_bits() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(9);
        for turn in 0..100 {
            let a: Vec<f64> = (0..81).map(|_| rng.random_range(-1.0..1.0)).collect();
            let b: Vec<f64> = (0..9).map(|_| rng.random_range(-1.0..1.0)).collect();
            let ([mut a, mut few], [mut b, mut x]) = ([a.clone(), a], [b.clone(), b]);
            if turn == 0 {
                for matrix in [&mut a, &mut few] {
                    matrix.copy_within(0..9, 9);
                }
            }
            let solved = eliminate_by_rows(&mut a, &mut b, &mut [0.0; 9]);
            assert_eq!((solved, eliminate_few::<9>(&mut few, &mut x)), (turn > 0, turn > 0));
            assert!(turn == 0 || b.iter().zip(&x).all(|(b, x)| b.to_bits() == x.to_bits()));
        }
    }
}
