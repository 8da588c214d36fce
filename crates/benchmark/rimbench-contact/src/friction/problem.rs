//! One contact problem with friction.

use crate::known_size;
use crate::linear_algebra::dot;
use crate::problem::{ContactProblem, Coulomb, DenseDelassus};

/// One problem `w = H P + b` under Coulomb's law, `H = [H_nn H_nt; H_tn H_tt]` and `b = [b_n; b_t]`: normal rows before
/// tangential ones, the normal part of `b` with its gap terms, the tangential one with none. T tangential rows per
/// contact: 1 in the plane, 2 in space.
pub type FrictionProblem<'a, const T: usize = 1> = ContactProblem<'a, DenseDelassus<'a>, Coulomb<'a, T>>;

impl<const T: usize> FrictionProblem<'_, T> {
    /// Writes `w = H P + b`.
    #[inline]
    pub fn velocities(&self, impulses: &[f64], w: &mut [f64]) {
        match T {
            1 => self.velocities_by(impulses, w, in_pairs, in_pairs),
            _ => self.velocities_by(impulses, w, in_order, |b, h, p| b + dot(h, p)),
        }
    }

    /// Writes `w = H P + b`, the products of a row added as in [`dot`].
    #[inline]
    pub fn velocities_by_dot(&self, impulses: &[f64], w: &mut [f64]) {
        let row = |b: f64, h: &[f64], p: &[f64]| b + dot(h, p);
        self.velocities_by(impulses, w, row, row);
    }

    /// Writes `w = H P + b` and returns the natural residual.
    #[inline]
    pub(super) fn measure(&self, impulses: &[f64], w: &mut [f64]) -> f64 {
        self.velocities(impulses, w);
        known_size!(
            self.b.len(),
            N if T == 2 && N.is_multiple_of(3) => self.residual_of_few::<N>(impulses, w),
            _ => self.residual_of(impulses, |row| w[row]),
        )
    }

    #[inline(never)]
    fn residual_of_few<const N: usize>(&self, impulses: &[f64], w: &[f64]) -> f64 {
        let delassus = DenseDelassus { h: &self.delassus.h[..N * N], rows: N };
        let (b, cone) = (&self.b[..N], Coulomb::<'_, T> { friction: &self.cone.friction[..N / (1 + T)] });
        let (impulses, w) = (&impulses[..N], &w[..N]);
        ContactProblem { delassus, b, cone }.residual_of(impulses, |row| w[row])
    }
}

/// Two entries at once: with one tangential row each their number is even.
#[inline(always)]
fn in_pairs(b: f64, h: &[f64], p: &[f64]) -> f64 {
    let (mut even, mut odd) = (0.0, 0.0);
    for (h, p) in h.as_chunks::<2>().0.iter().zip(p.as_chunks::<2>().0) {
        even += h[0] * p[0];
        odd += h[1] * p[1];
    }
    b + (even + odd)
}

#[inline(always)]
fn in_order(b: f64, h: &[f64], p: &[f64]) -> f64 {
    h.iter().zip(p).fold(b, |sum, (h, p)| sum + h * p)
}
