//! Where the contacts of the model end, for the account of the energy that it created.

use super::ReducedInterface;
use crate::cosim::ModelEnd;
use crate::schemes::model_contacts::ModelContacts;

impl ReducedInterface {
    /// Returns the velocities w (m/s) of the model's contacts at the end of the macro step; none where its matrices
    /// moved, where only their non-zeros are kept, where it has fewer rows than the mechanics, and where its interface
    /// locks by its own friction.
    pub(super) fn end_of_macro_step(&mut self) -> Option<ModelEnd<'_>> {
        self.bring_contacts_up_to_date();
        let ReducedInterface { set, slip_rows, model, contacts, modes, law, state, .. } = self;
        if slip_rows.is_some() || !model.stays() || model.received.delassus_pattern().is_some() {
            return None;
        }
        let (received, current) = (&model.received, model.current());
        if !matches!(contacts, ModelContacts::Bilateral) {
            // Velocities of many contacts are out of date within a critical region.
            contacts.leave_region(law, state);
            let rows = contacts.rows(set.contacts());
            return Some(ModelEnd { rows, w: &state.w_plus[..rows.len()], bilateral_modes: None });
        }
        // Bilateral contacts stand still, or follow their gap term; they have no use for impulses.
        for (w, &contact) in state.impulses.iter_mut().zip(set.contacts()) {
            *w = received.w[contact] - current.w[contact];
        }
        if self.condensation.locks_itself {
            return None;
        }
        let bilateral_modes = received.has_friction().then(|| modes.get());
        Some(ModelEnd { rows: set.contacts(), w: &state.impulses[..set.contacts().len()], bilateral_modes })
    }
}
