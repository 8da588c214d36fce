//! The cone K of the impulses of a contact, and the law that belongs to it.

/// A cone K of impulses, contact by contact, with its natural map.
///
/// ```text
/// K ∋ P ⟂ w + s ∈ K*        s = 0 (Signorini), s_n = μ |w_t| (Coulomb; De Saxcé's correction, as friction is not associated)
/// ```
/// # Source
/// De Saxcé, Feng, *The bipotential method: a constructive approach to design the complete contact law with friction
/// and improved numerical algorithms* (Mathematical and Computer Modelling 28, 1998) for s. With `s = 0` under friction
/// the law would be associated: a contact that slides would lift off with μ |w_t|.
pub trait Cone: Copy {
    /// Rows of a contact; of all contacts the normal rows come first, then the first tangential rows, then the second
    /// ones.
    const ROWS: usize;
    /// To which part of their size entries of contacts count that would not close.
    const FAR: f64 = 1e-3;

    /// Returns the velocity S that residuals are relative to, m/s, that is the fastest entry of the contacts that would
    /// close in this step, and `‖b‖_∞`.
    ///
    /// ```text
    /// S = max( ‖b_c‖_∞ over contacts c with b_n < 0,  FAR ‖b‖_∞ )        ‖b‖_∞ where none would close, and P = 0 is the solution
    /// ```
    /// A far gap puts `g/h` into b: 60 mm over 50 µs are 1200 m/s, of which 1e-9 are 1.2 µm/s of a contact that rests.
    /// It counts to a thousandth in the plane, for the rounding of the velocity of a contact that only others push
    /// shut, and not at all in space, whose problems have few rows. S does not exceed `‖b‖_∞`.
    #[inline(always)]
    fn scale_and_largest(b: &[f64]) -> [f64; 2] {
        let (contacts, mut closing, mut all) = (b.len() / Self::ROWS, 0.0, 0.0);
        let (normal, tangential) = b.split_at(contacts);
        for (contact, b_n) in normal.iter().enumerate() {
            let size = (0..Self::ROWS - 1)
                .fold(b_n.abs(), |size, row| larger(size, tangential[row * contacts + contact].abs()));
            closing = larger(closing, if *b_n < 0.0 { size } else { 0.0 });
            all = larger(all, size);
        }
        [if closing > 0.0 { larger(closing, Self::FAR * all) } else { all }, all]
    }

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

/// Contacts with Coulomb friction and T tangential rows each, 1 in the plane, 2 in space: `0 ≤ w_n ⟂ P_n ≥ 0`,
/// `|P_t| ≤ μ P_n`, `P_t = −μ P_n w_t / |w_t|` where it slides.
///
/// The friction disc is a Euclidean ball, which is an interval in the plane; nothing is replaced by facets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coulomb<'a, const T: usize = 1> {
    /// Coefficient μ of each contact, not below 0.
    pub friction: &'a [f64],
}

impl<const T: usize> Cone for Coulomb<'_, T> {
    const ROWS: usize = 1 + T;
    const FAR: f64 = if T == 1 { 1e-3 } else { 0.0 };

    /// Returns `max( |min(H_nn P_n, w_n)|, H_tt |P_t − proj_B(P_t − w_t / H_tt)| )`, B being the ball of radius μ P_n,
    /// or 0 for an impulse that pulls, and H_tt the largest diagonal entry of the tangential rows.
    #[inline(always)]
    fn violation(
        &self,
        contact: usize,
        contacts: usize,
        weight: impl Fn(usize) -> f64,
        impulses: &[f64],
        velocity: impl Fn(usize) -> f64,
    ) -> f64 {
        let p_n = impulses[contact];
        let bound = self.friction[contact] * larger(0.0, p_n);
        let normal = normal_violation(weight(contact) * p_n, velocity(contact));
        if T == 1 {
            let tangential = contacts + contact;
            let (p_t, h_tt, w_t) = (impulses[tangential], weight(tangential), velocity(tangential));
            let free = p_t - w_t / h_tt;
            let projected = if free > bound { bound } else { free };
            let projected = if projected < -bound { -bound } else { projected };
            return larger(normal, h_tt * (p_t - projected).abs()) + w_t * 0.0;
        }
        let row = |axis: usize| (1 + axis) * contacts + contact;
        let w_n = velocity(contact);
        if w_n >= 0.0 && p_n == 0.0 && (0..T).all(|axis| impulses[row(axis)] == 0.0) {
            // Open: zero, unless a velocity is not finite.
            return w_n * 0.0 + (0..T).map(|axis| velocity(row(axis))).map(|w| w * w).sum::<f64>() * 0.0;
        }
        let h_tt = (0..T).fold(0.0, |most, axis| larger(most, weight(row(axis))));
        let p_t: [f64; T] = std::array::from_fn(|axis| impulses[row(axis)]);
        let w_t: [f64; T] = std::array::from_fn(|axis| velocity(row(axis)));
        let free: [f64; T] = std::array::from_fn(|axis| p_t[axis] - w_t[axis] / h_tt);
        let length = norm(free);
        let shrink = if length > bound { bound / length } else { 1.0 };
        let distance = norm(std::array::from_fn::<_, T, _>(|axis| p_t[axis] - shrink * free[axis]));
        larger(normal, h_tt * distance) + norm(w_t) * 0.0
    }
}

/// Returns the Euclidean norm.
#[inline(always)]
pub(crate) fn norm<const T: usize>(vector: [f64; T]) -> f64 {
    vector.iter().map(|entry| entry * entry).sum::<f64>().sqrt()
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
