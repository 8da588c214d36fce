//! The contacts of a reduced interface model that take part, where they have friction.

use super::recorded_modes::RecordedModes;
use crate::interface_model::ReducedInterfaceModel;
use rimbench_contact::affine_step::DiscretisedModel;
use rimbench_contact::complementarity::{SolveStats, SolverCounters, Unsolved};
use rimbench_contact::friction::{ContactState, FrictionProblem, FrictionSolver, Stiction};
use rimbench_contact::solver_entry::SolverEntry;

/// A set of contacts with their coefficients and a solver, which starts from the states that the mechanics' own solver would start from.
/// Where a contact at rest has a coefficient of its own, each problem finds the coefficients that the one before has left.
#[derive(Clone)]
pub(super) struct CoulombContacts {
    /// Rows of the model: the contacts, then their tangential rows.
    rows: Vec<usize>,
    friction: Vec<f64>,
    stiction: Option<Stiction>,
    solver: FrictionSolver,
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

    /// Sets the contacts of `set`, with coefficients and modes as the model has them.
    pub(super) fn set_contacts(&mut self, set: &[usize], model: &ReducedInterfaceModel) {
        let n = model.contacts();
        self.rows.clear();
        self.rows.extend(set.iter().copied().chain(set.iter().map(|contact| n + contact)));
        self.friction.clear();
        self.friction.extend(set.iter().map(|&contact| model.friction[contact]));
        self.solver.solver.start_from(set.iter().map(|&contact| model.solved_states[contact]));
    }

    /// Returns the rows of the model that take part: contacts, then tangential rows.
    pub(super) fn stacked_rows(&self) -> &[usize] {
        &self.rows
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

    /// Returns their coefficients, in the same order.
    pub(super) fn friction(&self) -> &[f64] {
        &self.friction
    }

    /// Solves the packed contacts with the velocities `b`, `[b_n; b_t]` (m/s); `changed` tells that `H` differs from that of the problem before.
    pub(super) fn solve(
        &mut self,
        model: &DiscretisedModel,
        changed: bool,
        b: &[f64],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let solved = self.try_solve(model, changed, b, impulses)?;
        if let Some(stiction) = self.stiction {
            let (m, h) = (self.friction.len(), model.h_uu());
            let rounding = self.solver.tolerance() * b.iter().fold(0.0, |max: f64, b| max.max(b.abs()));
            for (contact, (coefficient, state)) in self.friction.iter_mut().zip(self.solver.solver.states()).enumerate()
            {
                let row = m + contact;
                let pushed: f64 =
                    h[row * 2 * m..(row + 1) * 2 * m].iter().zip(impulses.iter()).map(|(h, p)| h * p).sum();
                *coefficient = stiction.after(state.moving(b[row] + pushed, rounding));
            }
        }
        Ok(solved)
    }

    /// Solves a trial, which leaves the coefficients as they are.
    pub(super) fn try_solve(
        &mut self,
        model: &DiscretisedModel,
        changed: bool,
        b: &[f64],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let problem = FrictionProblem::with_friction(model.h_uu(), b, &self.friction);
        // Coefficients that change make another problem of the same matrix.
        let same = !changed && self.stiction.is_none();
        if same { self.solver.solve_again(problem, impulses) } else { self.solver.solve(problem, impulses) }
    }

    /// Returns the solver's tolerance.
    pub(super) fn tolerance(&self) -> f64 {
        self.solver.tolerance()
    }

    pub(super) fn counters(&self) -> SolverCounters {
        self.solver.counters()
    }
}
