//! The modes of contacts with friction in which a model is condensed.

use rimbench_contact::friction::ContactState;

/// Modes and coefficients of contacts with friction, in the order of the model; empty without friction.
#[derive(Debug, Clone, Copy)]
pub struct ContactModes<'a> {
    /// Open, stick, or slip.
    pub states: &'a [ContactState],
    /// Coefficient μ of each contact.
    pub friction: &'a [f64],
}

impl ContactModes<'_> {
    /// Writes the states of all contacts with those of `closed` closed: one that the mechanics' last step found open slides as it moves, at
    /// its velocity in the rows `w` (m/s).
    pub(crate) fn close(&self, w: &[f64], closed: &[usize], states: &mut [ContactState]) {
        states.fill(ContactState::Open);
        for &contact in closed {
            states[contact] = match self.states[contact] {
                ContactState::Open => ContactState::of_closed(w[self.states.len() + contact], 0.0),
                known => known,
            };
        }
    }
}
