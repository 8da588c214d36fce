//! Cholesky factors in place, without allocation: plain loops where matrices are tiny, faer above.

use crate::error::Failure;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltParams, LltRegularization, cholesky_in_place, cholesky_in_place_scratch};
use faer::{MatMut, Par, Spec};
use std::fmt;

/// Size from which faer's blocked factorisation beats the plain loops.
const FAER_FROM: usize = 32;

/// `A = L Lᵀ` of a symmetric positive definite matrix, with its buffers.
pub(crate) struct Cholesky {
    size: usize,
    /// Row-major; the lower triangle holds `L` after [`factor`](Self::factor).
    pub(crate) l: Vec<f64>,
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
    pub(crate) fn new(size: usize) -> Self {
        let scratch = if size >= FAER_FROM {
            MemBuffer::new(cholesky_in_place_scratch::<f64>(size, Par::Seq, Spec::<LltParams, f64>::default()))
        } else {
            MemBuffer::new(faer::dyn_stack::StackReq::EMPTY)
        };
        Cholesky { size, l: vec![0.0; size * size], scratch }
    }

    /// Factors the matrix whose lower triangle stands in `l`. Names `matrix` if it is not positive definite.
    pub(crate) fn factor(&mut self, matrix: &'static str) -> Result<(), Failure> {
        let singular = Failure::Singular { matrix };
        if self.size >= FAER_FROM {
            // Row-major lower is column-major upper: hand faer the transposed view, whose lower triangle it wants.
            let view = MatMut::from_row_major_slice_mut(&mut self.l, self.size, self.size);
            return cholesky_in_place(
                view,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.scratch),
                Spec::<LltParams, f64>::default(),
            )
            .map(|_| ())
            .map_err(|_| singular);
        }
        factor_lower(&mut self.l, self.size).map_err(|()| singular)
    }

    /// Solves `L y = b` in place.
    #[inline]
    pub(crate) fn forward(&self, b: &mut [f64]) {
        let n = self.size;
        for i in 0..n {
            let row = &self.l[i * n..i * n + i];
            let mut value = b[i];
            for (l, y) in row.iter().zip(b.iter()) {
                value -= l * y;
            }
            b[i] = value / self.l[i * n + i];
        }
    }

    /// Solves `Lᵀ x = y` in place.
    #[inline]
    pub(crate) fn backward(&self, y: &mut [f64]) {
        let n = self.size;
        for i in (0..n).rev() {
            let value = y[i] / self.l[i * n + i];
            y[i] = value;
            for (j, yj) in y.iter_mut().enumerate().take(i) {
                *yj -= self.l[i * n + j] * value;
            }
        }
    }

    /// Solves `A x = b` in place.
    #[inline]
    pub(crate) fn solve(&self, b: &mut [f64]) {
        self.forward(b);
        self.backward(b);
    }
}

/// Plain in-place factorisation of the lower triangle, row by row.
fn factor_lower(a: &mut [f64], n: usize) -> Result<(), ()> {
    for i in 0..n {
        for j in 0..=i {
            let (upper, lower) = a.split_at_mut(i * n);
            let row_i = &mut lower[..n];
            if i == j {
                let pivot = row_i[i] - row_i[..i].iter().map(|x| x * x).sum::<f64>();
                // A pivot that is round-off of its own diagonal means a dependent row.
                if pivot.is_nan() || pivot <= 1e-13 * row_i[i].abs() || pivot <= 0.0 {
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

    fn spd(n: usize) -> Vec<f64> {
        let mut a = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                a[i * n + j] = 1.0 / (1.0 + (i as f64 - j as f64).abs()) + if i == j { 1.0 } else { 0.0 };
            }
        }
        a
    }

    #[test]
    fn small_and_large_sizes_solve_to_round_off() {
        for n in [1, 2, 5, 31, 32, 64] {
            let a = spd(n);
            let mut factor = Cholesky::new(n);
            factor.l.copy_from_slice(&a);
            factor.factor("test").unwrap();
            let exact: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
            let mut x: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a[i * n + j] * exact[j]).sum()).collect();
            factor.solve(&mut x);
            for (found, wanted) in x.iter().zip(&exact) {
                approx::assert_abs_diff_eq!(found, wanted, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn a_dependent_row_is_reported_by_the_name_of_the_matrix() {
        let mut factor = Cholesky::new(2);
        factor.l.copy_from_slice(&[1.0, 1.0, 1.0, 1.0]);
        assert_eq!(factor.factor("S"), Err(Failure::Singular { matrix: "S" }));
    }
}
