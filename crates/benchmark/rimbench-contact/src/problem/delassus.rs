//! The operator `H = A M⁻¹ Aᵀ` over the rows of contacts; where joints are eliminated `H_uu = A_u G A_uᵀ`, Eq. 4.

use super::{Cone, ContactProblem};
use crate::known_size;
use crate::linear_algebra::{SymmetricRows, dot};

/// The Delassus operator `H = A M⁻¹ Aᵀ`, symmetric positive semidefinite, 1/kg.
pub trait DelassusOperator: Copy {
    /// Returns H_ii, 1/kg.
    fn diagonal(&self, row: usize) -> f64;

    /// Returns `Σ_j H_ij P_j` and `Σ_j |H_ij P_j|` of a row, m/s.
    fn product(&self, row: usize, impulses: &[f64]) -> [f64; 2];
}

/// Adds up products of entries and impulses, and their magnitudes.
fn sums(products: impl Iterator<Item = f64>) -> [f64; 2] {
    products.fold([0.0; 2], |[sum, magnitudes], product| [sum + product, magnitudes + product.abs()])
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

    fn product(&self, row: usize, impulses: &[f64]) -> [f64; 2] {
        sums(self.row(row).iter().zip(impulses).map(|(h, p)| h * p))
    }
}

impl<K: Cone> ContactProblem<'_, DenseDelassus<'_>, K> {
    /// Writes `w = H P + b`. How the products of a row are added to `b` is part of the digits: `few` where the compiler
    /// knows the size, `many` elsewhere.
    #[inline]
    pub(crate) fn velocities_by(
        &self,
        impulses: &[f64],
        w: &mut [f64],
        few: impl Fn(f64, &[f64], &[f64]) -> f64,
        many: impl Fn(f64, &[f64], &[f64]) -> f64,
    ) {
        known_size!(
            self.b.len(),
            N if N.is_multiple_of(K::ROWS) => self.velocities_of_few::<N>(impulses, w, few),
            n => rows(n, self.delassus.h, self.b, impulses, w, many),
        );
    }

    #[inline(never)]
    fn velocities_of_few<const N: usize>(
        &self,
        impulses: &[f64],
        w: &mut [f64],
        row: impl Fn(f64, &[f64], &[f64]) -> f64,
    ) {
        rows(N, self.delassus.h, self.b, impulses, w, row);
    }
}

#[inline(always)]
fn rows(n: usize, h: &[f64], b: &[f64], impulses: &[f64], w: &mut [f64], row: impl Fn(f64, &[f64], &[f64]) -> f64) {
    let (h, b, impulses, w) = (&h[..n * n], &b[..n], &impulses[..n], &mut w[..n]);
    for (at, w) in w.iter_mut().enumerate() {
        // Before `b[at]` is read: the other way round a warm solve with friction takes 4.5 % more instructions.
        let line = &h[at * n..(at + 1) * n];
        *w = row(b[at], line, impulses);
    }
}

/// Computes [`ContactProblem::natural_residual`]; the problem comes as slices, as it would be passed through memory as
/// one.
#[inline(always)]
pub(super) fn natural_residual<K: Cone>(h: &[f64], b: &[f64], cone: K, impulses: &[f64]) -> f64 {
    known_size!(
        b.len(),
        N if N <= 8 || K::ROWS == 3 => residual_of_few::<N, K>(h, b, cone, impulses),
        _ => residual_of_many(h, b, cone, impulses),
    )
}

#[inline(never)]
fn residual_of_few<const N: usize, K: Cone>(h: &[f64], b: &[f64], cone: K, impulses: &[f64]) -> f64 {
    let mut w = [0.0; N];
    rows(N, h, b, impulses, &mut w, |b, h, p| (0..N).fold(0.0, |sum, column| sum + h[column] * p[column]) + b);
    let (delassus, b) = (DenseDelassus { h: &h[..N * N], rows: N }, &b[..N]);
    ContactProblem { delassus, b, cone }.residual_of(&impulses[..N], |row| w[row])
}

/// Computes row by row.
#[inline(never)]
fn residual_of_many<K: Cone>(h: &[f64], b: &[f64], cone: K, impulses: &[f64]) -> f64 {
    let delassus = DenseDelassus { h, rows: b.len() };
    ContactProblem { delassus, b, cone }.residual_of(impulses, |row| dot(delassus.row(row), impulses) + b[row])
}

impl DelassusOperator for SymmetricRows<'_> {
    #[inline]
    fn diagonal(&self, row: usize) -> f64 {
        SymmetricRows::diagonal(self, row)
    }

    fn product(&self, row: usize, impulses: &[f64]) -> [f64; 2] {
        sums(self.row(row).map(|(column, h)| h * impulses[column]))
    }
}
