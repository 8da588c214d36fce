//! Symmetric principal pivoting from the last active set: the default solver.
//!
//! The problem is the optimality condition of `min ½ Pᵀ H P + bᵀ P`, `P ≥ 0`. Keller's method walks over active sets
//! `A` on which `P_A = −H_AA⁻¹ b_A ≥ 0`, and takes the violated contact in, the one that lowers the objective most:
//!
//! ```text
//! drive j:    P_j = t,  P_A(t) = P_A − t y,  w_j(t) = w_j + t d     H_AA y = H_Aj,  d = H_jj − H_jA y
//! complete:   t = −w_j / d          j enters A
//! blocked:    t = P_k / y_k         k leaves A and the drive goes on
//! ```
//! If row `j` depends on the rows in `A`, then `d = 0` and the drive follows a ray until it is blocked, after which `j`
//! is independent of what is left: a singular matrix is never factorised. A ray that nothing blocks proves that the
//! problem has no solution. Each completed drive strictly lowers the objective, so in exact arithmetic no active set
//! comes back, degenerate or not; against rounding the choice becomes the lowest index (Bland) after `10 + 5n` pivots,
//! and the pivots are bounded.
//!
//! In a simulation the next problem has almost always the active set of the last one: then the answer is one
//! factorisation of `H_AA` (with more than four members none if `H` has not changed) and one look at `w`.
//!
//! # Source
//! Keller, *The general quadratic optimization problem*, Math. Programming 5 (1973); Cottle, Pang, Stone, *The Linear
//! Complementarity Problem* (1992), section 4.2. The treatment of dependent rows by the ray is theirs; the warm start
//! is the usual one of active-set methods.

mod pivoting;
mod warm_start;

use super::{ComplementaritySolver, Lcp, SolveStats, Unsolved};
use crate::linear_algebra::{Buffer, Factor, SparseRows};
use warm_start::WarmStart;

/// A row is dependent if its pivot `d` is below this part of its diagonal: far above the rounding of `d` (about
/// 1e-15), far below what distinguishes two contacts.
pub(super) const DEPENDENT: f64 = 1e-11;
/// A violation below this part of `‖b‖_∞` is no reason to pivot; the accepted residual is 1e-9.
pub(super) const NEGLIGIBLE: f64 = 1e-13;
/// Pivots on one factor before it is computed anew although `H` has not changed.
pub(super) const REFRESH: u32 = 64;
/// A violation on an unblocked ray up to this part of `‖b‖_∞` is rounding, not a proof of infeasibility.
pub(super) const RAY_NOISE: f64 = 1e-10;
/// A component of the direction below this part (squared, scaled by the diagonals) does not block.
pub(super) const NO_MOTION: f64 = 1e-24;

/// Keller's method with warm start. See the module for the algorithm.
///
/// Guaranteed for symmetric positive semidefinite `H` when a solution exists. Free of allocation up to `capacity`.
#[derive(Debug, Clone)]
pub struct ActiveSet {
    /// Size of the last problem; the warm start is forgotten when it changes.
    n: usize,
    capacity: usize,
    /// The active set in the order of the factor.
    set: Buffer<usize, 8>,
    len: usize,
    is_active: Buffer<bool, 8>,
    factor: Factor,
    /// The matrix the factor belongs to.
    factored: Buffer<f64, 64>,
    /// True if that is also the matrix of the last problem, of which sometimes only `b` is looked at.
    seen: bool,
    /// The matrix without its zeros, read once it comes again.
    rows: SparseRows,
    rows_read: bool,
    /// Updates of the factor since it was computed; `None` if there is none to reuse.
    age: Option<u32>,
    p_a: Buffer<f64, 8>,
    /// `L⁻¹ (−b_A)`, and how many of its entries are known for this `b`.
    forward: Buffer<f64, 8>,
    forward_known: usize,
    y: Buffer<f64, 8>,
    w: Buffer<f64, 8>,
}

impl ActiveSet {
    /// Reserves room for problems up to `capacity` contacts; up to 8 need no heap.
    pub fn new(capacity: usize) -> Self {
        ActiveSet {
            n: 0,
            capacity: capacity.max(8),
            set: Buffer::new(capacity),
            len: 0,
            is_active: Buffer::new(capacity),
            factor: Factor::new(capacity),
            factored: Buffer::new(capacity * capacity),
            seen: false,
            rows: SparseRows::new(capacity),
            rows_read: false,
            age: None,
            p_a: Buffer::new(capacity),
            forward: Buffer::new(capacity),
            forward_known: 0,
            y: Buffer::new(capacity),
            w: Buffer::new(capacity),
        }
    }

    /// Returns the active set of the last problem, in the order in which the contacts entered.
    pub fn active_set(&self) -> &[usize] {
        &self.set[..self.len]
    }

    /// Computes the natural residual of an answer to a problem with the matrix of the one before: by its non-zeros,
    /// once they have been read.
    #[inline(always)]
    pub(super) fn residual_again(&self, lcp: Lcp<'_>, p: &[f64]) -> f64 {
        if self.seen && self.rows_read { residual_of_rows(lcp, &self.rows, p) } else { lcp.natural_residual(p) }
    }

    fn resize(&mut self, n: usize) {
        self.n = n;
        self.capacity = self.capacity.max(n);
        self.set.grow(n);
        self.is_active.grow(n);
        self.factored.grow(n * n);
        self.rows.reserve(n);
        self.p_a.grow(n);
        self.forward.grow(n);
        self.y.grow(n);
        self.w.grow(n);
        self.factor.clear(n);
        self.reset();
    }

    /// Factorises `H_AA` for the active set at hand, leaving out members that became dependent; false if the factor
    /// at hand is still that of `H`.
    #[inline]
    fn factorise(&mut self, h: &[f64], again: bool) -> bool {
        let factored = &mut self.factored[..h.len()];
        let same = again && self.seen || same_entries(factored, h);
        debug_assert!(!same || same_entries(factored, h), "the matrix is said to be that of the problem before");
        self.seen = true;
        if same && self.age.is_some_and(|age| age < REFRESH) {
            return false;
        }
        if !same {
            factored.copy_from_slice(h);
            self.rows_read = false;
        }
        self.factor.clear(self.n);
        let mut kept = 0;
        for position in 0..self.len {
            let j = self.set[position];
            let d = self.factor.border(h, &self.set[..kept], j);
            if d > DEPENDENT * h[j * self.n + j] {
                self.factor.push(d);
                self.set[kept] = j;
                kept += 1;
            } else {
                self.is_active[j] = false;
            }
        }
        self.len = kept;
        self.age = Some(0);
        true
    }

    fn write(&self, p: &mut [f64]) {
        // Zeros, but not by a library call; see `attempt`.
        p.iter_mut().zip(&self.w[..]).for_each(|(p, w)| *p = 0.0 * w.abs());
        for (&i, &p_i) in self.active_set().iter().zip(&self.p_a[..]) {
            p[i] = p_i;
        }
    }

    fn give_up(&mut self, p: &mut [f64]) -> Unsolved {
        self.write(p);
        self.reset();
        Unsolved::NotFound { residual: f64::INFINITY }
    }

    /// Makes an [`attempt`](ComplementaritySolver::attempt) at a problem whose `H` is, if it comes `again`, to the last
    /// bit that of the call before; only `b` may differ. The problems of one macro step share their matrix, and with
    /// many contacts finding that out takes longer than the solution (`benches/solvers.rs`, against size).
    #[inline(always)]
    pub(super) fn solve_from_last_set(
        &mut self,
        lcp: Lcp<'_>,
        again: bool,
        p: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let n = lcp.size();
        if n == self.n {
            match self.solve_few(lcp, p) {
                WarmStart::Zero => {
                    self.seen &= again;
                    return Ok(SolveStats::default());
                }
                WarmStart::Confirmed => {
                    self.seen &= again;
                    return Ok(SolveStats { factorisations: 1, ..SolveStats::default() });
                }
                WarmStart::Rejected => {}
            }
        }
        self.solve_any(Lcp::new(lcp.h(), lcp.b), p, again)
    }

    /// Apart from the usual case, which does not pay for its frame.
    #[inline(never)]
    fn solve_any(&mut self, lcp: Lcp<'_>, p: &mut [f64], again: bool) -> Result<SolveStats, Unsolved> {
        let n = lcp.size();
        if lcp.is_solved_by_zero()? {
            self.seen &= again;
            // Not `fill`: the library call it becomes costs 20 ns here, half of this path (`benches/solvers.rs`).
            p.iter_mut().zip(lcp.b).for_each(|(p, b)| *p = 0.0 * b);
            return Ok(SolveStats::default());
        }
        if n != self.n {
            self.resize(n);
        }
        let stats = SolveStats { factorisations: u32::from(self.factorise(lcp.h(), again)), ..SolveStats::default() };
        if again && !self.rows_read {
            self.rows.read(lcp.h(), n);
            self.rows_read = true;
        }
        self.pivot_to_solution(lcp, p, stats)
    }
}

/// Computes the natural residual of a problem whose matrix is the one that `rows` has read, by its non-zeros.
#[inline]
pub(super) fn residual_of_rows(lcp: Lcp<'_>, rows: &SparseRows, p: &[f64]) -> f64 {
    if !rows.holds() {
        return lcp.natural_residual(p);
    }
    lcp.residual_of(p, |i| rows.row(i).map(|(j, h_ij)| h_ij * p[j]).sum::<f64>() + lcp.b[i])
}

/// Blocks of the size of a cache line or more are compared at once, without an exit in between.
#[inline]
fn same_entries(a: &[f64], b: &[f64]) -> bool {
    let same = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(true, |same, (a, b)| same & (a == b));
    if a.len() <= 64 { same(a, b) } else { a.chunks(64).zip(b.chunks(64)).all(|(a, b)| same(a, b)) }
}

impl ComplementaritySolver for ActiveSet {
    #[inline(always)]
    fn attempt(&mut self, lcp: Lcp<'_>, p: &mut [f64]) -> Result<SolveStats, Unsolved> {
        self.solve_from_last_set(lcp, false, p)
    }

    fn reset(&mut self) {
        self.len = 0;
        self.is_active.fill(false);
        self.factor.clear(self.n);
        self.age = None;
        self.seen = false;
    }

    fn capacity(&self) -> usize {
        self.capacity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_that_rest_without_a_push_carry_nothing_whatever_they_carried_before() {
        for n in [1, 8, 9, 70] {
            let h: Vec<f64> = (0..n * n).map(|at| if at % (n + 1) == 0 { 2.0 } else { 0.0 }).collect();
            let mut solver = ActiveSet::new(n);
            for b in [0.0, -1.0, 0.0] {
                let mut p = vec![f64::NAN; n];
                solver.attempt(Lcp::new(&h, &vec![b; n]), &mut p).unwrap();
                assert!(p.iter().all(|p| *p == -0.5 * b), "{n} contacts: {p:?}");
            }
        }
    }
}
