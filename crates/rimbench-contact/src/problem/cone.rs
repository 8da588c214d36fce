//! The set K that the impulses of a contact live in.

/// A cone K of impulses, contact by contact, with its natural map.
pub trait Cone: Copy {
    /// Rows of a contact; of all contacts the normal rows come first.
    const ROWS: usize;

    /// Measures how far a contact is from `K ∋ P ⟂ w ∈ K*`, m/s; NaN where its velocity is not finite.
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

/// Contacts that push and do not pull: `P ≥ 0`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Signorini;

impl Cone for Signorini {
    const ROWS: usize = 1;

    /// `|min(H_nn P_n, w_n)|`.
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

/// Contacts with Coulomb friction in the plane: `|P_t| ≤ μ P_n`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coulomb<'a> {
    /// Coefficient μ of each contact, not below 0.
    pub friction: &'a [f64],
}

impl Cone for Coulomb<'_> {
    const ROWS: usize = 2;

    /// `max( |min(H_nn P_n, w_n)|,  H_tt |P_t − proj_[±μ P_n](P_t − w_t / H_tt)| )`, the interval being 0 for an impulse that pulls.
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
        let wanted = p_t - w_t / h_tt;
        let wanted = if wanted > bound { bound } else { wanted };
        let projected = if wanted < -bound { -bound } else { wanted };
        let in_plane = h_tt * (p_t - projected).abs();
        larger(normal_violation(weight(normal) * p_n, velocity(normal)), in_plane) + w_t * 0.0
    }
}

#[inline(always)]
fn normal_violation(effect: f64, w: f64) -> f64 {
    if effect < w { effect } else { w }.abs() + w * 0.0
}

/// Keeps a NaN in the first place, unlike `f64::max`.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}
