//! The modes of contacts with friction in which a model is condensed.

use rimbench_contact::friction::ContactState;

/// Modes and coefficients of contacts with friction, in the order of the model; empty without friction.
#[derive(Debug, Clone, Copy)]
pub struct ContactModes<'a> {
    /// Open, stick, or slip.
    pub states: &'a [ContactState],
    /// Coefficient μ of each contact.
    pub friction: &'a [f64],
    /// Direction in which each contact slides, of length 1, in its two tangential rows; empty in the plane.
    pub directions: &'a [[f64; 2]],
}

/// Returns state and direction of a closed contact that moves so in space (m/s), standing still up to `tolerance`
/// (m/s).
pub(crate) fn closed_in_space(w_t: [f64; 2], tolerance: f64) -> (ContactState, [f64; 2]) {
    let speed = (w_t[0] * w_t[0] + w_t[1] * w_t[1]).sqrt();
    if speed <= tolerance {
        return (ContactState::Stick, [1.0, 0.0]);
    }
    (ContactState::SlipPositive, w_t.map(|w| w / speed))
}

impl ContactModes<'_> {
    /// Writes the states of all contacts with those of `closed` closed: one that the mechanics' last step found open
    /// slides as it moves, at its velocity in the rows `w` (m/s). In space `directions` are then theirs.
    pub(crate) fn close(&self, w: &[f64], closed: &[usize], states: &mut [ContactState], directions: &mut [[f64; 2]]) {
        let n = self.states.len();
        states.fill(ContactState::Open);
        directions.copy_from_slice(self.directions);
        for &contact in closed {
            states[contact] = match self.states[contact] {
                ContactState::Open if directions.is_empty() => ContactState::of_closed(w[n + contact], 0.0),
                ContactState::Open => {
                    let (state, direction) = closed_in_space([w[n + contact], w[2 * n + contact]], 0.0);
                    directions[contact] = direction;
                    state
                }
                known => known,
            };
        }
    }
}
