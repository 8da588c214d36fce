//! The cone K of the impulses of a contact, and the law that belongs to it.

/// A cone K of impulses, contact by contact, with its natural map.
///
/// ```text
/// K ∋ P ⟂ w + s ∈ K*        s = 0 (Signorini), s_n = μ |w_t| (Coulomb; De Saxcé's correction, as friction is not associated)
/// ```
/// # Source
/// De Saxcé, Feng, *The bipotential method* (Mathematical and Computer Modelling 28, 1998) for s.
pub trait Cone: Copy {
    /// Rows of a contact; of all contacts the normal rows come first.
    const ROWS: usize;

    /// Measures how far a contact is from solving this, m/s; NaN where its velocity is not finite.
    ///
    /// `weight` gives H_ii of a row (1/kg), so that all terms are velocities, and `velocity` w of a row (m/s).
    fn violation(
        &self,
        contact: usize,
        contacts: usize,
        weight: impl Fn(usize) -> f64,
        impulses: &[f64],
        velocity: impl Fn(usize) -> f64,
    ) -> f64;
}

/// Contacts without friction, `0 ≤ w ⟂ P ≥ 0`: they push and do not pull.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Signorini;

impl Cone for Signorini {
    const ROWS: usize = 1;

    /// Returns `|min(H_nn P_n, w_n)|`.
    #[inline(always)]
    fn violation(
        &self,
        contact: usize,
        _contacts: usize,
        weight: impl Fn(usize) -> f64,
        impulses: &[f64],
        velocity: impl Fn(usize) -> f64,
    ) -> f64 {
        normal_violation(weight(contact) * impulses[contact], velocity(contact))
    }
}

/// Contacts with Coulomb friction in the plane: `0 ≤ w_n ⟂ P_n ≥ 0`, `|P_t| ≤ μ P_n`, `w_t P_t = −μ P_n |w_t|`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coulomb<'a> {
    /// Coefficient μ of each contact, not below 0.
    pub friction: &'a [f64],
}

impl Cone for Coulomb<'_> {
    const ROWS: usize = 2;

    /// Returns `max( |min(H_nn P_n, w_n)|,  H_tt |P_t − proj_[±μ P_n](P_t − w_t / H_tt)| )`, the interval being 0 for an impulse that pulls.
    #[inline(always)]
    fn violation(
        &self,
        contact: usize,
        contacts: usize,
        weight: impl Fn(usize) -> f64,
        impulses: &[f64],
        velocity: impl Fn(usize) -> f64,
    ) -> f64 {
        let (normal, tangential) = (contact, contacts + contact);
        let (p_n, p_t) = (impulses[normal], impulses[tangential]);
        let (h_tt, w_t) = (weight(tangential), velocity(tangential));
        let bound = self.friction[contact] * larger(0.0, p_n);
        let free = p_t - w_t / h_tt;
        let projected = if free > bound { bound } else { free };
        let projected = if projected < -bound { -bound } else { projected };
        let tangential_violation = h_tt * (p_t - projected).abs();
        larger(normal_violation(weight(normal) * p_n, velocity(normal)), tangential_violation) + w_t * 0.0
    }
}

/// Returns `|min(H_nn P_n, w_n)|`, or NaN where `w_n` is not finite.
#[inline(always)]
fn normal_violation(h_p: f64, w: f64) -> f64 {
    if h_p < w { h_p } else { w }.abs() + w * 0.0
}

/// Returns the larger one, or a NaN in the first place, unlike `f64::max`.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}
