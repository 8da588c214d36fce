//! The acceleration that the interface has at a communication point: what a mechanics that sends accelerations would send.

use super::construction::ModelConstruction;
use crate::cosim::SchemeReport;
use crate::error::Failure;
use crate::interface_model::{Condensation, ReducedInterfaceModel, Redundancy, condense};
use rimbench_contact::affine_step::DiscretisedModel;
use rimbench_contact::complementarity::{Checked, Lcp};

/// The bound of rounding beside a resting contact's own free acceleration: a gap, m, or a velocity, m/s (ours).
const ROUND_OFF: f64 = 1e-9;

/// Finds the acceleration of the interface right after `t_k` from the reduced model, with the contacts that rest.
///
/// ```text
/// b = a_u + H_ui λ_k                                                    free accelerations of the contacts
/// R = { α : g_α ≤ h² |b_α|,  w_α ≤ h |b_α| }                            resting: the mechanics' own step would close it from rest
/// 0 ≤ a_R + H_RR Λ + H_Ri λ_k  ⟂  Λ ≥ 0                                 accelerations, forces: not P/h of the last step
/// a = a_i + H_ii λ_k + H_iL Λ_L,     Ĥ = H_ii − H_iL H_LL⁺ H_Li          L = { α ∈ R : Λ_α > 0 }
/// ```
/// λ_k is the fresh force. A contact that closes later is an impact and belongs to no acceleration. Which contacts rest has no
/// number to choose: *ours*.
#[derive(Clone)]
pub(super) struct InterfaceAcceleration {
    redundancy: Redundancy,
    model: ReducedInterfaceModel,
    solver: Checked,
    discretised: DiscretisedModel,
    /// L, and that of the communication point before.
    strongly_active: Vec<usize>,
    strongly_active_before: Vec<usize>,
    rest: Vec<f64>,
    free: Vec<f64>,
    forces: Vec<f64>,
    condensation: Condensation,
    /// a, m/s².
    pub(super) acceleration: Vec<f64>,
}

impl InterfaceAcceleration {
    pub(super) fn new(ModelConstruction { empty, options, .. }: ModelConstruction<'_>) -> Self {
        let (contacts, interface) = (empty.contacts(), empty.interface());
        InterfaceAcceleration {
            redundancy: options.redundancy,
            model: empty.clone(),
            solver: options.solver.checked(contacts),
            discretised: DiscretisedModel::new(contacts, interface),
            strongly_active: Vec::with_capacity(contacts),
            strongly_active_before: Vec::with_capacity(contacts),
            rest: vec![0.0; contacts + interface],
            free: vec![0.0; contacts + interface],
            forces: vec![0.0; contacts],
            condensation: Condensation::new(contacts, interface),
            acceleration: vec![0.0; interface],
        }
    }

    /// Takes the model of a communication point.
    pub(super) fn receive(&mut self, model: &ReducedInterfaceModel) {
        self.model.copy_from(model);
    }

    /// Finds the acceleration under the fresh force `lambda` (N).
    ///
    /// # Errors
    /// As the contact solver reports.
    pub(super) fn find(&mut self, lambda: &[f64]) -> Result<(), Failure> {
        std::mem::swap(&mut self.strongly_active, &mut self.strongly_active_before);
        self.choose_resting(lambda);
        let n = self.strongly_active.len();
        if n > 0 {
            // A step of one second from rest: velocities are accelerations, impulses forces.
            self.discretised.discretise(self.model.linear(), &self.strongly_active, 1.0);
            let rows = n + lambda.len();
            self.discretised.free_velocity(&self.rest[..rows], lambda, &mut self.free[..rows]);
            self.solver.solve(Lcp::new(self.discretised.h_uu(), &self.free[..n]), &mut self.forces[..n])?;
            let mut carries = self.forces.iter().map(|force| *force > 0.0);
            self.strongly_active.retain(|_| carries.next().unwrap_or(false));
        }
        condense(&self.model, &self.strongly_active, self.redundancy, &mut self.condensation);
        let rows = self.acceleration.len();
        for (i, a) in self.acceleration.iter_mut().enumerate() {
            let pushed: f64 =
                lambda.iter().enumerate().map(|(j, force)| self.condensation.h[i * rows + j] * force).sum();
            *a = self.condensation.a[i] + pushed;
        }
        Ok(())
    }

    fn choose_resting(&mut self, lambda: &[f64]) {
        let (model, h) = (&self.model, self.model.mechanics_step);
        let contacts = model.contacts();
        self.strongly_active.clear();
        for contact in 0..contacts {
            let pushed: f64 =
                lambda.iter().enumerate().map(|(j, force)| model.entry(contact, contacts + j) * force).sum();
            let reach = h * (model.a[contact] + pushed).abs();
            if model.gap[contact] <= h * reach + ROUND_OFF && model.w[contact] <= reach + ROUND_OFF {
                self.strongly_active.push(contact);
            }
        }
    }

    /// Returns Ĥ, row-major, 1/kg.
    pub(super) fn mobility(&self) -> &[f64] {
        &self.condensation.h
    }

    /// Returns H_ii of the model without its contacts, row-major, 1/kg.
    pub(super) fn free_mobility(&self, row: usize, column: usize) -> f64 {
        self.model.entry(self.model.contacts() + row, self.model.contacts() + column)
    }

    /// Tells whether other contacts carry force than at the communication point before: what was remembered of before is of no use then.
    pub(super) fn contacts_changed(&self) -> bool {
        self.strongly_active != self.strongly_active_before
    }

    /// Returns what a scheme that is made from it reports; the effective mass (kg) is `+inf` where the interface is locked.
    pub(super) fn report(&self) -> SchemeReport {
        SchemeReport {
            effective_mass: Some(self.condensation.effective_mass),
            counters: self.solver.counters(),
            ..SchemeReport::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schemes::ModelOptions;

    /// A mass of 2 kg over a floor: the contact row and the interface row have one direction. Weight 20 N.
    fn falling(gap: f64, w: f64) -> ReducedInterfaceModel {
        let mut model = ReducedInterfaceModel::zeros(1, 1);
        model.h.fill(0.5);
        model.a.fill(-10.0);
        model.w.fill(w);
        model.gap[0] = gap;
        model.mechanics_step = 1e-3;
        model
    }

    fn acceleration(model: &ReducedInterfaceModel, force: f64) -> (f64, f64) {
        let empty = ReducedInterfaceModel::zeros(1, 1);
        let options = ModelOptions::default();
        let mut found =
            InterfaceAcceleration::new(ModelConstruction { empty: &empty, options: &options, detection: None });
        found.receive(model);
        found.find(&[force]).unwrap();
        (found.acceleration[0], found.report().effective_mass.unwrap())
    }

    #[test]
    fn a_contact_that_rests_carries_the_weight_and_one_that_is_lifted_does_not() {
        assert_eq!(acceleration(&falling(0.0, 0.0), 0.0), (0.0, f64::INFINITY));
        assert_eq!(acceleration(&falling(0.0, 0.0), 30.0), (5.0, 2.0));
        assert_eq!(acceleration(&falling(0.1, 0.0), 0.0), (-10.0, 2.0));
    }

    /// The velocity jumped from −3 m/s to 0 in the last step of 1 ms: the acceleration is 0, not 3000 m/s².
    #[test]
    fn after_a_plastic_impact_it_is_that_of_the_contact_and_not_the_jump_over_the_step() {
        assert_eq!(acceleration(&falling(1e-8, 0.0), 0.0).0, 0.0);
    }

    #[test]
    fn a_contact_that_separates_or_is_still_far_is_no_rest() {
        assert_eq!(acceleration(&falling(0.0, 1.0), 0.0).0, -10.0);
        assert_eq!(acceleration(&falling(1e-3, -1.0), 0.0).0, -10.0);
    }

    #[test]
    fn a_change_of_the_contacts_that_carry_is_told() {
        let empty = ReducedInterfaceModel::zeros(1, 1);
        let options = ModelOptions::default();
        let mut found =
            InterfaceAcceleration::new(ModelConstruction { empty: &empty, options: &options, detection: None });
        for (force, changed) in [(0.0, true), (0.0, false), (30.0, true), (30.0, false)] {
            found.receive(&falling(0.0, 0.0));
            found.find(&[force]).unwrap();
            assert_eq!(found.contacts_changed(), changed, "{force} N");
        }
    }
}
