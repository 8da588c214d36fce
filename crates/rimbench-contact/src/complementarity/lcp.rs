//! One contact problem.

use super::unsolved::Unsolved;

/// The set that the impulses of a contact problem live in. A problem names it, so that a solver of another kind of contact
/// (a friction cone, say) can be told apart from one of these.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ImpulseSet {
    /// `z ≥ 0`, entry by entry: contacts that push and do not pull.
    #[default]
    NonNegative,
}

/// One problem `w = M z + q`, `0 ≤ w ⟂ z`, `z` in its set and `w` in the dual one.
#[derive(Debug, Clone, Copy)]
pub struct Lcp<'a> {
    /// `n×n`, row-major, symmetric positive semidefinite.
    pub m: &'a [f64],
    /// Length `n`.
    pub q: &'a [f64],
    /// Where the impulses live.
    pub set: ImpulseSet,
}

impl<'a> Lcp<'a> {
    /// Poses a problem whose impulses are non-negative.
    #[inline(always)]
    pub const fn new(m: &'a [f64], q: &'a [f64]) -> Self {
        Lcp { m, q, set: ImpulseSet::NonNegative }
    }

    /// Returns `n`.
    ///
    /// # Panics
    /// If `M` is not `n×n`.
    #[inline]
    pub fn size(&self) -> usize {
        let n = self.q.len();
        assert_eq!(self.m.len(), n * n, "M is n×n and q has length n");
        n
    }

    /// Tells whether `z = 0` is a solution, that is `q ≥ 0`. Looks at `q` only.
    ///
    /// # Errors
    /// [`Unsolved::NonFinite`] if `q` is not finite.
    #[inline]
    pub fn is_solved_by_zero(&self) -> Result<bool, Unsolved> {
        let (mut finite, mut nonnegative) = (true, true);
        for q in self.q {
            finite &= q.is_finite();
            nonnegative &= *q >= 0.0;
        }
        if finite { Ok(nonnegative) } else { Err(Unsolved::NonFinite) }
    }

    /// Checks every entry of `M`.
    ///
    /// # Errors
    /// [`Unsolved::NonFinite`].
    pub fn require_finite_matrix(&self) -> Result<(), Unsolved> {
        if self.m.iter().all(|m| m.is_finite()) { Ok(()) } else { Err(Unsolved::NonFinite) }
    }
}
