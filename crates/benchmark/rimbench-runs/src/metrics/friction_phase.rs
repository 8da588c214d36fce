//! What a contact with friction does when.
//!
//! A contact is open, sticks, or slides one way or the other, as the *solver* of the last step has it; a slow slide is
//! a slide. The state of a row is that of the step which ends there, so it holds from the row before. Run and reference
//! are read by the same rule, the reference at its own sampling.

use rimbench_core::cosim::Trajectory;
use rimbench_core::friction::ContactState;

/// A time during which a contact does not change its state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionPhase {
    pub(super) since: f64,
    pub(super) state: ContactState,
}

/// What a contact does, found row by row.
#[derive(Debug, Clone, Default)]
pub struct FrictionPhases {
    /// The phases so far.
    pub found: Vec<FrictionPhase>,
    before: Option<f64>,
}

impl FrictionPhases {
    /// Takes the time of one more row and what its column says.
    pub(super) fn add(&mut self, time: f64, state: f64) {
        let state = ContactState::of_number(state).unwrap_or_default();
        if self.found.last().is_none_or(|last| last.state != state) {
            self.found.push(FrictionPhase { since: self.before.unwrap_or(time), state });
        }
        self.before = Some(time);
    }
}

/// Returns what the contact with the state column `column` does, phase by phase.
pub fn friction_phases(trajectory: &Trajectory, column: usize) -> Vec<FrictionPhase> {
    let mut phases = FrictionPhases::default();
    trajectory.rows().for_each(|row| phases.add(row[0], row[column]));
    phases.found
}
