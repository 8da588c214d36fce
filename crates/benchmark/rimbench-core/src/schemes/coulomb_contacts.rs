//! The contacts of a reduced interface model that take part, where they have friction, in the plane or in space.

use crate::interface_model::ReducedInterfaceModel;
use rimbench_contact::friction::space::SpaceSolver;
use rimbench_contact::friction::{FrictionSolver, Stiction};
use rimbench_contact::solver_entry::SolverEntry;

/// A set of contacts with their coefficients and a solver, which starts in the plane from the states that the
/// mechanics' own solver would start from, in space from the forces of the mechanics' last step.
#[derive(Clone)]
pub(super) struct ContactsWithFriction<S> {
    /// Rows of the model: the contacts, then their tangential rows.
    pub(super) rows: Vec<usize>,
    pub(super) friction: Vec<f64>,
    /// As many coefficients of contacts without friction.
    pub(super) none: Vec<f64>,
    /// Where a contact at rest has a coefficient of its own, each problem finds the coefficients that the one before
    /// has left.
    pub(super) stiction: Option<Stiction>,
    /// In space, forces of these rows in the mechanics' last step, N.
    pub(super) forces: Vec<f64>,
    pub(super) solver: S,
}

pub(super) type CoulombContacts = ContactsWithFriction<FrictionSolver>;
pub(super) type SpaceContacts = ContactsWithFriction<SpaceSolver>;

impl<S> ContactsWithFriction<S> {
    fn new(model: &ReducedInterfaceModel, solver: S) -> Box<Self> {
        let (n, rows) = (model.contacts(), model.interface_start());
        let (friction, forces) = (Vec::with_capacity(n), Vec::with_capacity(rows));
        let none = vec![0.0; n];
        Box::new(Self { rows: Vec::with_capacity(rows), friction, none, stiction: model.stiction, forces, solver })
    }

    /// Takes the contacts of a model that has arrived, each with so many rows.
    pub(super) fn take(&mut self, set: &[usize], rows: usize, model: &ReducedInterfaceModel) {
        let n = model.contacts();
        self.rows.clear();
        self.rows.extend((0..rows).flat_map(|axis| set.iter().map(move |contact| axis * n + contact)));
        self.friction.clear();
        self.friction.extend(set.iter().map(|&contact| model.friction[contact]));
    }
}

impl CoulombContacts {
    /// Reserves models like this one; none without friction.
    pub(super) fn of(model: &ReducedInterfaceModel, solver: &SolverEntry) -> Option<Box<Self>> {
        model.has_friction().then(|| {
            let solver = solver.checked_with_friction(model.contacts());
            Self::new(model, solver.expect("the options have a solver of contacts with friction"))
        })
    }
}

impl SpaceContacts {
    /// Reserves models like this one; none but in space.
    pub(super) fn of(model: &ReducedInterfaceModel, solver: &SolverEntry) -> Option<Box<Self>> {
        model.is_in_space().then(|| Self::new(model, SpaceSolver::new(model.contacts(), solver.tolerance)))
    }
}
