//! The usual case of a simulation, for few contacts: the active set of the last problem is that of this one.

use super::{ActiveSet, NEGLIGIBLE};
use crate::complementarity::Lcp;

impl ActiveSet {
    /// Writes the solution on the active set at hand if it is one; else returns false and leaves everything as it was.
    ///
    /// The same operations in the same order as the general way, so the same digits, but with the size known to the
    /// compiler and nothing stored that only pivoting needs.
    #[inline]
    pub(super) fn confirm_few(&self, lcp: Lcp<'_>, z: &mut [f64]) -> bool {
        match lcp.q.len() {
            1 => self.confirm::<1>(lcp, z),
            2 => self.confirm::<2>(lcp, z),
            3 => self.confirm::<3>(lcp, z),
            4 => self.confirm::<4>(lcp, z),
            5 => self.confirm::<5>(lcp, z),
            6 => self.confirm::<6>(lcp, z),
            7 => self.confirm::<7>(lcp, z),
            8 => self.confirm::<8>(lcp, z),
            _ => false,
        }
    }

    /// A function per size, or the saving is lost in one large frame.
    #[inline(never)]
    fn confirm<const N: usize>(&self, lcp: Lcp<'_>, z: &mut [f64]) -> bool {
        let (rows, _) = lcp.m.as_chunks::<N>();
        let (Ok(q), Ok(z)) = (<&[f64; N]>::try_from(lcp.q), <&mut [f64; N]>::try_from(z)) else { return false };
        // Eight members are solved for in another order of operations.
        if self.len == 0 || self.len >= 8 || self.len > N || rows.len() != N {
            return false;
        }
        let set = &self.set[..self.len];
        let mut z_a = [0.0; N];
        for (z, &a) in z_a.iter_mut().zip(set) {
            *z = -q[a];
        }
        self.factor.solve_few(&mut z_a);
        let mut w = *q;
        let (mut pushes, mut q_max) = (true, 0.0_f64);
        for (&z, &a) in z_a.iter().zip(set) {
            pushes &= z >= 0.0;
            for (w, m) in w.iter_mut().zip(&rows[a]) {
                *w += m * z;
            }
        }
        for q in q {
            q_max = q_max.max(q.abs());
        }
        // Members have w = 0 up to rounding.
        for &a in set {
            w[a] = 0.0;
        }
        let negligible = NEGLIGIBLE * q_max;
        let holds = w.iter().fold(pushes, |holds, w| holds & (*w >= -negligible));
        if holds {
            *z = [0.0; N];
            for (&z_a, &a) in z_a.iter().zip(set) {
                z[a] = z_a;
            }
        }
        holds
    }
}
