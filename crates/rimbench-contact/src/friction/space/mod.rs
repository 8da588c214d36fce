//! Contacts with Coulomb friction in space: `w = H P + b` with one normal and two tangential rows per contact, on the exact cone.
//!
//! ```text
//! 0 ≤ w_n ⟂ P_n ≥ 0        |P_t| ≤ μ P_n,  P_t = −μ P_n w_t / |w_t| where it slides
//! ```
//! A contact can slide in any direction, so there is no finite list of states as in the plane, and an answer is found by iteration. Methods
//! propose, the [natural residual](crate::problem::ContactProblem::natural_residual) decides: [`SpaceSolver`] asks [`SemismoothNewton`] from
//! the impulses of the last problem, then in turn [`SpaceSweeps`] and [`SpaceAdmm`], each followed by Newton.
//!
//! Velocities are unique in the plane, in space they are not: where rigid contacts are redundant and slide in different directions, the
//! resultant of their friction depends on how they share the load. Four feet under one body have a family of solutions.
//!
//! Only `+ − × ÷ √` are used, in an order that depends on sizes and values alone, so an answer has the same bits on every machine.

mod admm;
mod newton;
mod solver;
mod sweeps;

pub use admm::SpaceAdmm;
pub use newton::SemismoothNewton;
pub use solver::{SpaceFallbacks, SpaceSolver};
pub use sweeps::SpaceSweeps;

use super::FrictionProblem;
use crate::linear_algebra::dot;

/// One contact problem in space: `H = [H_nn H_nt; H_tn H_tt]` and `b = [b_n; b_t1; b_t2]`, 3n rows.
pub type SpaceProblem<'a> = FrictionProblem<'a, 2>;

/// Rows of a contact: normal and two tangential ones.
fn rows(contact: usize, contacts: usize) -> [usize; 3] {
    [contact, contacts + contact, 2 * contacts + contact]
}

/// Returns the entries of a contact.
#[inline(always)]
fn of(contact: usize, contacts: usize, vector: &[f64]) -> [f64; 3] {
    rows(contact, contacts).map(|row| vector[row])
}

/// Writes `w = H P + b` and returns the natural residual.
#[inline]
fn measure(problem: SpaceProblem<'_>, impulses: &[f64], w: &mut [f64]) -> f64 {
    match problem.b.len() {
        3 => velocities_of_few::<3>(problem, impulses, w),
        6 => velocities_of_few::<6>(problem, impulses, w),
        9 => velocities_of_few::<9>(problem, impulses, w),
        12 => velocities_of_few::<12>(problem, impulses, w),
        18 => velocities_of_few::<18>(problem, impulses, w),
        _ => {
            for (row, w) in w.iter_mut().enumerate() {
                *w = problem.b[row] + dot(problem.delassus.row(row), impulses);
            }
        }
    }
    problem.residual_of(impulses, |row| w[row])
}

/// The compiler knows the sizes of few contacts.
#[inline(never)]
fn velocities_of_few<const N: usize>(problem: SpaceProblem<'_>, impulses: &[f64], w: &mut [f64]) {
    let (h, b, p, w) = (&problem.delassus.h[..N * N], &problem.b[..N], &impulses[..N], &mut w[..N]);
    for row in 0..N {
        let line = &h[row * N..(row + 1) * N];
        let mut sum = b[row];
        for column in 0..N {
            sum += line[column] * p[column];
        }
        w[row] = sum;
    }
}

/// Returns H_nn and the largest diagonal entry of the tangential rows of a contact; 1 for a row of zeros.
fn weights(problem: SpaceProblem<'_>, contact: usize) -> (f64, f64) {
    let [normal, t1, t2] =
        rows(contact, problem.contacts()).map(|row| problem.delassus.h[row * problem.delassus.rows + row]);
    let weight = |h: f64| if h > 0.0 { h } else { 1.0 };
    (weight(normal), weight(if t2 > t1 { t2 } else { t1 }))
}
