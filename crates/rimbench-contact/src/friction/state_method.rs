//! A method for contacts with friction.

use super::{ContactState, FrictionProblem};
use crate::complementarity::{SolveStats, Unsolved};

/// A method that goes from the states of one problem to those of the next.
pub trait StateMethod: Send {
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

    /// Returns a copy that answers the next problem with the same bits.
    fn boxed_clone(&self) -> Box<dyn StateMethod>;
}

impl Clone for Box<dyn StateMethod> {
    fn clone(&self) -> Self {
        (**self).boxed_clone()
    }
}
