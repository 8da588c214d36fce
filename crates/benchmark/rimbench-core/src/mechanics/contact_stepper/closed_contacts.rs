//! The contacts that were closed at the end of the last step.

use super::ContactStepper;
use super::step_contacts::StepContacts;
use crate::interface_model::TOUCHING;

impl ContactStepper {
    /// Finds the contacts whose row was at its bound in the last step, loaded or not.
    ///
    /// ```text
    /// w_α⁺ + t_α = H_α· P + b_α ≤ τ ‖b‖_∞        τ the tolerance of the solver
    /// ```
    /// `w⁺` is unique where impulses are not, so that it does not matter which of several redundant contacts the solver
    /// loads. A contact that rebounded is open. Before the first step: gaps up to [`TOUCHING`].
    pub(super) fn find_closed(&mut self) {
        if std::mem::replace(&mut self.closed_known, true) {
            return;
        }
        let at_bound = &mut self.eq4.at_bound;
        let started = self.last_step.is_finite();
        if started {
            let (w, rounding) = self.contacts.velocities_after(&self.impulses);
            for (closed, w) in at_bound.iter_mut().zip(w) {
                *closed = *w <= rounding;
            }
            if self.rebounding.any() {
                for (contact, closed) in at_bound.iter_mut().enumerate() {
                    *closed &= !self.rebounding.rebounds(contact);
                }
            }
        } else {
            for (closed, gap) in at_bound.iter_mut().zip(&self.eq3.unilateral.position) {
                *closed = *gap <= TOUCHING;
            }
        }
        if let StepContacts::Coulomb(contacts) = &mut self.contacts {
            contacts.find_modes(&self.eq4, started);
        }
    }

    /// Sets the contacts that were at their bound in the last step, where the step itself has found them.
    pub(in crate::mechanics) fn set_closed(&mut self, closed: &[bool]) {
        self.eq4.at_bound.copy_from_slice(closed);
        self.closed_known = true;
    }
}
