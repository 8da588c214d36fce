//! Cholesky factors in place, without allocation: plain loops where matrices are tiny, faer above.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltParams, LltRegularization, cholesky_in_place, cholesky_in_place_scratch};
use faer::{MatMut, Par, Spec};
use std::fmt;

/// Size from which faer's blocked factorisation beats the plain loops, transposed twice as it is: from about 12 on,
/// three times as fast at 32, five times at 96. (On rows instead of columns faer would be no faster than the loops up
/// to 64; `benches/solvers.rs`.)
const FAER_FROM: usize = 16;
/// A pivot below this part of its own diagonal is round-off: a dependent row.
pub const DEPENDENT: f64 = 1e-13;

/// A matrix that must be positive definite is not (dependent bilateral rows, vanishing mass).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Singular {
    /// Which matrix.
    pub matrix: &'static str,
}

impl fmt::Display for Singular {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is singular", self.matrix)
    }
}

impl std::error::Error for Singular {}

/// `A = L Lᵀ` of a symmetric positive definite matrix, with its buffers.
pub struct Cholesky {
    size: usize,
    /// Row-major; the lower triangle holds `L` after [`factor`](Self::factor).
    pub l: Vec<f64>,
    scratch: MemBuffer,
}

impl fmt::Debug for Cholesky {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Cholesky").field("size", &self.size).field("l", &self.l).finish_non_exhaustive()
    }
}

impl Clone for Cholesky {
    fn clone(&self) -> Self {
        let mut copy = Cholesky::new(self.size);
        copy.l.copy_from_slice(&self.l);
        copy
    }
}

impl Cholesky {
    /// Makes the buffers for matrices of size `size`; zeros.
    pub fn new(size: usize) -> Self {
        let scratch = if size >= FAER_FROM {
            MemBuffer::new(cholesky_in_place_scratch::<f64>(size, Par::Seq, Spec::<LltParams, f64>::default()))
        } else {
            MemBuffer::new(faer::dyn_stack::StackReq::EMPTY)
        };
        Cholesky { size, l: vec![0.0; size * size], scratch }
    }

    /// Factors the matrix whose lower triangle stands in `l`.
    ///
    /// # Errors
    /// [`Singular`] naming `matrix` if it is not positive definite.
    #[inline]
    pub fn factor(&mut self, matrix: &'static str) -> Result<(), Singular> {
        match self.size {
            2 => self.factor_few::<2>(matrix),
            3 => self.factor_few::<3>(matrix),
            4 => self.factor_few::<4>(matrix),
            n if n < FAER_FROM => factor_lower(&mut self.l, n).map_err(|()| Singular { matrix }),
            _ => self.factor_blocked().map_err(|()| Singular { matrix }),
        }
    }

    /// [`factor`](Self::factor) of a matrix whose size the caller knows, straight through.
    ///
    /// # Errors
    /// As there.
    #[inline(always)]
    pub fn factor_few<const N: usize>(&mut self, matrix: &'static str) -> Result<(), Singular> {
        factor_lower(&mut self.l[..N * N], N).map_err(|()| Singular { matrix })
    }

    #[inline(never)]
    fn factor_blocked(&mut self) -> Result<(), ()> {
        mirror(&mut self.l, self.size, |lower, upper| *upper = *lower);
        // faer wants the lower triangle of columns: that is the upper one of rows.
        let view = MatMut::from_column_major_slice_mut(&mut self.l, self.size, self.size);
        cholesky_in_place(
            view,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Spec::<LltParams, f64>::default(),
        )
        .map_err(|_| ())?;
        mirror(&mut self.l, self.size, |lower, upper| *lower = *upper);
        // A_ii is the sum of the squares of a row of L; its pivot is held against it, as in the plain loops.
        let dependent = self.l.chunks_exact(self.size).enumerate().any(|(i, row)| {
            let diagonal: f64 = row[..=i].iter().map(|l| l * l).sum();
            row[i] * row[i] <= DEPENDENT * diagonal
        });
        if dependent { Err(()) } else { Ok(()) }
    }

    /// Solves `L y = b` in place.
    #[inline]
    pub fn forward(&self, b: &mut [f64]) {
        match self.size {
            2 => forward(&self.l[..4], 2, &mut b[..2]),
            3 => forward(&self.l[..9], 3, &mut b[..3]),
            4 => forward(&self.l[..16], 4, &mut b[..4]),
            n => forward(&self.l, n, b),
        }
    }

    /// Solves `Lᵀ x = y` in place.
    #[inline]
    pub fn backward(&self, y: &mut [f64]) {
        match self.size {
            2 => backward(&self.l[..4], 2, &mut y[..2]),
            3 => backward(&self.l[..9], 3, &mut y[..3]),
            4 => backward(&self.l[..16], 4, &mut y[..4]),
            n => backward(&self.l, n, y),
        }
    }

    /// Solves `A x = b` in place.
    #[inline]
    pub fn solve(&self, b: &mut [f64]) {
        self.forward(b);
        self.backward(b);
    }
}

/// Visits each pair of entries below and above the diagonal of a row-major matrix.
fn mirror(a: &mut [f64], n: usize, visit: impl Fn(&mut f64, &mut f64)) {
    for i in 0..n {
        let (above, row) = a.split_at_mut(i * n);
        for j in 0..i {
            visit(&mut row[j], &mut above[j * n + i]);
        }
    }
}

#[inline(always)]
fn forward(l: &[f64], n: usize, b: &mut [f64]) {
    for i in 0..n {
        let row = &l[i * n..i * n + i];
        let mut value = b[i];
        for (l, y) in row.iter().zip(b.iter()) {
            value -= l * y;
        }
        b[i] = value / l[i * n + i];
    }
}

#[inline(always)]
fn backward(l: &[f64], n: usize, y: &mut [f64]) {
    for i in (0..n).rev() {
        let value = y[i] / l[i * n + i];
        y[i] = value;
        for (j, yj) in y.iter_mut().enumerate().take(i) {
            *yj -= l[i * n + j] * value;
        }
    }
}

/// Solves `L Lᵀ x = b` in place, whose factor [`factor_lower`] left in `l`.
pub(crate) fn solve_lower(l: &[f64], n: usize, b: &mut [f64]) {
    forward(l, n, b);
    backward(l, n, b);
}

/// Factorises the lower triangle in place, row by row, so that every sum has one order on every machine.
#[inline(always)]
pub(crate) fn factor_lower(a: &mut [f64], n: usize) -> Result<(), ()> {
    for i in 0..n {
        for j in 0..=i {
            let (upper, lower) = a.split_at_mut(i * n);
            let row_i = &mut lower[..n];
            if i == j {
                let pivot = row_i[i] - row_i[..i].iter().map(|x| x * x).sum::<f64>();
                if pivot.is_nan() || pivot <= DEPENDENT * row_i[i].abs() || pivot <= 0.0 {
                    return Err(());
                }
                row_i[i] = pivot.sqrt();
            } else {
                let row_j = &upper[j * n..j * n + j + 1];
                let mut value = row_i[j];
                for k in 0..j {
                    value -= row_i[k] * row_j[k];
                }
                row_i[j] = value / row_j[j];
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The last row is twice the first one, but for a pivot of 1e-10 or none.
    #[test]
    fn whether_rows_depend_on_each_other_does_not_hang_on_their_unit() {
        for size in [3, 8, 20] {
            for unit in [1e-12, 1.0, 1e12] {
                let regular = |apart: f64| {
                    let mut cholesky = Cholesky::new(size);
                    for (at, l) in cholesky.l.iter_mut().enumerate() {
                        *l = unit
                            * match (at / size, at % size) {
                                (row, 0) if row == size - 1 => 2.0,
                                (row, column) if row == column && row == size - 1 => 4.0 + apart,
                                (row, column) => f64::from(u8::from(row == column)),
                            };
                    }
                    cholesky.factor("test").is_ok()
                };
                assert!(regular(1e-10) && !regular(0.0), "{size} rows of {unit:e}");
            }
        }
    }
}
