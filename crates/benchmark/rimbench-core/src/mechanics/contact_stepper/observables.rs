//! Observables that every model with contacts has.

use super::ContactStepper;
use crate::interface_model::{condense_in_modes, rank_of_normal_rows};

/// Observables that every model with contacts has.
///
/// Closed contacts c are those whose row was at its bound in the last step, whatever a scheme counts as closed.
/// `rank_h_uu` is the rank of the normal rows of `H_cc`, less than the number of contacts where these are redundant,
/// and `effective_mass_kg` is `(H_ii − H_ic H_cc⁺ H_ci)⁻¹`, as in the source paper's Fig. 2; `active_effective_mass_kg`
/// takes the contacts that carried impulse for c. The sum of contact forces includes contacts without a column of their
/// own.
pub(in crate::mechanics) const CONTACT_OBSERVABLES: [&str; 5] =
    ["closed_contacts", "rank_h_uu", "effective_mass_kg", "active_effective_mass_kg", "contact_force_sum_n"];

impl ContactStepper {
    /// Returns the contact impulses of the last step, N·s, those of friction after the others.
    pub(in crate::mechanics) fn all_contact_impulses(&self) -> &[f64] {
        &self.impulses[..self.eq4.interface_start()]
    }

    /// Writes gaps, contact forces `λ_u = P_u/h` of the last step, and to `contact` the [`CONTACT_OBSERVABLES`]; `h` is
    /// the next step.
    pub(in crate::mechanics) fn observe(&mut self, h: f64, gaps: &mut [f64], forces: &mut [f64], contact: &mut [f64]) {
        let n_u = self.eq3.unilateral.len();
        gaps.copy_from_slice(&self.eq3.unilateral.position[..gaps.len()]);
        for (force, impulse) in forces.iter_mut().zip(&self.impulses[..n_u]) {
            *force = impulse / self.last_step;
        }
        contact.fill(f64::NAN);
        contact[4] = self.impulses[..n_u].iter().sum::<f64>() / self.last_step;
        if self.reduce_for_model(h).is_err() {
            return;
        }
        self.find_closed();
        self.eq4.closed_contacts(&mut self.closed);
        self.condense_closed();
        contact[0] = self.closed.len() as f64;
        contact[1] = match self.contacts.coulomb() {
            Some(_) => rank_of_normal_rows(&self.eq4, &self.closed, &mut self.normal_rows) as f64,
            None => self.condensation.rank as f64,
        };
        contact[2] = self.condensation.effective_mass;
        contact[3] = contact[2];
        if self.last_step.is_finite() {
            let active = (0..n_u).filter(|&contact| self.impulses[contact] > 0.0);
            // Mostly these are the closed contacts.
            if !active.clone().eq(self.closed.iter().copied()) {
                self.closed.clear();
                self.closed.extend(active);
                self.condense_closed();
                contact[3] = self.condensation.effective_mass;
            }
        }
    }

    fn condense_closed(&mut self) {
        let modes = self.contacts.coulomb().map_or_else(|| self.eq4.modes(), |contacts| contacts.modes());
        condense_in_modes(&self.eq4, modes, &self.closed, &mut self.condensation);
    }
}
