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
        self.residual_with(impulses, w)
    }

    /// Does what [`measure`](Self::measure) does, where H is known to be finite: rows without impulse add nothing.
    #[inline]
    pub(super) fn measure_finite(&self, impulses: &[f64], w: &mut [f64]) -> f64 {
        known_size!(
            self.b.len(),
            N if T == 2 && N == 18 => self.velocities_of_loaded::<N>(impulses, w),
            _ => self.velocities(impulses, w),
        );
        self.residual_with(impulses, w)
    }

    #[inline(never)]
    fn velocities_of_loaded<const N: usize>(&self, impulses: &[f64], w: &mut [f64]) {
        let (h, b) = (&self.delassus.h.as_chunks::<N>().0[..N], &self.b[..N]);
        // +0 and not −0: adding products that are zero, which are left out here, would turn −0 into +0.
        let mut sums: [f64; N] = std::array::from_fn(|row| b[row] + 0.0);
        for (column, &impulse) in impulses[..N].iter().enumerate() {
            if impulse != 0.0 {
                for row in 0..N {
                    sums[row] += h[row][column] * impulse;
                }
            }
        }
        // In halves: to copy more than 16 numbers at once the compiler calls a function.
        let (first, second) = w[..N].split_at_mut(N / 2);
        first.copy_from_slice(&sums[..N / 2]);
        second.copy_from_slice(&sums[N / 2..]);
    }

    #[inline(always)]
    fn residual_with(&self, impulses: &[f64], w: &[f64]) -> f64 {
        known_size!(
            self.b.len(),
            N if T == 2 && N == 18 => self.residual_of_few::<N>(impulses, w),
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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn rows_without_impulse_may_be_left_out_of_a_finite_matrix_to_the_same_bits() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(11);
        for contacts in [3, 6, 7] {
            let size = 3 * contacts;
            for turn in 0..50 {
                let h: Vec<f64> = (0..size * size).map(|_| rng.random_range(-1.0..1.0)).collect();
                let b: Vec<f64> = (0..size).map(|_| rng.random_range(-1.0..1.0)).collect();
                let loaded: Vec<bool> = (0..contacts).map(|_| turn > 0 && rng.random_bool(0.5)).collect();
                let mut impulse = |row: usize| if loaded[row % contacts] { rng.random_range(-1.0..1.0) } else { -0.0 };
                let impulses: Vec<f64> = (0..size).map(&mut impulse).collect();
                let friction = vec![0.3; contacts];
                let problem = FrictionProblem::<2>::with_friction(&h, &b, &friction);
                let [mut w, mut of_loaded] = [vec![0.0; size], vec![0.0; size]];
                let residual = problem.measure(&impulses, &mut w);
                assert_eq!(residual, problem.measure_finite(&impulses, &mut of_loaded));
                assert!(w.iter().zip(&of_loaded).all(|(a, b)| a.to_bits() == b.to_bits()));
                // The independent measure adds in another order.
                assert!((residual - problem.natural_residual(&impulses)).abs() < 1e-12);
            }
        }
    }
}
