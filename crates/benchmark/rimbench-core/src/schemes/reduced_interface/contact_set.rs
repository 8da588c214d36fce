//! The contacts that a model contains within a macro step.

use super::super::active_contacts::ActiveContacts;
use super::super::contact_detection::ContactDetection;
use super::super::moving_model::MovingModel;
use super::super::recorded_modes::RecordedModes;
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;
use rimbench_contact::complementarity::SolverCounters;

/// How contacts enter the model within the macro step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Contacts {
    /// The paper's smooth model: contacts closed at `t_k` are bilateral, `w_c⁺ = 0`, and eliminated beforehand.
    Bilateral,
    /// Contacts that carry impulse at `t_k` are bilateral, the others are left out.
    BilateralActive,
    /// The paper's non-smooth model, Eq. 4: contacts closed at `t_k` may open, `0 ≤ w_u⁺ ⟂ P_u ≥ 0`, or with a
    /// [`GapTerm`](super::gap_law::GapTerm).
    Unilateral,
    /// All contacts may also close: `0 ≤ w_u⁺ + g/δ ⟂ P_u ≥ 0`, `g⁺ = g + δ w_u⁺`.
    UnilateralWithGaps,
}

impl Contacts {
    pub(super) fn are_bilateral(self) -> bool {
        matches!(self, Contacts::Bilateral | Contacts::BilateralActive)
    }
}

/// Detects the contacts at a communication point, and remembers those of the last one.
#[derive(Clone)]
pub(super) struct ContactSet {
    kind: Contacts,
    /// None where all contacts are in the model.
    detection: Option<ContactDetection>,
    contacts: Vec<usize>,
    previous: Vec<usize>,
    active: ActiveContacts,
}

impl ContactSet {
    /// Reserves up to `contacts` contacts.
    pub(super) fn new(
        kind: Contacts,
        detection: Option<ContactDetection>,
        contacts: usize,
        active: ActiveContacts,
    ) -> Self {
        let empty = || Vec::with_capacity(contacts);
        ContactSet { kind, detection, contacts: empty(), previous: empty(), active }
    }

    /// Returns the contacts of the set.
    #[inline]
    pub(super) fn contacts(&self) -> &[usize] {
        &self.contacts
    }

    /// Tells whether the set differs from that of the communication point before.
    pub(super) fn has_changed(&self) -> bool {
        self.contacts != self.previous
    }

    /// Tells whether the set depends on the actuator's force.
    pub(super) fn waits_for_force(&self) -> bool {
        self.kind == Contacts::BilateralActive
    }

    /// Detects the contacts of a received model.
    pub(super) fn detect(&mut self, model: &ReducedInterfaceModel) {
        std::mem::swap(&mut self.contacts, &mut self.previous);
        match self.detection {
            None | Some(ContactDetection::MechanicsLaw) => {
                self.contacts.clear();
                self.contacts.extend(0..model.contacts());
            }
            Some(ContactDetection::Active) if self.kind == Contacts::Unilateral => {
                model.closed_and_leaving_contacts(&mut self.contacts);
            }
            Some(ContactDetection::Active) => model.closed_contacts(&mut self.contacts),
            Some(ContactDetection::Margin { width }) => model.contacts_within(width, &mut self.contacts),
        }
    }

    /// Keeps the contacts that carry impulse under the actuator's force `lambda` (N), and records whether they stick or
    /// slip.
    ///
    /// # Errors
    /// As the contact solver reports.
    pub(super) fn keep_active(
        &mut self,
        model: &mut MovingModel,
        lambda: &[f64],
        modes: &mut RecordedModes,
    ) -> Result<(), Failure> {
        let by_law = self.detection == Some(ContactDetection::MechanicsLaw);
        self.active.keep(&mut self.contacts, &model.received, lambda, by_law, modes)?;
        if by_law {
            let (received, current) = model.lend();
            // Bilateral contacts then follow the gap law: w_c⁺ = −t.
            for &contact in &self.contacts {
                current.w[contact] += received.step_gap_velocity(contact);
            }
        }
        Ok(())
    }

    /// Returns the counts of the problems solved at communication points.
    pub(super) fn counters(&self) -> SolverCounters {
        self.active.counters()
    }
}
