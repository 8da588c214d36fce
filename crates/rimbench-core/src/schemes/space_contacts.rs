//! The contacts of a reduced interface model that take part, where they have friction in space.

use super::recorded_modes::RecordedModes;
use crate::interface_model::{ReducedInterfaceModel, closed_in_space};
use rimbench_contact::friction::space::SpaceSolver;
use rimbench_contact::solver_entry::SolverEntry;

/// A set of contacts with their coefficients and a solver, which starts from the forces of the mechanics' last step.
#[derive(Clone)]
pub(super) struct SpaceContacts {
    /// Rows of the model: the contacts, then their tangential rows.
    pub(super) rows: Vec<usize>,
    pub(super) friction: Vec<f64>,
    /// Forces of these rows in the mechanics' last step, N.
    pub(super) forces: Vec<f64>,
    pub(super) solver: SpaceSolver,
}

impl SpaceContacts {
    /// Reserves models like this one; none but in space.
    pub(super) fn of(model: &ReducedInterfaceModel, solver: &SolverEntry) -> Option<Box<Self>> {
        let n = model.contacts();
        model.is_in_space().then(|| {
            Box::new(SpaceContacts {
                rows: Vec::with_capacity(3 * n),
                friction: Vec::with_capacity(n),
                forces: Vec::with_capacity(3 * n),
                solver: SpaceSolver::new(n, solver.tolerance),
            })
        })
    }

    /// Records what the contacts of `set` have done, moving by `w` (m/s), which is rounding up to `rounding` (m/s).
    pub(super) fn record_modes(&self, set: &[usize], w: &[f64], rounding: f64, modes: &mut RecordedModes) {
        let n = set.len();
        for (slot, &contact) in set.iter().enumerate() {
            modes.record_in_space(contact, closed_in_space([w[n + slot], w[2 * n + slot]], rounding));
        }
    }
}
