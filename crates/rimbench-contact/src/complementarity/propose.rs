//! Proposals of impulses: the solver that is asked first, and its fallback.

use super::{SolveStats, Unsolved};
use crate::problem::{Cone, ContactProblem, DelassusOperator};

/// The contact problem of a solver.
pub type ProblemOf<'a, S> = ContactProblem<'a, <S as ProposeImpulses>::Delassus<'a>, <S as ProposeImpulses>::Cone<'a>>;

/// Proposes impulses, from the active set of the last problem.
pub trait ProposeImpulses {
    /// The form of H.
    type Delassus<'a>: DelassusOperator;
    /// K.
    type Cone<'a>: Cone;

    /// Writes a proposal for P; the stats have its natural residual. `same_matrix` tells that H and K are those of the problem before, and
    /// `tolerance` is the residual up to which the proposal will be accepted.
    ///
    /// # Errors
    /// [`Unsolved::NonFinite`] if `b` is not finite, and [`Unsolved::NotFound`] without a proposal, whose work is then not counted.
    fn propose(
        &mut self,
        problem: ProblemOf<'_, Self>,
        same_matrix: bool,
        tolerance: f64,
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved>;

    /// Forgets the active set.
    fn reset(&mut self);
}

/// Proposes impulses where those of the solver S are not good enough.
pub trait Fallback<S: ProposeImpulses> {
    /// Writes what the method number `turn` proposes, as [`ProposeImpulses::propose`]; none after the last method.
    fn propose(
        &mut self,
        turn: u32,
        solver: &mut S,
        problem: ProblemOf<'_, S>,
        tolerance: f64,
        impulses: &mut [f64],
    ) -> Option<Result<SolveStats, Unsolved>>;
}
