//! Linear complementarity problems: `w = M z + q`, `0 ≤ w ⟂ z ≥ 0`.
//!
//! `M` is symmetric positive semidefinite, and in mechanics with more contacts than degrees of freedom it is singular
//! as a rule (`M = H_uu = A_u G A_uᵀ`, 1/kg; `z` impulses, N·s; `w`, `q` velocities, m/s). Then `z` is not unique;
//! `w` and the resultant are.

use crate::error::Failure;

/// One problem `w = M z + q`, `0 ≤ w ⟂ z ≥ 0`.
#[derive(Debug, Clone, Copy)]
pub struct Lcp<'a> {
    /// `n×n`, row-major, symmetric positive semidefinite.
    pub m: &'a [f64],
    /// Length `n`.
    pub q: &'a [f64],
}

/// What a solver did.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SolveStats {
    /// Changes of the active set (or simplex pivots, or iterations of an iterative solver).
    pub pivots: u32,
    /// Factorisations from scratch.
    pub factorisations: u32,
    /// True if the fallback found the answer.
    pub fallback: bool,
    /// Natural residual, recomputed from `M`, `q`, `z` after the solve.
    pub residual: f64,
}

/// Solves linear complementarity problems of one size class, reusing its workspace.
pub trait ComplementaritySolver: Send {
    /// Writes a solution to `z`.
    fn solve(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Failure>;
}
