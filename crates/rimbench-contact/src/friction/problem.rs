//! One contact problem with friction.

use crate::problem::{ContactProblem, Coulomb, DelassusOperator, DenseDelassus};

/// One problem `w = H P + b` under Coulomb's law, `H = [H_nn H_nt; H_tn H_tt]` and `b = [b_n; b_t]`: normal rows before tangential ones, the
/// normal part of `b` with its gap terms, the tangential one with none. T tangential rows per contact: 1 in the plane, 2 in space.
pub type FrictionProblem<'a, const T: usize = 1> = ContactProblem<'a, DenseDelassus<'a>, Coulomb<'a, T>>;

impl ContactProblem<'_, DenseDelassus<'_>, Coulomb<'_>> {
    /// Writes `w = H P + b`.
    #[inline]
    pub fn velocities(&self, impulses: &[f64], w: &mut [f64]) {
        match self.b.len() {
            2 => self.velocities_of_few::<2>(impulses, w),
            4 => self.velocities_of_few::<4>(impulses, w),
            6 => self.velocities_of_few::<6>(impulses, w),
            8 => self.velocities_of_few::<8>(impulses, w),
            n => self.velocities_of(n, impulses, w),
        }
    }

    #[inline(never)]
    fn velocities_of_few<const N: usize>(&self, impulses: &[f64], w: &mut [f64]) {
        self.velocities_of(N, impulses, w);
    }

    #[inline(always)]
    fn velocities_of(&self, n: usize, impulses: &[f64], w: &mut [f64]) {
        let (h, b, impulses, w) = (&self.delassus.h[..n * n], &self.b[..n], &impulses[..n], &mut w[..n]);
        for (row, w) in w.iter_mut().enumerate() {
            // Two entries at once: their number is even.
            let (mut even, mut odd) = (0.0, 0.0);
            let line = h[row * n..(row + 1) * n].as_chunks::<2>().0;
            for (h, p) in line.iter().zip(impulses.as_chunks::<2>().0) {
                even += h[0] * p[0];
                odd += h[1] * p[1];
            }
            *w = b[row] + (even + odd);
        }
    }

    /// Returns `min (H_nn − μ |H_nt|) / H_nn` over the contacts: how far the problem is from Painlevé's.
    ///
    /// Where this is not above 0 a sliding contact can be pushed in by its own friction; it may then have several solutions or none. With
    /// one contact and a value above 0 there is exactly one; several contacts can be ambiguous before. +∞ without contacts.
    pub fn painleve_margin(&self) -> f64 {
        let n = self.contacts();
        let of =
            |c: usize| 1.0 - self.cone.friction[c] * (self.delassus.row(c)[n + c] / self.delassus.diagonal(c)).abs();
        (0..n).filter(|&c| self.delassus.diagonal(c) > 0.0).map(of).fold(f64::INFINITY, f64::min)
    }
}
