//! Proposals of impulses: those of a solver, and of its fallback.

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
    /// What proposes where its own answer is not good enough.
    type Fallback;

    /// Writes a proposal for P; the stats have its natural residual. `same_matrix` tells that H and K are those of the
    /// problem before, and `tolerance` is the residual up to which the proposal will be accepted.
    ///
    /// # Errors
    /// [`Unsolved::NonFinite`] if `b` is not finite, and [`Unsolved::NotFound`] without a proposal, whose work is then
    /// not counted.
    fn propose(
        &mut self,
        problem: ProblemOf<'_, Self>,
        same_matrix: bool,
        tolerance: f64,
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved>;

    /// Writes what the fallback's method number `turn` proposes in place of an answer that is not good enough, as
    /// [`propose`](Self::propose); none after the last method.
    fn fall_back(
        &mut self,
        fallback: &mut Self::Fallback,
        turn: u32,
        problem: ProblemOf<'_, Self>,
        tolerance: f64,
        impulses: &mut [f64],
    ) -> Option<Result<SolveStats, Unsolved>>;

    /// Forgets the active set.
    fn reset(&mut self);
}
