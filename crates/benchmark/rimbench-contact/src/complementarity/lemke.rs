//! Lemke's complementary pivoting with the lexicographic rule: slow, and hard to defeat.
//!
//! An artificial impulse `z₀` that pushes all contacts apart makes `w − M z − e z₀ = q` solvable at once, in the
//! letters of the method: `M = H`, `q = b`, `z = P`. Then always the complement of the variable that just left enters,
//! until `z₀` leaves:
//!
//! ```text
//! tableau   [ I  −M  −e | q ]        n rows, 2n + 2 columns
//! ratio     lexicographic minimum of (q, B⁻¹)_r / a_r over rows with a_r > 0;  z₀ leaves as soon as it may
//! ```
//! `B⁻¹` is what the pivots made of the identity block, so degenerate problems cannot cycle. If no row qualifies the
//! method ended on a ray, which for a positive semidefinite `M` proves that the problem has no solution. The problem
//! is scaled to unit diagonal and unit `q` first, so the thresholds below are pure numbers. A tableau gathers rounding
//! with every pivot, so the impulses of the final basis are computed once more from `M` and `q`.
//!
//! # Source
//! Lemke, *Bimatrix equilibrium points and mathematical programming*, Management Science 11 (1965); Cottle, Pang,
//! Stone, *The Linear Complementarity Problem* (1992), section 4.4 and, for the lexicographic rule, 4.9.

use super::lemke_tableau::{LemkeTableau, PIVOT};
use super::{ComplementaritySolver, Lcp, SolveStats, Unsolved};
use crate::linear_algebra::{Buffer, Factor};

/// Lemke's method. See the module for the algorithm.
///
/// Guaranteed for positive semidefinite `M` when a solution exists. Keeps no warm start. Free of allocation up to
/// `capacity`.
#[derive(Debug, Clone)]
pub struct Lemke {
    capacity: usize,
    tableau: LemkeTableau<144, 8>,
    scale: Buffer<f64, 8>,
    /// For the impulses of the final basis, computed from `M` and `q` instead of the tableau: its members, and what
    /// becomes of them.
    members: Buffer<usize, 8>,
    factor: Factor,
    fresh: Buffer<f64, 8>,
    afresh: Buffer<f64, 8>,
}

impl Lemke {
    /// Reserves room for problems up to `capacity` contacts; up to 8 need no heap.
    pub fn new(capacity: usize) -> Self {
        Lemke {
            capacity: capacity.max(8),
            tableau: LemkeTableau::new(capacity),
            scale: Buffer::new(capacity),
            members: Buffer::new(capacity),
            factor: Factor::new(capacity),
            fresh: Buffer::new(capacity),
            afresh: Buffer::new(capacity),
        }
    }

    /// Fills the tableau and returns the factor taken out of `q`.
    fn start(&mut self, lcp: Lcp<'_>) -> f64 {
        let n = lcp.size();
        self.capacity = self.capacity.max(n);
        self.scale.grow(n);
        self.members.grow(n);
        self.fresh.grow(n);
        self.afresh.grow(n);
        for i in 0..n {
            let m_ii = lcp.h()[i * n + i];
            self.scale[i] = if m_ii > 0.0 { 1.0 / m_ii.sqrt() } else { 1.0 };
        }
        let scale = &self.scale;
        let b_max = (0..n).fold(f64::MIN_POSITIVE, |max, i| max.max((scale[i] * lcp.b[i]).abs()));
        self.tableau.start(n, |i, row| {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = -scale[i] * lcp.h()[i * n + j] * scale[j];
            }
            scale[i] * lcp.b[i] / b_max
        });
        b_max
    }

    /// Writes the impulses of the final basis: from the tableau, or solved afresh from `M` and `q` if that is better.
    fn write(&mut self, lcp: Lcp<'_>, b_max: f64, impulses: &mut [f64]) {
        let n = lcp.size();
        self.factor.clear(n);
        let mut len = 0;
        for r in 0..n {
            let Some(i) = self.tableau.basic(r) else { continue };
            impulses[i] = self.scale[i] * b_max * self.tableau.rhs(r);
            let d = self.factor.border(lcp.h(), &self.members[..len], i);
            if d > PIVOT * lcp.h()[i * n + i] {
                self.factor.push(d);
                self.members[len] = i;
                len += 1;
            }
        }
        let set = &self.members[..len];
        let fresh = &mut self.fresh[..n];
        fresh.fill(0.0);
        for (x, &i) in fresh.iter_mut().zip(set) {
            *x = -lcp.b[i];
        }
        self.factor.solve(&mut fresh[..len]);
        let afresh = &mut self.afresh[..n];
        afresh.fill(0.0);
        for (x, &i) in fresh.iter().zip(set) {
            afresh[i] = x.max(0.0);
        }
        if lcp.natural_residual(afresh) < lcp.natural_residual(impulses) {
            impulses.copy_from_slice(afresh);
        }
    }
}

impl ComplementaritySolver for Lemke {
    fn attempt(&mut self, lcp: Lcp<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        impulses.fill(0.0);
        if lcp.is_solved_by_zero()? {
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        let b_max = self.start(lcp);
        let pivots = self.tableau.run()?;
        self.write(lcp, b_max, impulses);
        Ok(SolveStats { pivots, factorisations: 1, ..SolveStats::default() })
    }

    fn capacity(&self) -> usize {
        self.capacity
    }
}
