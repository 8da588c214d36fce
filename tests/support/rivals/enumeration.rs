//! Every active set there is: the oracle the solvers are tested against.

use nalgebra::{DMatrix, DVector};
use rimbench::complementarity::{ComplementaritySolver, Lcp, SolveStats, Unsolved};

/// Largest `n` that is enumerated.
pub const ENUMERATION_LIMIT: usize = 12;

/// Singular values below this part of 1 (the diagonal is scaled to 1) are zero.
const RANK: f64 = 1e-10;

/// Tries all `2^n` active sets and keeps the proposal with the least natural residual.
///
/// ```text
/// P_A = max(0, −H_AA⁺ b_A),   P = 0 elsewhere          for every A ⊆ {1 … n}
/// ```
/// `H_AA⁺` is the pseudo-inverse of the submatrix scaled to unit diagonal. A solvable problem with positive
/// semidefinite `H` has a solution whose `H_AA` is regular (a vertex of the solution set), so none is missed. Of
/// equally good proposals the one with the first set in binary order is kept.
///
/// Guaranteed for symmetric positive semidefinite `H` when a solution exists and `n ≤` [`ENUMERATION_LIMIT`]. If there
/// is no solution the best proposal is still written, with its large residual. Allocates.
#[derive(Debug, Clone, Default)]
pub struct Enumeration {}

/// Makes a diagonal entry 1. A contact that no impulse moves (zero; semidefinite, so is its whole row) has no scale,
/// and one whose scale would not be finite, or of whose square the inverse, has none either.
fn scale_of(diagonal: f64) -> f64 {
    let scale = diagonal.sqrt().recip();
    if scale.is_finite() && (scale * scale).is_finite() { scale } else { 1.0 }
}

impl ComplementaritySolver for Enumeration {
    fn attempt(&mut self, lcp: Lcp<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let n = lcp.size();
        impulses.fill(0.0);
        if lcp.is_solved_by_zero()? {
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        if n > ENUMERATION_LIMIT {
            return Err(Unsolved::TooLarge { size: n });
        }
        let scale: Vec<f64> = (0..n).map(|i| scale_of(lcp.h()[i * n + i])).collect();
        let mut least = lcp.natural_residual(impulses);
        let mut proposal = vec![0.0; n];
        let mut stats = SolveStats { pivots: 1, ..SolveStats::default() };
        for members in 1_usize..1 << n {
            let set: Vec<usize> = (0..n).filter(|i| members >> i & 1 == 1).collect();
            let h_aa = DMatrix::from_fn(set.len(), set.len(), |r, c| {
                scale[set[r]] * lcp.h()[set[r] * n + set[c]] * scale[set[c]]
            });
            let minus_b = DVector::from_fn(set.len(), |r, _| -scale[set[r]] * lcp.b[set[r]]);
            stats.pivots += 1;
            stats.factorisations += 1;
            // An overflow of the scaling: nothing to be found here, and the decomposition might never end.
            if !h_aa.iter().chain(minus_b.iter()).all(|entry| entry.is_finite()) {
                continue;
            }
            let Ok(p_a) = h_aa.svd(true, true).solve(&minus_b, RANK) else { continue };
            proposal.fill(0.0);
            for (&i, p_i) in set.iter().zip(&p_a) {
                proposal[i] = (scale[i] * p_i).max(0.0);
            }
            let residual = lcp.natural_residual(&proposal);
            if residual < least {
                least = residual;
                impulses.copy_from_slice(&proposal);
            }
        }
        Ok(stats)
    }
}
