//! Damped semismooth Newton method on the minimum map.
//!
//! ```text
//! H_i(z) = min(M_ii z_i, w_i) = 0                A = {i : w_i < M_ii z_i}
//! step to    z_A = −M_AA⁻¹ q_A,   z = 0 elsewhere             as far as ½‖H‖² decreases enough
//! ```
//! Where full steps are taken this is the primal–dual active set method: it changes many contacts at once and ends
//! exactly. Its weakness is ours: with redundant contacts `M_AA` is singular as soon as too many are in `A`, and the method
//! has no answer. Nor need the step be a descent direction at a kink of `H`, where the line search then ends the attempt.
//!
//! # Source
//! Pang, *Newton's method for B-differentiable equations*, Math. Oper. Res. 15 (1990); Hintermüller, Ito, Kunisch, *The
//! primal–dual active set strategy as a semismooth Newton method*, SIAM J. Optim. 13 (2002).

use rimbench_core::complementarity::{ComplementaritySolver, Lcp, SolveStats, Unsolved};
use rimbench_core::linear_algebra::{Buffer, Factor, dot};

/// A row is dependent if its pivot is below this part of its diagonal; as in `active-set`.
const DEPENDENT: f64 = 1e-11;
/// Residual at which the iteration stops.
const ENOUGH: f64 = 1e-13;
/// Armijo's fraction of the predicted decrease, and the number of halvings before the attempt ends.
const DECREASE: f64 = 1e-4;
const HALVINGS: u32 = 30;
const ITERATIONS: u32 = 100;

/// Newton's method on the minimum map. See the module.
///
/// Locally convergent for nondegenerate solutions with regular `M_AA`; for no class of singular matrices. Starts from the
/// impulses of the last problem. Free of allocation up to `capacity`.
#[derive(Debug, Clone)]
pub struct NewtonMinimumMap {
    n: usize,
    capacity: usize,
    last: Buffer<f64, 8>,
    w: Buffer<f64, 8>,
    target: Buffer<f64, 8>,
    trial: Buffer<f64, 8>,
    set: Buffer<usize, 8>,
    factor: Factor,
}

impl NewtonMinimumMap {
    /// Reserves room for problems up to `capacity` contacts; up to 8 need no heap.
    pub fn new(capacity: usize) -> Self {
        let vector = || Buffer::new(capacity);
        NewtonMinimumMap {
            n: 0,
            capacity: capacity.max(8),
            last: vector(),
            w: vector(),
            target: vector(),
            trial: vector(),
            set: Buffer::new(capacity),
            factor: Factor::new(capacity),
        }
    }

    fn resize(&mut self, n: usize) {
        self.n = n;
        self.capacity = self.capacity.max(n);
        for vector in [&mut self.last, &mut self.w, &mut self.target, &mut self.trial] {
            vector.grow(n);
        }
        self.set.grow(n);
        self.reset();
    }

    /// Writes the Newton point to `target`; none if `M_AA` is singular.
    fn newton_point(&mut self, lcp: Lcp<'_>, z: &[f64]) -> Option<()> {
        let n = z.len();
        self.factor.clear(n);
        let mut len = 0;
        for (i, z_i) in z.iter().enumerate() {
            if self.w[i] < weight(lcp, i) * z_i {
                let pivot = self.factor.border(lcp.m, &self.set[..len], i);
                if pivot <= DEPENDENT * lcp.m[i * n + i] {
                    return None;
                }
                self.factor.push(pivot);
                self.set[len] = i;
                len += 1;
            }
        }
        let (solution, target) = (&mut self.trial[..len], &mut self.target[..n]);
        for (x, &i) in solution.iter_mut().zip(&self.set[..]) {
            *x = -lcp.q[i];
        }
        self.factor.solve(solution);
        target.fill(0.0);
        for (x, &i) in solution.iter().zip(&self.set[..]) {
            target[i] = *x;
        }
        Some(())
    }

    /// Goes towards the Newton point as far as the merit function allows; none if it does not.
    fn line_search(&mut self, lcp: Lcp<'_>, z: &mut [f64], merit: f64) -> Option<[f64; 2]> {
        let n = z.len();
        let mut length = 1.0;
        for _ in 0..HALVINGS {
            for (trial, (z, target)) in self.trial.iter_mut().zip(z.iter().zip(&self.target[..])) {
                // The whole step without rounding: members outside A become exactly zero.
                *trial = if length == 1.0 { *target } else { z + length * (target - z) };
            }
            let [reached, residual] = minimum_map(lcp, &self.trial[..n], &mut self.w[..n]);
            if reached <= (1.0 - 2.0 * DECREASE * length) * merit {
                z.copy_from_slice(&self.trial[..n]);
                return Some([reached, residual]);
            }
            length *= 0.5;
        }
        None
    }
}

/// What makes a velocity of an impulse, as in the natural residual.
fn weight(lcp: Lcp<'_>, i: usize) -> f64 {
    let m_ii = lcp.m[i * lcp.q.len() + i];
    if m_ii > 0.0 { m_ii } else { 1.0 }
}

/// Fills `w` and returns `‖H‖²` and `‖H‖_∞`.
fn minimum_map(lcp: Lcp<'_>, z: &[f64], w: &mut [f64]) -> [f64; 2] {
    let n = z.len();
    let (mut sum, mut largest) = (0.0, 0.0_f64);
    for i in 0..n {
        w[i] = dot(&lcp.m[i * n..(i + 1) * n], z) + lcp.q[i];
        let h = (weight(lcp, i) * z[i]).min(w[i]);
        sum += h * h;
        largest = largest.max(h.abs());
    }
    [sum, largest]
}

impl ComplementaritySolver for NewtonMinimumMap {
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let n = lcp.size();
        if lcp.is_solved_by_zero()? {
            z.fill(0.0);
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        if n != self.n {
            self.resize(n);
        }
        z.copy_from_slice(&self.last[..n]);
        let enough = ENOUGH * lcp.q.iter().fold(0.0_f64, |max, q| max.max(q.abs()));
        let [mut merit, mut residual] = minimum_map(lcp, z, &mut self.w[..n]);
        let mut stats = SolveStats::default();
        while residual > enough && stats.pivots < ITERATIONS {
            stats.pivots += 1;
            stats.factorisations += 1;
            let step = self.newton_point(lcp, z).and_then(|()| self.line_search(lcp, z, merit));
            match step {
                Some([reached, largest]) => (merit, residual) = (reached, largest),
                // At round-off nothing decreases any more: the residual decides.
                None => {
                    self.reset();
                    return Ok(stats);
                }
            }
        }
        z.iter_mut().for_each(|z| *z = z.max(0.0));
        self.last[..n].copy_from_slice(z);
        Ok(stats)
    }

    fn reset(&mut self) {
        self.last.fill(0.0);
    }

    fn capacity(&self) -> usize {
        self.capacity
    }

    fn boxed_clone(&self) -> Box<dyn ComplementaritySolver> {
        Box::new(self.clone())
    }
}
