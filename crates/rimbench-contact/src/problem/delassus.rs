//! The operator `H = A M⁻¹ Aᵀ` over the rows of contacts; where joints are eliminated `H_uu = A_u G A_uᵀ`, Eq. 4.

use super::{Cone, ContactProblem};
use crate::linear_algebra::{SymmetricRows, dot};

/// The Delassus operator `H = A M⁻¹ Aᵀ`, symmetric positive semidefinite, 1/kg.
pub trait DelassusOperator: Copy {
    /// Returns H_ii, 1/kg.
    fn diagonal(&self, row: usize) -> f64;
}

/// H as a full matrix.
#[derive(Debug, Clone, Copy)]
pub struct DenseDelassus<'a> {
    /// `n×n`, row-major, 1/kg.
    pub h: &'a [f64],
    /// n.
    pub rows: usize,
}

impl<'a> DenseDelassus<'a> {
    /// Returns one row, n entries in 1/kg.
    #[inline]
    pub fn row(&self, row: usize) -> &'a [f64] {
        &self.h[row * self.rows..(row + 1) * self.rows]
    }
}

impl DelassusOperator for DenseDelassus<'_> {
    #[inline(always)]
    fn diagonal(&self, row: usize) -> f64 {
        self.h[row * self.rows + row]
    }
}

/// Computes [`ContactProblem::natural_residual`]. The compiler knows the sizes of few contacts.
#[inline(always)]
pub(super) fn natural_residual<K: Cone>(h: &[f64], b: &[f64], cone: K, impulses: &[f64]) -> f64 {
    match b.len() {
        1 => of_few::<1, K>(h, b, cone, impulses),
        2 => of_few::<2, K>(h, b, cone, impulses),
        3 => of_few::<3, K>(h, b, cone, impulses),
        4 => of_few::<4, K>(h, b, cone, impulses),
        5 => of_few::<5, K>(h, b, cone, impulses),
        6 => of_few::<6, K>(h, b, cone, impulses),
        7 => of_few::<7, K>(h, b, cone, impulses),
        8 => of_few::<8, K>(h, b, cone, impulses),
        // Three, four and six contacts in space.
        9 if K::ROWS == 3 => of_few::<9, K>(h, b, cone, impulses),
        12 if K::ROWS == 3 => of_few::<12, K>(h, b, cone, impulses),
        18 if K::ROWS == 3 => of_few::<18, K>(h, b, cone, impulses),
        _ => of_many(h, b, cone, impulses),
    }
}

/// Computes all rows at once, column by column of H. One function per size, as one large stack frame would lose the saving; the problem
/// comes as slices, as it would be passed through memory as one.
#[inline(never)]
fn of_few<const N: usize, K: Cone>(h: &[f64], b: &[f64], cone: K, impulses: &[f64]) -> f64 {
    let (h, b, impulses) = (&h[..N * N], &b[..N], &impulses[..N]);
    let mut w = [0.0; N];
    for j in 0..N {
        for i in 0..N {
            w[i] += h[i * N + j] * impulses[j];
        }
    }
    for (w, b) in w.iter_mut().zip(b) {
        *w += b;
    }
    ContactProblem { delassus: DenseDelassus { h, rows: N }, b, cone }.residual_of(impulses, |row| w[row])
}

/// Computes row by row.
#[inline(never)]
fn of_many<K: Cone>(h: &[f64], b: &[f64], cone: K, impulses: &[f64]) -> f64 {
    let delassus = DenseDelassus { h, rows: b.len() };
    ContactProblem { delassus, b, cone }.residual_of(impulses, |row| dot(delassus.row(row), impulses) + b[row])
}

impl DelassusOperator for SymmetricRows<'_> {
    #[inline]
    fn diagonal(&self, row: usize) -> f64 {
        SymmetricRows::diagonal(self, row)
    }
}
