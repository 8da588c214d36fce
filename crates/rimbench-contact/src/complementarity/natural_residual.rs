//! The one check every solver is held to, computed from the problem and the answer alone.

use super::Lcp;
use crate::linear_algebra::{SparseRows, dot};

/// Measures how far `z` is from solving the problem, in velocities relative to the largest entry of `q`.
///
/// ```text
/// w = M z + q          r = max_i |min(M_ii z_i, w_i)| / max(‖q‖_∞, tiny)
/// ```
/// `r = 0` if and only if `z` solves the problem exactly. `M_ii z_i` is the velocity the impulse `z_i` alone would
/// cause, so both arguments of the minimum are velocities: a change of the unit of mass (`M → M/s`, `z → s z`) or of
/// velocity leaves `r` unchanged, and a negative impulse, a penetrating velocity and an impulse at an opening contact
/// count alike. A row with `M_ii ≤ 0` (in a semidefinite matrix a row of zeros) is measured with `z_i` itself.
///
/// `w` is recomputed from `M`, `q` and `z`; nothing is taken from the solver. For `q ≥ 0` and `z = 0` the result is 0.
/// Anything that is not finite, in `M`, `q`, `z` or `w`, makes the result infinite.
///
/// # Shapes and units
/// `M` n×n (1/kg), `q` n (m/s), `z` n (N·s); returns a pure number.
/// # Panics
/// If the lengths do not fit.
/// # Source
/// Cottle, Pang, Stone, *The Linear Complementarity Problem* (1992), section 5.10 (`min(z, w)`); the weight `M_ii` is ours.
#[inline(always)]
pub fn natural_residual(lcp: Lcp<'_>, z: &[f64]) -> f64 {
    let n = lcp.size();
    assert_eq!(z.len(), n, "z has one entry per row of M");
    // Sizes of a few contacts known to the compiler take about half of the time.
    match n {
        1 => few::<1>(lcp.m, lcp.q, z),
        2 => few::<2>(lcp.m, lcp.q, z),
        3 => few::<3>(lcp.m, lcp.q, z),
        4 => few::<4>(lcp.m, lcp.q, z),
        5 => few::<5>(lcp.m, lcp.q, z),
        6 => few::<6>(lcp.m, lcp.q, z),
        7 => few::<7>(lcp.m, lcp.q, z),
        8 => few::<8>(lcp.m, lcp.q, z),
        _ => measure(lcp, z, (0..n).map(|i| dot(&lcp.m[i * n..(i + 1) * n], z) + lcp.q[i])),
    }
}

/// [`natural_residual`] of a problem whose matrix is the one that `rows` has read: the same sums without their zeros.
#[inline]
pub(super) fn natural_residual_of_rows(lcp: Lcp<'_>, rows: &SparseRows, z: &[f64]) -> f64 {
    if !rows.holds() {
        return natural_residual(lcp, z);
    }
    let sum = |i: usize| rows.row(i).map(|(j, m_ij)| m_ij * z[j]).sum::<f64>();
    measure(lcp, z, (0..lcp.size()).map(|i| sum(i) + lcp.q[i]))
}

/// All rows side by side, one `z_j` after the other. A function per size, or the saving is lost in one large frame; slices
/// one by one, for the problem as one would go through memory.
#[inline(never)]
fn few<const N: usize>(m: &[f64], q: &[f64], z: &[f64]) -> f64 {
    let (m, q, z) = (&m[..N * N], &q[..N], &z[..N]);
    let mut w = [0.0; N];
    for j in 0..N {
        for i in 0..N {
            w[i] += m[i * N + j] * z[j];
        }
    }
    measure(Lcp::new(m, q), z, w.into_iter().zip(q).map(|(w, q)| w + q))
}

#[inline(always)]
fn measure(lcp: Lcp<'_>, z: &[f64], w: impl Iterator<Item = f64>) -> f64 {
    let n = z.len();
    let (mut worst, mut scale) = (0.0, f64::MIN_POSITIVE);
    // Stays zero as long as every w is finite; a NaN anywhere in M, q or z reaches w.
    let mut not_finite = 0.0;
    for (i, w_i) in w.enumerate() {
        let (m_ii, q_i) = (lcp.m[i * n + i], lcp.q[i].abs());
        not_finite += w_i * 0.0;
        let effect = if m_ii > 0.0 { m_ii * z[i] } else { z[i] };
        let violation = if effect < w_i { effect } else { w_i }.abs();
        worst = if violation > worst { violation } else { worst };
        scale = if q_i > scale { q_i } else { scale };
    }
    if not_finite == 0.0 { worst / scale } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    const M: [f64; 4] = [2.0, 1.0, 1.0, 2.0];

    fn residual(q: [f64; 2], z: [f64; 2]) -> f64 {
        natural_residual(Lcp::new(&M, &q), &z)
    }

    #[test]
    fn a_solution_has_residual_zero() {
        assert_eq!(residual([-5.0, -6.0], [4.0 / 3.0, 7.0 / 3.0]), 0.0);
        assert_eq!(residual([3.0, 0.0], [0.0, 0.0]), 0.0);
        assert_eq!(natural_residual(Lcp::new(&[], &[]), &[]), 0.0);
    }

    #[test]
    fn each_kind_of_violation_counts_in_velocities() {
        assert_eq!(residual([-4.0, 1.0], [0.0, 0.0]), 1.0, "penetrating velocity");
        assert_eq!(residual([4.0, 8.0], [-1.0, 0.0]), 2.0 / 8.0, "pulling impulse");
        assert_eq!(residual([4.0, 8.0], [0.5, 0.0]), 1.0 / 8.0, "impulse at an opening contact");
    }

    #[test]
    fn the_unit_of_mass_does_not_matter() {
        let (q, z) = ([-5.0, 1.0], [2.0, 0.5]);
        let heavy: Vec<f64> = M.iter().map(|m| m / 1024.0).collect();
        let scaled = natural_residual(Lcp::new(&heavy, &q), &z.map(|z| z * 1024.0));
        assert_eq!(scaled, residual(q, z));
    }

    #[test]
    fn whatever_is_not_finite_is_infinitely_wrong() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(residual([bad, 1.0], [0.0, 0.0]), f64::INFINITY);
            assert_eq!(residual([1.0, 1.0], [0.0, bad]), f64::INFINITY);
            let m = [2.0, bad, bad, 2.0];
            assert_eq!(natural_residual(Lcp::new(&m, &[1.0, 1.0]), &[0.0, 0.0]), f64::INFINITY);
        }
    }

    #[test]
    fn without_its_zeros_a_matrix_gives_the_same_residual() {
        let n = 48;
        // Integers below 2^50: every order of summation is exact.
        let mut m: Vec<f64> = (0..n * n).map(|k: usize| [6.0, -2.0, 0.0][(k / n).abs_diff(k % n).min(2)]).collect();
        let q: Vec<f64> = (0..n).map(|i| (i * 7 % 11) as f64 - 5.0).collect();
        let z: Vec<f64> = (0..n).map(|i| (i * 5 % 7) as f64 - 1.0).collect();
        let mut rows = SparseRows::new(n);
        rows.read(&m, n);
        let lcp = Lcp::new(&m, &q);
        assert!(rows.holds() && natural_residual(lcp, &z) > 0.0);
        assert_eq!(natural_residual_of_rows(lcp, &rows, &z), natural_residual(lcp, &z));
        m[n + 40] = f64::NAN;
        rows.read(&m, n);
        let (lcp, z) = (Lcp::new(&m, &q), vec![0.0; n]);
        assert_eq!(natural_residual_of_rows(lcp, &rows, &z), f64::INFINITY);
    }

    #[test]
    fn a_row_of_zeros_is_measured_with_its_impulse() {
        let lcp = Lcp::new(&[0.0], &[1.0]);
        assert_eq!(natural_residual(lcp, &[0.0]), 0.0);
        assert_eq!(natural_residual(lcp, &[-0.5]), 0.5);
    }
}
