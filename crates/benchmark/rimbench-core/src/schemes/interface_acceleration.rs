//! The acceleration that the interface has at a communication point: what a mechanics that sends accelerations would
//! send.

use super::active_contacts::ActiveContacts;
use super::construction::ModelConstruction;
use super::recorded_modes::RecordedModes;
use crate::cosim::SchemeReport;
use crate::error::Failure;
use crate::interface_model::{Condensation, ReducedInterfaceModel, condense, condense_in_modes};
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
/// λ_k is the fresh force. A contact that closes later is an impact and belongs to no acceleration. Which contacts rest
/// has no number to choose: *ours*.
///
/// With friction the contacts of R have tangential rows as well, and a contact that moves may stop. Its force is the
/// one over the mechanics' next step h under λ_k, the impact of a contact that has just landed left out, and `Ĥ` has
/// contacts stick and slide as they do in it:
///
/// ```text
/// w_n = 0 in R        w⁺ = w + h (a + H_·i λ_k) + H_·R P,  Coulomb's law        a = (w_i⁺ − w_i)/h
/// ```
/// Contacts that give way are all in it, by the law of that step, since their forces follow from gaps.
#[derive(Clone)]
pub(super) struct InterfaceAcceleration {
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
    friction: Option<Box<WithFriction>>,
    /// a, m/s².
    pub(super) acceleration: Vec<f64>,
}

/// Contacts that stick and slide.
#[derive(Clone)]
struct WithFriction {
    contacts: ActiveContacts,
    modes: RecordedModes,
    modes_before: RecordedModes,
}

impl InterfaceAcceleration {
    pub(super) fn new(ModelConstruction { empty, options, .. }: ModelConstruction<'_>) -> Self {
        let (contacts, interface) = (empty.contacts(), empty.interface());
        let friction = empty.has_friction().then(|| {
            let modes = RecordedModes::of(empty);
            let contacts = ActiveContacts::of(empty, &options.solver);
            Box::new(WithFriction { contacts, modes_before: modes.clone(), modes })
        });
        InterfaceAcceleration {
            model: empty.clone(),
            solver: options.solver.checked(if friction.is_some() { 0 } else { contacts }),
            discretised: DiscretisedModel::new(contacts, interface),
            strongly_active: Vec::with_capacity(contacts),
            strongly_active_before: Vec::with_capacity(contacts),
            rest: vec![0.0; contacts + interface],
            free: vec![0.0; contacts + interface],
            forces: vec![0.0; contacts],
            condensation: match friction {
                Some(_) => Condensation::of(empty),
                None => Condensation::new(contacts, interface),
            },
            friction,
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
        if self.friction.is_some() {
            return self.find_with_friction(lambda);
        }
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
        condense(&self.model, &self.strongly_active, &mut self.condensation);
        let rows = self.acceleration.len();
        for (i, a) in self.acceleration.iter_mut().enumerate() {
            let pushed: f64 =
                lambda.iter().enumerate().map(|(j, force)| self.condensation.h[i * rows + j] * force).sum();
            *a = self.condensation.a[i] + pushed;
        }
        Ok(())
    }

    fn find_with_friction(&mut self, lambda: &[f64]) -> Result<(), Failure> {
        let InterfaceAcceleration { model, strongly_active, condensation, friction: Some(friction), .. } = self else {
            return Ok(());
        };
        let WithFriction { contacts, modes, modes_before } = &mut **friction;
        let gives_way = model.spring.is_some();
        if gives_way {
            strongly_active.clear();
            strongly_active.extend(0..model.contacts());
        } else {
            strongly_active.iter().for_each(|&contact| model.w[contact] = 0.0);
        }
        std::mem::swap(modes, modes_before);
        modes.start_from(model);
        contacts.keep(strongly_active, model, lambda, gives_way, modes)?;
        condense_in_modes(model, modes.get(), strongly_active, condensation);
        let before = &model.w[model.interface_start()..];
        for ((a, after), before) in self.acceleration.iter_mut().zip(contacts.interface_velocity()).zip(before) {
            *a = (after - before) / model.mechanics_step;
        }
        Ok(())
    }

    fn choose_resting(&mut self, lambda: &[f64]) {
        let (model, h) = (&self.model, self.model.mechanics_step);
        let interface = model.interface_start();
        self.strongly_active.clear();
        for contact in 0..model.contacts() {
            let pushed: f64 =
                lambda.iter().enumerate().map(|(j, force)| model.entry(contact, interface + j) * force).sum();
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
        let interface = self.model.interface_start();
        self.model.entry(interface + row, interface + column)
    }

    /// Tells whether H_ii may be another one at each sample.
    pub(super) fn inertia_varies(&self) -> bool {
        self.model.inertia_varies
    }

    /// Tells whether other contacts carry force than at the communication point before: what was remembered of before
    /// is of no use then.
    pub(super) fn contacts_changed(&self) -> bool {
        self.strongly_active != self.strongly_active_before
            || self.friction.as_ref().is_some_and(|friction| {
                let states = |modes: &RecordedModes, contact: usize| modes.get().states[contact];
                self.strongly_active
                    .iter()
                    .any(|&contact| states(&friction.modes, contact) != states(&friction.modes_before, contact))
            })
    }

    /// Returns what a scheme that is made from it reports; the effective mass (kg) is `+inf` where the interface is
    /// locked.
    pub(super) fn report(&self) -> SchemeReport {
        SchemeReport {
            effective_mass: Some(self.condensation.effective_mass),
            counters: self.friction.as_ref().map_or_else(|| self.solver.counters(), |f| f.contacts.counters()),
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

    /// A mass of 2 kg on a floor along which the interface pulls, μ = 0.5: 20 N press, so that friction holds 10 N.
    fn rubbing(mut model: ReducedInterfaceModel, along: f64, w: f64) -> ReducedInterfaceModel {
        let rows = model.a.len();
        (0..rows).for_each(|row| model.h[row * rows + row] = 0.5);
        // The interface is the first tangent.
        (model.h[rows + rows - 1], model.h[(rows - 1) * rows + 1]) = (0.5, 0.5);
        (model.a[0], model.w[1], model.w[rows - 1], model.mechanics_step) = (-10.0, w, w, 1e-3);
        // As it lands: the impact is no part of the acceleration.
        model.w[0] = along;
        model
    }

    #[test]
    fn a_contact_with_friction_holds_slows_and_stops_what_the_interface_pulls() {
        let plane = ReducedInterfaceModel::zeros_with_friction(&[0.5], 1);
        let space = ReducedInterfaceModel::zeros_in_space(&[0.5], 1);
        let options = ModelOptions::default();
        for empty in [plane, space] {
            // (pull, velocity, landing with, acceleration, effective mass): 1e-4 m/s stop within the mechanics' step.
            for (force, w, landing, a, mass) in [
                (4.0, 0.0, 0.0, 0.0, f64::INFINITY),
                (-9.0, 0.0, -1.0, 0.0, f64::INFINITY),
                (14.0, 0.0, 0.0, 2.0, 2.0),
                (4.0, 1.0, 0.0, -3.0, 2.0),
                (4.0, -1.0, -1.0, 7.0, 2.0),
                (4.0, 1e-4, 0.0, -0.1, f64::INFINITY),
            ] {
                let mut found =
                    InterfaceAcceleration::new(ModelConstruction { empty: &empty, options: &options, detection: None });
                found.receive(&rubbing(empty.clone(), landing, w));
                found.find(&[force]).unwrap();
                // A velocity solved to 1e-9 of 1 m/s over 1 ms.
                assert!((found.acceleration[0] - a).abs() < 1e-6, "{force} N at {w} m/s: {}", found.acceleration[0]);
                assert_eq!(found.report().effective_mass.unwrap(), mass, "{force} N at {w} m/s");
                assert_eq!(found.free_mobility(0, 0), 0.5);
            }
        }
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
