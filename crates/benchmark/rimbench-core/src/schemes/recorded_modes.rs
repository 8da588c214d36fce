//! Modes of contacts with friction as a scheme's own contact problems find them.

use crate::interface_model::{ContactModes, ReducedInterfaceModel};
use rimbench_contact::friction::{ContactState, Stiction};

/// Modes and coefficients since the last communication point: the mechanics' own, until a problem of the scheme is
/// solved.
#[derive(Debug, Clone)]
pub(super) struct RecordedModes {
    states: Vec<ContactState>,
    friction: Vec<f64>,
    directions: Vec<[f64; 2]>,
    stiction: Option<Stiction>,
}

impl RecordedModes {
    /// Reserves the contacts of models like `empty`.
    pub(super) fn of(empty: &ReducedInterfaceModel) -> Self {
        RecordedModes {
            states: empty.states.clone(),
            friction: empty.friction.clone(),
            directions: empty.directions.clone(),
            stiction: empty.stiction,
        }
    }

    /// Starts from the modes that the mechanics sent.
    pub(super) fn start_from(&mut self, model: &ReducedInterfaceModel) {
        self.states.copy_from_slice(&model.states);
        self.friction.copy_from_slice(&model.friction);
        self.directions.copy_from_slice(&model.directions);
    }

    /// Records what a contact did, and the coefficient that follows from it.
    pub(super) fn record(&mut self, contact: usize, state: ContactState) {
        self.states[contact] = state;
        if let Some(stiction) = self.stiction {
            self.friction[contact] = stiction.after(state);
        }
    }

    /// Records what a contact did in space, and the direction in which it slides.
    pub(super) fn record_in_space(&mut self, contact: usize, (state, direction): (ContactState, [f64; 2])) {
        (self.states[contact], self.directions[contact]) = (state, direction);
    }

    /// Returns the modes.
    pub(super) fn get(&self) -> ContactModes<'_> {
        ContactModes { states: &self.states, friction: &self.friction, directions: &self.directions }
    }
}
