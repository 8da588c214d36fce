//! A method for contacts with friction.

use super::{ContactState, FrictionProblem};
use crate::complementarity::{SolveStats, Unsolved};
use dyn_clone::DynClone;

/// A method that goes from the states of one problem to those of the next.
pub trait StateMethod: DynClone + Send {
    /// Goes on from `states`; writes a proposal to `impulses`, and its states. The stats have its natural residual. `same_matrix` tells that
    /// matrix and coefficients are those of the problem before: in its states nothing is factorised.
    ///
    /// # Errors
    /// [`Unsolved::NotFound`] without a proposal, [`Unsolved::NonFinite`] if `b` is not finite.
    fn attempt(
        &mut self,
        problem: FrictionProblem<'_>,
        same_matrix: bool,
        states: &mut [ContactState],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved>;
}

dyn_clone::clone_trait_object!(StateMethod);
