//! One contact problem with friction.

use crate::problem::{ContactProblem, Coulomb, DenseDelassus};

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
}
