//! One contact problem with friction.

use crate::complementarity::Unsolved;

/// One problem `w = H P + b` under Coulomb's law, normal rows before tangential ones.
#[derive(Debug, Clone, Copy)]
pub struct FrictionProblem<'a> {
    /// `[H_nn H_nt; H_tn H_tt]`, 2n×2n, row-major, 1/kg; positive semidefinite.
    pub h: &'a [f64],
    /// `[b_n; b_t]`, length 2n, m/s; the normal part with its gap terms, the tangential one with none.
    pub b: &'a [f64],
    /// Coefficient of each contact, length n, not below 0.
    pub friction: &'a [f64],
}

impl FrictionProblem<'_> {
    /// Returns the number of contacts n.
    ///
    /// # Panics
    /// If the lengths do not fit.
    #[inline]
    pub fn contacts(&self) -> usize {
        let n = self.friction.len();
        assert_eq!((self.b.len(), self.h.len()), (2 * n, 4 * n * n), "b has length 2n, and H is 2n×2n");
        n
    }

    /// Returns one row of `H`.
    #[inline]
    pub fn row(&self, row: usize) -> &[f64] {
        let n = self.b.len();
        &self.h[row * n..(row + 1) * n]
    }

    /// Returns `‖b‖_∞`, m/s.
    #[inline]
    pub fn scale(&self) -> f64 {
        self.b.iter().fold(0.0, |max: f64, b| if b.abs() > max { b.abs() } else { max })
    }

    /// Tells whether `P = 0` is a solution, that is `b_n ≥ 0`. Looks at `b` only.
    ///
    /// # Errors
    /// [`Unsolved::NonFinite`] if `b` is not finite.
    #[inline]
    pub fn is_solved_by_zero(&self) -> Result<bool, Unsolved> {
        if !self.b.iter().all(|b| b.is_finite()) {
            return Err(Unsolved::NonFinite);
        }
        Ok(self.b[..self.friction.len()].iter().all(|b| *b >= 0.0))
    }

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
        let (h, b, impulses, w) = (&self.h[..n * n], &self.b[..n], &impulses[..n], &mut w[..n]);
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
        let of = |c: usize| 1.0 - self.friction[c] * (self.row(c)[n + c] / self.row(c)[c]).abs();
        (0..n).filter(|&c| self.row(c)[c] > 0.0).map(of).fold(f64::INFINITY, f64::min)
    }
}
