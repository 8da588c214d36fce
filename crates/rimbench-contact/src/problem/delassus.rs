//! The operator `H = A M⁻¹ Aᵀ` over the rows of contacts; where joints are eliminated `H_uu = A_u G A_uᵀ`, Eq. 4.

use super::{Cone, ContactProblem};
use crate::linear_algebra::{SymmetricRows, dot};

/// The Delassus operator `H = A M⁻¹ Aᵀ`, symmetric positive semidefinite, 1/kg.
pub trait DelassusOperator: Copy {
    /// Returns the number of rows.
    fn size(&self) -> usize;

    /// Returns H_ii, 1/kg.
    fn diagonal(&self, row: usize) -> f64;

    /// Returns one row of `w = H P + b`, m/s, summed in the order of this form of H.
    fn velocity(&self, row: usize, b: &[f64], impulses: &[f64]) -> f64;

    /// Computes [`ContactProblem::natural_residual`], m/s; a form of H may have a faster way.
    #[inline(always)]
    fn natural_residual<K: Cone>(problem: &ContactProblem<'_, Self, K>, impulses: &[f64]) -> f64 {
        problem.residual_of(impulses, |row| problem.delassus.velocity(row, problem.b, impulses))
    }
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
    #[inline]
    fn size(&self) -> usize {
        self.rows
    }

    #[inline(always)]
    fn diagonal(&self, row: usize) -> f64 {
        self.h[row * self.rows + row]
    }

    #[inline(always)]
    fn velocity(&self, row: usize, b: &[f64], impulses: &[f64]) -> f64 {
        dot(self.row(row), impulses) + b[row]
    }

    /// The compiler knows the sizes of few contacts.
    #[inline(always)]
    fn natural_residual<K: Cone>(problem: &ContactProblem<'_, Self, K>, impulses: &[f64]) -> f64 {
        match problem.delassus.rows {
            1 => of_few::<1, K>(problem.delassus.h, problem.b, problem.cone, impulses),
            2 => of_few::<2, K>(problem.delassus.h, problem.b, problem.cone, impulses),
            3 => of_few::<3, K>(problem.delassus.h, problem.b, problem.cone, impulses),
            4 => of_few::<4, K>(problem.delassus.h, problem.b, problem.cone, impulses),
            5 => of_few::<5, K>(problem.delassus.h, problem.b, problem.cone, impulses),
            6 => of_few::<6, K>(problem.delassus.h, problem.b, problem.cone, impulses),
            7 => of_few::<7, K>(problem.delassus.h, problem.b, problem.cone, impulses),
            8 => of_few::<8, K>(problem.delassus.h, problem.b, problem.cone, impulses),
            // Three, four and six contacts in space.
            9 if K::ROWS == 3 => of_few::<9, K>(problem.delassus.h, problem.b, problem.cone, impulses),
            12 if K::ROWS == 3 => of_few::<12, K>(problem.delassus.h, problem.b, problem.cone, impulses),
            18 if K::ROWS == 3 => of_few::<18, K>(problem.delassus.h, problem.b, problem.cone, impulses),
            _ => of_many(problem.delassus.h, problem.b, problem.cone, impulses),
        }
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
    ContactProblem { delassus, b, cone }.residual_of(impulses, |row| delassus.velocity(row, b, impulses))
}

impl DelassusOperator for SymmetricRows<'_> {
    #[inline]
    fn size(&self) -> usize {
        SymmetricRows::size(self)
    }

    #[inline]
    fn diagonal(&self, row: usize) -> f64 {
        SymmetricRows::diagonal(self, row)
    }

    #[inline]
    fn velocity(&self, row: usize, b: &[f64], impulses: &[f64]) -> f64 {
        b[row] + self.row(row).map(|(column, h)| h * impulses[column]).sum::<f64>()
    }
}
