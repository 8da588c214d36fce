//! The contacts of a reduced interface model that take part, where they have friction.

use super::recorded_modes::RecordedModes;
use crate::interface_model::ReducedInterfaceModel;
use rimbench_contact::friction::{ContactState, FrictionSolver, Stiction};
use rimbench_contact::solver_entry::SolverEntry;

/// A set of contacts with their coefficients and a solver, which starts from the states that the mechanics' own solver would start from.
/// Where a contact at rest has a coefficient of its own, each problem finds the coefficients that the one before has left.
#[derive(Clone)]
pub(super) struct CoulombContacts {
    /// Rows of the model: the contacts, then their tangential rows.
    pub(super) rows: Vec<usize>,
    pub(super) friction: Vec<f64>,
    pub(super) stiction: Option<Stiction>,
    pub(super) solver: FrictionSolver,
}

impl CoulombContacts {
    /// Reserves models like this one; none without friction.
    pub(super) fn of(model: &ReducedInterfaceModel, solver: &SolverEntry) -> Option<Box<Self>> {
        let n = model.contacts();
        model.has_friction().then(|| {
            Box::new(CoulombContacts {
                rows: Vec::with_capacity(2 * n),
                friction: Vec::with_capacity(n),
                stiction: model.stiction,
                solver: solver.checked_with_friction(n).expect("the options have a solver of contacts with friction"),
            })
        })
    }

    /// Returns the modes of the contacts, in the order of the set.
    pub(super) fn states(&self) -> &[ContactState] {
        self.solver.solver.states()
    }

    /// Records what the contacts of `set` have done, moving by `w_t` (m/s), which is rounding up to `rounding` (m/s): of redundant contacts
    /// one may be loaded up to its bound and not move.
    pub(super) fn record_modes(&self, set: &[usize], w_t: &[f64], rounding: f64, modes: &mut RecordedModes) {
        for ((&contact, state), w_t) in set.iter().zip(self.states()).zip(w_t) {
            modes.record(contact, state.moving(*w_t, rounding));
        }
    }
}
