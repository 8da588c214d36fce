//! Contacts with Coulomb friction in space: `w = H P + b` with one normal and two tangential rows per contact, on the
//! exact cone.
//!
//! ```text
//! 0 ≤ w_n ⟂ P_n ≥ 0        |P_t| ≤ μ P_n,  P_t = −μ P_n w_t / |w_t| where it slides
//! ```
//! A contact can slide in any direction, so there is no finite list of states as in the plane, and an answer is found
//! by iteration. Methods propose, the [natural residual](crate::problem::ContactProblem::natural_residual) decides:
//! [`SpaceSolver`] asks [`SemismoothNewton`] from the impulses of the last problem, then in turn
//! [`ContactSweeps`](super::ContactSweeps) and [`SpaceAdmm`], each followed by Newton.
//!
//! Velocities are unique in the plane, in space they are not: where rigid contacts are redundant and slide in different
//! directions, the resultant of their friction depends on how they share the load. Four feet under one body have a
//! family of solutions.
//!
//! Only `+ − × ÷ √` are used, in an order that depends on sizes and values alone, so an answer has the same bits on
//! every machine.

mod admm;
mod newton;
mod solver;

pub use admm::SpaceAdmm;
pub use newton::SemismoothNewton;
pub use solver::{SpaceFallbacks, SpaceSolver};

use super::FrictionProblem;

/// One contact problem in space: `H = [H_nn H_nt; H_tn H_tt]` and `b = [b_n; b_t1; b_t2]`, 3n rows.
pub type SpaceProblem<'a> = FrictionProblem<'a, 2>;

/// Rows of a contact: normal and two tangential ones.
fn rows(contact: usize, contacts: usize) -> [usize; 3] {
    [contact, contacts + contact, 2 * contacts + contact]
}

/// Returns the entries of all normal rows, of the first tangential ones and of the second ones.
#[inline(always)]
fn by_axis(vector: &[f64], contacts: usize) -> [&[f64]; 3] {
    let (normal, tangential) = vector[..3 * contacts].split_at(contacts);
    let (first, second) = tangential.split_at(contacts);
    [normal, first, &second[..contacts]]
}

/// Returns the entries of a contact.
#[inline(always)]
fn of(contact: usize, contacts: usize, vector: &[f64]) -> [f64; 3] {
    rows(contact, contacts).map(|row| vector[row])
}

/// Returns H_nn and the largest diagonal entry of the tangential rows of a contact; 1 for a row of zeros.
fn weights(problem: SpaceProblem<'_>, contact: usize) -> (f64, f64) {
    let [normal, t1, t2] =
        rows(contact, problem.contacts()).map(|row| problem.delassus.h[row * problem.delassus.rows + row]);
    let weight = |h: f64| if h > 0.0 { h } else { 1.0 };
    (weight(normal), weight(if t2 > t1 { t2 } else { t1 }))
}
