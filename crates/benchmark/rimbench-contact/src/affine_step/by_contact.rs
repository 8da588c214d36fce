//! What an affine step asks of contacts without friction, of all of them in order: two numbers at once, and none looked
//! for by its place.

use super::two_rows::{by_two, put_two, two, with_two};
use super::{ActiveSetFactor, AffineStep, StepContactLaw};
use wide::f64x2;

/// The active set and the tangents of the impulses by contact.
#[derive(Clone)]
pub(super) struct ByContact {
    contacts: usize,
    /// 1 for active contacts, 0 for others.
    pub(super) active: Vec<f64>,
    /// Columns, zero for inactive contacts.
    pub(super) impulses: Vec<f64>,
}

impl ByContact {
    /// Reserves `contacts` contacts and `interface` interface rows.
    pub(super) fn new(contacts: usize, interface: usize) -> Self {
        ByContact { contacts, active: vec![0.0; contacts], impulses: vec![0.0; contacts * (interface + 2)] }
    }

    /// Starts another active set, of so many contacts.
    pub(super) fn clear(&mut self, contacts: usize) {
        self.contacts = contacts;
        self.active[..contacts].fill(0.0);
    }

    /// Puts a contact into the active set.
    pub(super) fn activate(&mut self, contact: usize) {
        self.active[contact] = 1.0;
    }

    /// Records the active contacts' impulses of one tangent.
    pub(super) fn record_tangent(&mut self, at: usize, active: &[usize], impulses: &[f64]) {
        let n = self.contacts;
        let column = &mut self.impulses[at * n..(at + 1) * n];
        column.fill(0.0);
        active.iter().zip(impulses).for_each(|(&contact, impulse)| column[contact] = *impulse);
    }

    /// Tells whether active contacts rest at their gap terms, and no other one moves further in than its own allows.
    #[inline(always)]
    pub(super) fn is_in_region<F: ActiveSetFactor>(
        &self,
        step: &AffineStep<F>,
        law: &StepContactLaw,
        w_plus: &[f64],
        gap: &[f64],
        tolerance: f64,
    ) -> bool {
        let n = gap.len();
        let (w_plus, active) = (&w_plus[..n], &self.active[..n]);
        let [open, closed, accepted] = [law.rates.open, law.rates.closed, -step.accepted(tolerance)].map(f64x2::splat);
        let mut wrong = f64x2::ZERO;
        by_two!(n, contacts => {
            let gap = two(gap, contacts);
            let slack = two(w_plus, contacts) + gap * gap.simd_gt(f64x2::ZERO).select(open, closed);
            let moves = (two(active, contacts) * slack).abs().simd_gt(f64x2::splat(tolerance));
            wrong = wrong | slack.simd_lt(accepted) | moves;
        });
        wrong.to_bitmask() == 0
    }

    /// Writes the impulses; tells whether all are admissible.
    #[inline(always)]
    pub(super) fn write_impulses(&self, sigma: f64, lambda: &[f64], impulses: &mut [f64]) -> bool {
        let n = impulses.len();
        let (free, columns) = self.impulses[..n * (lambda.len() + 2)].split_at(n);
        let (of_r, forces) = columns.split_at(n);
        let mut wrong = f64x2::ZERO;
        by_two!(n, contacts => {
            let start = two(free, contacts) + f64x2::splat(sigma) * two(of_r, contacts);
            let both = with_two(start, lambda, forces, n, contacts);
            wrong |= both.simd_lt(f64x2::ZERO);
            put_two(impulses, contacts, both);
        });
        wrong.to_bitmask() == 0
    }
}
