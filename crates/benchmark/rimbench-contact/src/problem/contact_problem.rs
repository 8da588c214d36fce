//! One contact problem, and the natural residual of an answer.

use super::Unsolved;
use super::{Cone, Coulomb, DelassusOperator, DenseDelassus, Signorini, delassus};
use crate::linear_algebra::SymmetricRows;

/// One problem `w = H P + b`, `K ∋ P ⟂ w + s ∈ K*`, see [`Cone`].
#[derive(Debug, Clone, Copy)]
pub struct ContactProblem<'a, H, K> {
    /// H over all rows, 1/kg.
    pub delassus: H,
    /// Velocities without contact impulses, plus the terms of the contact law, one per row, m/s.
    pub b: &'a [f64],
    /// K.
    pub cone: K,
}

impl<H: DelassusOperator, K: Cone> ContactProblem<'_, H, K> {
    /// Returns the number of contacts.
    #[inline(always)]
    pub fn contacts(&self) -> usize {
        self.b.len() / K::ROWS
    }

    /// Returns the velocity S that residuals are relative to, m/s: that of the contacts that would close
    /// ([`Cone::scale_and_largest`]).
    #[inline(always)]
    pub fn scale(&self) -> f64 {
        K::scale_and_largest(self.b)[0]
    }

    /// Tells whether `P = 0` is a solution, that is `b_n ≥ 0`. Looks at `b` only.
    ///
    /// # Errors
    /// [`Unsolved::NonFinite`] if `b` is not finite.
    #[inline]
    pub fn is_solved_by_zero(&self) -> Result<bool, Unsolved> {
        let finite = self.b.iter().fold(true, |finite, b| finite & b.is_finite());
        if finite { Ok(self.b[..self.contacts()].iter().all(|b_n| *b_n >= 0.0)) } else { Err(Unsolved::NonFinite) }
    }

    /// Returns the [natural residual](ContactProblem::natural_residual) where the velocities `H P + b` are at hand.
    #[inline(always)]
    pub fn residual_of(&self, impulses: &[f64], velocity: impl Fn(usize) -> f64) -> f64 {
        let violation = self.violation(impulses, velocity);
        // The scale may be infinite, too.
        if violation.is_finite() { violation / self.scale().max(f64::MIN_POSITIVE) } else { f64::INFINITY }
    }

    /// Returns the natural residual in which the violation of a contact counts beside what its own velocity is summed
    /// from, for what was not accepted up to `tolerance` by the [scale](Self::scale) of all.
    ///
    /// ```text
    /// r = max_c violation_c / max(S, κ Σ_j |H_cj P_j|)        κ = max(n, 16) ε / tolerance        n rows, ε of f64
    /// ```
    /// Between bodies of which one is 1e6 times as heavy as its neighbours `H P` cancels to a millionth of its terms or
    /// less, and is known to `n ε` of these: no impulses of f64 come closer, and solvers pivot for nothing below 16 ε.
    /// # Source
    /// Higham, *Accuracy and Stability of Numerical Algorithms* (2002), sections 3.1 and 10.1: sums, and solutions by
    /// Cholesky's factor, have a backward error of n ε. Its use as a scale is ours.
    #[cold]
    pub fn residual_on_own_scales(&self, impulses: &[f64], tolerance: f64) -> f64 {
        // Below ε a tolerance asks for more than f64 has, and nothing meets it.
        let rounding = self.b.len().max(16) as f64 * f64::EPSILON / tolerance.max(f64::EPSILON);
        let (contacts, scale) = (self.contacts(), self.scale().max(f64::MIN_POSITIVE));
        let violation = |contact: usize| {
            let weight = |row: usize| Some(self.delassus.diagonal(row)).filter(|h| *h > 0.0).unwrap_or(1.0);
            let velocity = |row: usize| self.delassus.product(row, impulses)[0] + self.b[row];
            let summed = (0..K::ROWS).map(|axis| self.delassus.product(axis * contacts + contact, impulses)[1]);
            let own = summed.fold(scale, |most, sum| most.max(rounding * sum));
            let violation = self.cone.violation(contact, contacts, weight, impulses, velocity);
            if violation.is_finite() && own.is_finite() { violation / own } else { f64::INFINITY }
        };
        (0..contacts).map(violation).fold(0.0, f64::max)
    }

    /// Returns r times [`scale`](Self::scale), m/s; infinite where something is not finite.
    #[inline(always)]
    pub(crate) fn violation(&self, impulses: &[f64], velocity: impl Fn(usize) -> f64) -> f64 {
        let weight = |row: usize| {
            let h = self.delassus.diagonal(row);
            if h > 0.0 { h } else { 1.0 }
        };
        // Stays zero as long as every w is finite; a NaN anywhere in H, b or P reaches w.
        let (mut worst, mut not_finite) = (0.0, 0.0);
        for contact in 0..self.contacts() {
            let violation = self.cone.violation(contact, self.contacts(), weight, impulses, &velocity);
            not_finite += violation * 0.0;
            worst = if violation > worst { violation } else { worst };
        }
        if not_finite == 0.0 { worst } else { f64::INFINITY }
    }
}

impl<'a, K: Cone> ContactProblem<'a, DenseDelassus<'a>, K> {
    /// Measures how far `P` is from solving the problem, in velocities relative to those of the contacts that would
    /// close.
    ///
    /// ```text
    /// w = H P + b        r = max_c |natural map of contact c| / max(S, tiny)        S: Cone::scale_and_largest
    /// ```
    /// `r = 0` if and only if `P` solves the problem exactly. The natural map of [`Signorini`] is `min(H_nn P_n, w_n)`;
    /// [`Coulomb`] adds the distance of `P_t` from its projection. `H_nn P_n` is the velocity the impulse alone would
    /// cause, so every term is one: a change of the unit of mass (`H → H/s`, `P → s P`) or of velocity leaves `r`
    /// unchanged, and a negative impulse, a penetrating velocity, an impulse at an opening contact and friction along
    /// the motion count alike. A row with `H_ii ≤ 0` (in a semidefinite matrix a row of zeros) is measured with the
    /// impulse itself.
    ///
    /// `w` is recomputed from `H`, `b` and `P`; nothing is taken from the solver. Anything that is not finite makes the
    /// result infinite.
    ///
    /// # Shapes and units
    /// `impulses` n (N·s); returns a pure number.
    /// # Panics
    /// If the lengths do not fit.
    /// # Source
    /// Cottle, Pang, Stone, *The Linear Complementarity Problem* (1992), section 5.10 (`min(z, w)`); the weight `H_ii`
    /// is ours.
    #[inline(always)]
    pub fn natural_residual(&self, impulses: &[f64]) -> f64 {
        assert!(impulses.len() == self.b.len() && self.b.len() == self.delassus.rows, "one impulse per row of H and b");
        delassus::natural_residual(self.delassus.h, self.b, self.cone, impulses)
    }

    /// Returns the number of rows n.
    ///
    /// # Panics
    /// If `H` is not `n×n`.
    #[inline]
    pub fn size(&self) -> usize {
        let n = self.b.len();
        assert_eq!(self.delassus.h.len(), n * n, "H is n×n and b has length n");
        n
    }

    /// Returns the entries of H, row by row, 1/kg.
    #[inline(always)]
    pub const fn h(&self) -> &'a [f64] {
        self.delassus.h
    }

    /// Checks that every entry of `H` is finite.
    ///
    /// # Errors
    /// [`Unsolved::NonFinite`].
    pub fn require_finite_matrix(&self) -> Result<(), Unsolved> {
        if self.delassus.h.iter().all(|h| h.is_finite()) { Ok(()) } else { Err(Unsolved::NonFinite) }
    }
}

impl<'a> ContactProblem<'a, DenseDelassus<'a>, Signorini> {
    /// Poses a problem whose impulses are non-negative.
    #[inline(always)]
    pub const fn new(h: &'a [f64], b: &'a [f64]) -> Self {
        ContactProblem { delassus: DenseDelassus { h, rows: b.len() }, b, cone: Signorini }
    }
}

impl<'a> ContactProblem<'a, SymmetricRows<'a>, Signorini> {
    /// Poses a problem whose matrix has a fixed pattern.
    #[inline(always)]
    pub const fn by_pattern(h: SymmetricRows<'a>, b: &'a [f64]) -> Self {
        ContactProblem { delassus: h, b, cone: Signorini }
    }
}

impl<'a, const T: usize> ContactProblem<'a, DenseDelassus<'a>, Coulomb<'a, T>> {
    /// Poses a problem with friction: `h` is `[H_nn H_nt; H_tn H_tt]`, (1+T)n × (1+T)n, `b` is `[b_n; b_t]`, and
    /// `friction` the coefficient μ of each contact. With two tangential rows `b_t = [b_t1; b_t2]`.
    ///
    /// # Panics
    /// If the lengths do not fit.
    #[inline(always)]
    pub fn with_friction(h: &'a [f64], b: &'a [f64], friction: &'a [f64]) -> Self {
        let rows = b.len();
        assert_eq!(
            (rows, h.len()),
            ((1 + T) * friction.len(), rows * rows),
            "b has 1+T rows per contact, H is as large"
        );
        ContactProblem { delassus: DenseDelassus { h, rows }, b, cone: Coulomb { friction } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::FrictionProblem;

    const H: [f64; 4] = [2.0, 1.0, 1.0, 2.0];
    /// A point of 0.5 kg, in the plane.
    const POINT: [f64; 4] = [2.0, 0.0, 0.0, 2.0];

    fn residual(b: [f64; 2], p: [f64; 2]) -> f64 {
        ContactProblem::new(&H, &b).natural_residual(&p)
    }

    fn with_friction(b: [f64; 2], p: [f64; 2]) -> f64 {
        FrictionProblem::<1>::with_friction(&POINT, &b, &[0.5]).natural_residual(&p)
    }

    #[test]
    fn a_solution_has_residual_zero_and_each_kind_of_violation_counts_in_velocities() {
        for (b, p, wanted, what) in [
            ([-5.0, -6.0], [4.0 / 3.0, 7.0 / 3.0], 0.0, "both closed"),
            ([3.0, 0.0], [0.0, 0.0], 0.0, "both open"),
            ([-4.0, 1.0], [0.0, 0.0], 1.0, "penetrating velocity"),
            ([4.0, 8.0], [-1.0, 0.0], 2.0 / 8.0, "pulling impulse"),
            ([4.0, 8.0], [0.5, 0.0], 1.0 / 8.0, "impulse at an opening contact"),
        ] {
            assert_eq!(residual(b, p), wanted, "{what}");
        }
        for (b, p, wanted, what) in [
            ([1.0, 8.0], [0.0, 0.0], 0.0, "open"),
            ([-4.0, 1.0], [2.0, -0.5], 0.0, "stick"),
            ([-4.0, 8.0], [2.0, -1.0], 0.0, "slip forwards"),
            ([-4.0, -8.0], [2.0, 1.0], 0.0, "slip backwards"),
            ([-4.0, 0.0], [0.0, 0.0], 1.0, "penetrating velocity"),
            ([4.0, 0.0], [-1.0, 0.0], 2.0 / 4.0, "pulling impulse"),
            ([-4.0, 1.0], [2.0, 0.0], 1.0 / 4.0, "slides without friction although it would stick"),
            ([-4.0, 8.0], [2.0, -2.0], 2.0 / 8.0, "friction beyond its cone"),
            ([-4.0, 8.0], [2.0, 1.0], 4.0 / 8.0, "friction along the motion"),
            ([4.0, 8.0], [0.0, -1.0], 2.0 / 8.0, "friction at an open contact"),
        ] {
            assert_eq!(with_friction(b, p), wanted, "with friction: {what}");
        }
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let h = [2.0, bad, bad, 2.0];
            assert_eq!(ContactProblem::new(&h, &[1.0, 1.0]).natural_residual(&[0.0, 0.0]), f64::INFINITY);
            for (b, p) in
                [([bad, 1.0], [0.0; 2]), ([1.0, bad], [0.0; 2]), ([1.0; 2], [bad, 0.0]), ([1.0; 2], [0.0, bad])]
            {
                assert_eq!((residual(b, p), with_friction(b, p)), (f64::INFINITY, f64::INFINITY));
            }
        }
        // A row of zeros is measured with its impulse, and nothing with nothing.
        let zero = ContactProblem::new(&[0.0], &[1.0]);
        assert_eq!((zero.natural_residual(&[0.0]), zero.natural_residual(&[-0.5])), (0.0, 0.5));
        assert_eq!(ContactProblem::new(&[], &[]).natural_residual(&[]), 0.0);
        assert_eq!(FrictionProblem::<1>::with_friction(&[], &[], &[]).natural_residual(&[]), 0.0);
        // The unit of mass does not matter.
        let (b, p, heavy) = ([-5.0, 1.0], [2.0, 0.5], H.map(|h| h / 1024.0));
        assert_eq!(ContactProblem::new(&heavy, &b).natural_residual(&p.map(|p| p * 1024.0)), residual(b, p));
    }

    #[test]
    fn a_far_gap_counts_to_a_thousandth_where_contacts_close() {
        // A weight that rests, another beside it, and a gap of 60 mm over 50 µs.
        let (h, far) = ([2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 2.0], 60e-3 / 50e-6);
        let b = [-0.01, 1.0, far];
        assert_eq!(ContactProblem::new(&h, &b).natural_residual(&[0.005, 0.0, 0.0]), 0.0);
        // It sinks by 1e-6 m/s, which is 8e-10 of the far one, and was accepted.
        let sinks = ContactProblem::new(&h, &b).natural_residual(&[0.005 - 5e-7, 0.0, 0.0]);
        approx::assert_relative_eq!(sinks, 1e-6 / 1.2, max_relative = 1e-9);
        let diagonal: [f64; 16] = std::array::from_fn(|at| if at % 5 == 0 { 2.0 } else { 0.0 });
        let b = [-0.01, far, 0.0, 0.0];
        let rubs = FrictionProblem::<1>::with_friction(&diagonal, &b, &[0.5; 2]);
        approx::assert_relative_eq!(rubs.natural_residual(&[0.005 - 5e-7, 0.0, 0.0, 0.0]), sinks, max_relative = 1e-9);
    }

    #[test]
    fn in_space_the_ball_and_the_scale_of_contacts_that_could_close_count() {
        // A point of 0.5 kg, and one far away, whose gap term must not set the scale.
        let h: [f64; 36] = std::array::from_fn(|k| if k / 6 == k % 6 { 2.0 } else { 0.0 });
        let residual = |b: [f64; 3], p: [f64; 3]| {
            let with_far = |of: [f64; 3], far: f64| [of[0], far, of[1], 0.0, of[2], 0.0];
            let b = with_far(b, 1e6);
            // The root leaves an ulp.
            (1e9 * FrictionProblem::<2>::with_friction(&h, &b, &[0.5; 2]).natural_residual(&with_far(p, 0.0))).round()
                / 1e9
        };
        assert_eq!(residual([-4.0, 3.0, 4.0], [2.0, -0.6, -0.8]), 0.0, "slides against its velocity");
        assert_eq!(residual([-4.0, 0.6, 0.8], [2.0, -0.3, -0.4]), 0.0, "sticks");
        assert_eq!(residual([-4.0, 3.0, 4.0], [2.0, 0.0, 0.0]), 2.0 / 4.0, "slides without friction");
        assert_eq!(residual([-4.0, 3.0, 4.0], [2.0, -1.2, -1.6]), 2.0 / 4.0, "friction beyond its ball");
        assert_eq!(residual([-4.0, f64::NAN, 4.0], [2.0, 0.0, 0.0]), f64::INFINITY);
    }
}
