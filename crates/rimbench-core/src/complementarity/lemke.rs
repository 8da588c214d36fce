//! Lemke's complementary pivoting with the lexicographic rule: slow, and hard to defeat.
//!
//! An artificial impulse `z₀` that pushes all contacts apart makes `w − M z − e z₀ = q` solvable at once; then always
//! the complement of the variable that just left enters, until `z₀` leaves:
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

use super::{ComplementaritySolver, Lcp, SolveStats, Unsolved, natural_residual};
use crate::linear_algebra::{Buffer, Factor};

/// Entries of the entering column up to this are zero.
const PIVOT: f64 = 1e-11;
/// `z₀` below this has left as far as rounding can tell.
const VANISHED: f64 = 1e-9;
/// Ratios closer than this, relative to the larger of 1 and the ratio, are tied.
const TIE: f64 = 1e-12;

/// Lemke's method. See the module for the algorithm.
///
/// Guaranteed for positive semidefinite `M` when a solution exists. Keeps no warm start. Free of allocation up to
/// `capacity`.
#[derive(Debug, Clone)]
pub struct Lemke {
    capacity: usize,
    /// `n×(2n+2)`, row-major: `w`, `z`, `z₀`, right-hand side.
    tableau: Buffer<f64, 144>,
    scale: Buffer<f64, 8>,
    /// Variable of each row: `w_i` is `i`, `z_i` is `n + i`, `z₀` is `2n`.
    basis: Buffer<usize, 8>,
    /// Rows still tied in the ratio test.
    tied: Buffer<usize, 8>,
    /// For the impulses of the final basis, computed from `M` and `q` instead of the tableau.
    factor: Factor,
    afresh: Buffer<f64, 8>,
}

impl Lemke {
    /// Reserves room for problems up to `capacity` contacts; up to 8 need no heap.
    pub fn new(capacity: usize) -> Self {
        Lemke {
            capacity: capacity.max(8),
            tableau: Buffer::new(capacity * (2 * capacity + 2)),
            scale: Buffer::new(capacity),
            basis: Buffer::new(capacity),
            tied: Buffer::new(capacity),
            factor: Factor::new(capacity),
            afresh: Buffer::new(capacity),
        }
    }

    /// Fills the tableau and returns the factor taken out of `q`.
    fn start(&mut self, lcp: Lcp<'_>) -> f64 {
        let (n, width) = (lcp.size(), 2 * lcp.size() + 2);
        self.capacity = self.capacity.max(n);
        self.tableau.grow(n * width);
        self.scale.grow(n);
        self.basis.grow(n);
        self.tied.grow(n);
        self.afresh.grow(n);
        for i in 0..n {
            let m_ii = lcp.m[i * n + i];
            self.scale[i] = if m_ii > 0.0 { 1.0 / m_ii.sqrt() } else { 1.0 };
            self.basis[i] = i;
        }
        let q_max = (0..n).fold(f64::MIN_POSITIVE, |max, i| max.max((self.scale[i] * lcp.q[i]).abs()));
        for (i, row) in self.tableau[..n * width].chunks_exact_mut(width).enumerate() {
            row[..n].fill(0.0);
            row[i] = 1.0;
            for j in 0..n {
                row[n + j] = -self.scale[i] * lcp.m[i * n + j] * self.scale[j];
            }
            row[2 * n] = -1.0;
            row[2 * n + 1] = self.scale[i] * lcp.q[i] / q_max;
        }
        q_max
    }

    /// Returns the row that leaves when `column` enters, or `None` on a ray.
    fn leaving_row(&mut self, n: usize, column: usize) -> Option<usize> {
        let width = 2 * n + 2;
        let ratio = |tableau: &[f64], r: usize, c: usize| tableau[r * width + c] / tableau[r * width + column];
        let mut count = 0;
        for r in 0..n {
            if self.tableau[r * width + column] > PIVOT {
                self.tied[count] = r;
                count += 1;
            }
        }
        // First the right-hand side, then the columns of B⁻¹, until one row is left.
        for c in std::iter::once(2 * n + 1).chain(0..n) {
            if count < 2 {
                break;
            }
            let least =
                self.tied[..count].iter().fold(f64::INFINITY, |least, &r| least.min(ratio(&self.tableau, r, c)));
            let limit = least + TIE * least.abs().max(1.0);
            let mut kept = 0;
            for t in 0..count {
                let r = self.tied[t];
                if ratio(&self.tableau, r, c) <= limit {
                    self.tied[kept] = r;
                    kept += 1;
                }
            }
            count = kept;
            if c == 2 * n + 1
                && let Some(&r) = self.tied[..count].iter().find(|&&r| self.basis[r] == 2 * n)
            {
                return Some(r);
            }
        }
        (count > 0).then(|| self.tied[0])
    }

    /// Makes `column` basic in row `r`.
    fn pivot(&mut self, n: usize, r: usize, column: usize) {
        let width = 2 * n + 2;
        let (above, rest) = self.tableau[..n * width].split_at_mut(r * width);
        let (row, below) = rest.split_at_mut(width);
        let inverse = 1.0 / row[column];
        row.iter_mut().for_each(|entry| *entry *= inverse);
        row[column] = 1.0;
        for other in above.chunks_exact_mut(width).chain(below.chunks_exact_mut(width)) {
            let factor = other[column];
            if factor != 0.0 {
                for (entry, pivot) in other.iter_mut().zip(&*row) {
                    *entry -= factor * pivot;
                }
                other[column] = 0.0;
                // The right-hand side of a basis is nonnegative: what is below zero is rounding.
                let rhs = &mut other[width - 1];
                *rhs = rhs.max(0.0);
            }
        }
        self.basis[r] = column;
    }

    /// Writes the impulses of the final basis: from the tableau, or solved afresh from `M` and `q` if that is better.
    fn write(&mut self, lcp: Lcp<'_>, q_max: f64, z: &mut [f64]) {
        let (n, width) = (lcp.size(), 2 * lcp.size() + 2);
        self.factor.clear(n);
        let mut len = 0;
        for r in 0..n {
            let Some(i) = self.basis[r].checked_sub(n).filter(|&i| i < n) else { continue };
            z[i] = self.scale[i] * q_max * self.tableau[r * width + width - 1];
            let d = self.factor.border(lcp.m, &self.tied[..len], i);
            if d > PIVOT * lcp.m[i * n + i] {
                self.factor.push(d);
                self.tied[len] = i;
                len += 1;
            }
        }
        let set = &self.tied[..len];
        let fresh = &mut self.tableau[..n];
        fresh.fill(0.0);
        for (x, &i) in fresh.iter_mut().zip(set) {
            *x = -lcp.q[i];
        }
        self.factor.solve(&mut fresh[..len]);
        let afresh = &mut self.afresh[..n];
        afresh.fill(0.0);
        for (x, &i) in fresh.iter().zip(set) {
            afresh[i] = x.max(0.0);
        }
        if natural_residual(lcp, afresh) < natural_residual(lcp, z) {
            z.copy_from_slice(afresh);
        }
    }
}

impl ComplementaritySolver for Lemke {
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let n = lcp.size();
        z.fill(0.0);
        if lcp.is_solved_by_zero()? {
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        let (q_max, width) = (self.start(lcp), 2 * n + 2);
        // The lexicographically least row: of equal right-hand sides the last.
        let rhs = |tableau: &[f64], r: usize| tableau[r * width + width - 1];
        let mut row = (0..n).fold(0, |least, r| {
            let smaller = rhs(&self.tableau, r) <= rhs(&self.tableau, least);
            if smaller { r } else { least }
        });
        let (mut column, mut stats) = (2 * n, SolveStats::default());
        // Exponentially many pivots exist on purpose-built matrices (Fathi, Murty); small ones are seen through.
        let bound = 50 * n as u32 + (1 << n.min(12));
        loop {
            let left = self.basis[row];
            self.pivot(n, row, column);
            stats.pivots += 1;
            if left == 2 * n {
                break;
            }
            column = if left < n { left + n } else { left - n };
            match self.leaving_row(n, column) {
                Some(r) if stats.pivots < bound => row = r,
                // A ray from where rounding kept z₀ from leaving is a solution; the residual decides.
                _ if (0..n).all(|r| self.basis[r] != 2 * n || rhs(&self.tableau, r) < VANISHED) => break,
                _ => return Err(Unsolved::NotFound { residual: f64::INFINITY }),
            }
        }
        self.write(lcp, q_max, z);
        stats.factorisations = 1;
        Ok(stats)
    }

    fn capacity(&self) -> usize {
        self.capacity
    }

    fn boxed_clone(&self) -> Box<dyn ComplementaritySolver> {
        Box::new(self.clone())
    }
}
