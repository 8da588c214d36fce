//! The one check every method is held to, computed from the problem and the answer alone.

use super::FrictionProblem;

/// Measures how far `P` is from solving the problem, in velocities relative to the largest entry of `b`.
///
/// ```text
/// w = H P + b        r = max_c max( |min(H_nn P_n, w_n)|,  H_tt |P_t − proj_[±μ P_n](P_t − w_t / H_tt)| ) / max(‖b‖_∞, tiny)
/// ```
/// `r = 0` if and only if `P` solves the problem exactly: the second term is 0 for a contact that sticks within its cone, and for one that
/// slides at its border against the motion. The projection is on the interval of the normal impulse at hand, or on 0 if that pulls. A row
/// with `H_nn ≤ 0` or `H_tt ≤ 0` is measured with the impulse itself. Whatever is not finite makes the result infinite.
///
/// # Shapes and units
/// `impulses` 2n (N·s); returns a pure number.
/// # Panics
/// If the lengths do not fit.
/// # Source
/// The natural map of Coulomb's law in the plane; weights ours, as in [`complementarity`](crate::complementarity::natural_residual).
pub fn natural_residual(problem: FrictionProblem<'_>, impulses: &[f64]) -> f64 {
    let n = problem.contacts();
    assert_eq!(impulses.len(), 2 * n, "P has two entries per contact");
    let worst = violation(problem, impulses, |row| {
        problem.b[row] + problem.row(row).iter().zip(impulses).map(|(h, p)| h * p).sum::<f64>()
    });
    // ‖b‖_∞ may be infinite, too.
    if worst.is_finite() { worst / problem.scale().max(f64::MIN_POSITIVE) } else { f64::INFINITY }
}

/// The residual times `‖b‖_∞`, m/s, from velocities `H P + b` that may be at hand already. Infinite where something is not finite.
#[inline(always)]
pub(super) fn violation(problem: FrictionProblem<'_>, impulses: &[f64], velocity: impl Fn(usize) -> f64) -> f64 {
    let n = problem.friction.len();
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let (mut worst, mut not_finite) = (0.0, 0.0);
    for contact in 0..n {
        let weight = |row: usize| {
            let h = problem.row(row)[row];
            if h > 0.0 { h } else { 1.0 }
        };
        let (w_n, w_t) = (velocity(contact), velocity(n + contact));
        not_finite += w_n * 0.0 + w_t * 0.0;
        let (h_nn, h_tt) = (weight(contact), weight(n + contact));
        let (p_n, p_t) = (impulses[contact], impulses[n + contact]);
        let (pressing, bound) = (h_nn * p_n, problem.friction[contact] * larger(0.0, p_n));
        let wanted = p_t - w_t / h_tt;
        let wanted = if wanted > bound { bound } else { wanted };
        let projected = if wanted < -bound { -bound } else { wanted };
        worst = larger(worst, if pressing < w_n { pressing } else { w_n }.abs());
        worst = larger(worst, h_tt * (p_t - projected).abs());
    }
    if not_finite == 0.0 { worst } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point of 0.5 kg.
    const H: [f64; 4] = [2.0, 0.0, 0.0, 2.0];

    fn residual(b: [f64; 2], p: [f64; 2]) -> f64 {
        natural_residual(FrictionProblem { h: &H, b: &b, friction: &[0.5] }, &p)
    }

    #[test]
    fn a_solution_has_residual_zero_in_every_state() {
        assert_eq!(residual([1.0, 8.0], [0.0, 0.0]), 0.0, "open");
        assert_eq!(residual([-4.0, 1.0], [2.0, -0.5]), 0.0, "stick");
        assert_eq!(residual([-4.0, 8.0], [2.0, -1.0]), 0.0, "slip forwards");
        assert_eq!(residual([-4.0, -8.0], [2.0, 1.0]), 0.0, "slip backwards");
        assert_eq!(natural_residual(FrictionProblem { h: &[], b: &[], friction: &[] }, &[]), 0.0);
    }

    #[test]
    fn each_kind_of_violation_counts_in_velocities() {
        assert_eq!(residual([-4.0, 0.0], [0.0, 0.0]), 1.0, "penetrating velocity");
        assert_eq!(residual([4.0, 0.0], [-1.0, 0.0]), 2.0 / 4.0, "pulling impulse");
        assert_eq!(residual([-4.0, 1.0], [2.0, 0.0]), 1.0 / 4.0, "slides without friction although it would stick");
        assert_eq!(residual([-4.0, 8.0], [2.0, -2.0]), 2.0 / 8.0, "friction beyond its cone");
        assert_eq!(residual([-4.0, 8.0], [2.0, 1.0]), 4.0 / 8.0, "friction along the motion");
        assert_eq!(residual([4.0, 8.0], [0.0, -1.0]), 2.0 / 8.0, "friction at an open contact");
    }

    #[test]
    fn whatever_is_not_finite_is_infinitely_wrong() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(residual([bad, 1.0], [0.0, 0.0]), f64::INFINITY);
            assert_eq!(residual([1.0, bad], [0.0, 0.0]), f64::INFINITY);
            assert_eq!(residual([1.0, 1.0], [bad, 0.0]), f64::INFINITY);
            assert_eq!(residual([1.0, 1.0], [0.0, bad]), f64::INFINITY);
        }
    }
}
