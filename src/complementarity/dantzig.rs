//! The principal pivoting method of Dantzig and Cottle: one contact after the other, none already treated gets worse.
//!
//! Contacts are treated in the order of their numbers. Where `w_j < 0` the impulse `z_j` grows until `w_j = 0`, while all
//! contacts treated before keep `w ≥ 0`, `z ≥ 0` and their complementarity:
//!
//! ```text
//! drive j:   z_C(t) = z_C − t p,   w_N(t) = w_N + t (M_Nj − M_NC p),   w_j(t) = w_j + t d       p = M_CC⁻¹ M_Cj
//! until      w_j = 0: j enters C    or    z_k = 0: k leaves C    or    w_k = 0, k treated: k enters C
//! ```
//! It is the method of Baraff's contact solver and of the engines after it. It differs from `active-set` in that it never
//! gives up what it has (and pays `n |C|` per pivot for watching it), and it has no warm start. A contact that depends on
//! `C` has `d = 0` and is driven along a ray until something blocks.
//!
//! # Source
//! Cottle, Dantzig, *Complementary pivot theory of mathematical programming*, Linear Algebra Appl. 1 (1968); Baraff, *Fast
//! contact force computation for nonpenetrating rigid bodies*, SIGGRAPH 1994.

use super::buffer::Buffer;
use super::dot::dot;
use super::factor::Factor;
use super::{ComplementaritySolver, Lcp, SolveStats};
use crate::error::Failure;

/// A row is dependent if its pivot is below this part of its diagonal; as in `active-set`.
const DEPENDENT: f64 = 1e-11;
/// A violation below this part of `‖q‖_∞` is none.
const NEGLIGIBLE: f64 = 1e-13;
/// Components of a direction below this part of the driven contact's own do not move.
const NO_MOTION: f64 = 1e-12;

/// Dantzig and Cottle's principal pivoting. See the module.
///
/// Guaranteed for symmetric positive definite `M`; in exact arithmetic for semidefinite `M` with a solution unless degenerate
/// pivots cycle. Against rounding it is not: 4 of 300 random redundant problems end with a dependent contact that seems to
/// move.
/// Free of allocation up to `capacity`.
#[derive(Debug, Clone)]
pub struct Dantzig {
    capacity: usize,
    set: Buffer<usize, 8>,
    len: usize,
    inside: Buffer<bool, 8>,
    factor: Factor,
    w: Buffer<f64, 8>,
    p: Buffer<f64, 8>,
    /// Rates of `w` and of `z_C`.
    s: Buffer<f64, 8>,
}

/// What ends a step of a drive.
#[derive(Clone, Copy)]
enum Event {
    /// The driven contact has reached `w = 0`.
    Arrived,
    /// The member at this position has reached `z = 0`.
    Leaves(usize),
    /// This contact has reached `w = 0`.
    Enters(usize),
}

impl Dantzig {
    /// Reserves room for problems up to `capacity` contacts; up to 8 need no heap.
    pub fn new(capacity: usize) -> Self {
        Dantzig {
            capacity: capacity.max(8),
            set: Buffer::new(capacity),
            len: 0,
            inside: Buffer::new(capacity),
            factor: Factor::new(capacity),
            w: Buffer::new(capacity),
            p: Buffer::new(capacity),
            s: Buffer::new(capacity),
        }
    }

    fn start(&mut self, n: usize) {
        self.capacity = self.capacity.max(n);
        self.set.grow(n);
        self.inside.grow(n);
        for vector in [&mut self.w, &mut self.p, &mut self.s] {
            vector.grow(n);
        }
        self.inside.fill(false);
        self.factor.clear(n);
        self.len = 0;
    }

    fn enter(&mut self, j: usize, pivot: f64) {
        self.factor.push(pivot);
        self.set[self.len] = j;
        self.inside[j] = true;
        self.len += 1;
    }

    fn leave(&mut self, position: usize) {
        self.factor.remove(position);
        self.inside[self.set[position]] = false;
        self.set.copy_within(position + 1..self.len, position);
        self.len -= 1;
    }

    /// Drives contact `j`, all before it being complementary; false if nothing blocks or the pivots run out.
    fn drive(&mut self, lcp: Lcp<'_>, j: usize, z: &mut [f64], pivots: &mut u32, bound: u32) -> bool {
        let n = z.len();
        loop {
            let (len, row) = (self.len, &lcp.m[j * n..(j + 1) * n]);
            let d = self.factor.border(lcp.m, &self.set[..len], j);
            self.factor.direction(&mut self.p[..len]);
            let (mut t, mut event) = (f64::INFINITY, None);
            if d > DEPENDENT * row[j] {
                (t, event) = (-self.w[j] / d, Some(Event::Arrived));
            }
            for (position, (&k, &p)) in self.set[..len].iter().zip(&self.p[..]).enumerate() {
                // Compared as velocities: p z-units of k against the one of j.
                let moves = p > 0.0 && p * p * lcp.m[k * n + k] > NO_MOTION * NO_MOTION * row[j];
                if moves && z[k] < t * p {
                    (t, event) = (z[k] / p, Some(Event::Leaves(position)));
                }
            }
            for k in 0..j {
                if self.inside[k] {
                    continue;
                }
                let coupling: f64 = self.set[..len].iter().zip(&self.p[..]).map(|(&a, p)| lcp.m[k * n + a] * p).sum();
                self.s[k] = row[k] - coupling;
                let moves = self.s[k] < -NO_MOTION * (lcp.m[k * n + k] * row[j]).sqrt();
                if moves && self.w[k] < -t * self.s[k] {
                    (t, event) = (-self.w[k] / self.s[k], Some(Event::Enters(k)));
                }
            }
            let Some(event) = event else { return false };
            if *pivots >= bound {
                return false;
            }
            *pivots += 1;
            for (&k, p) in self.set[..len].iter().zip(&self.p[..]) {
                z[k] = (z[k] - t * p).max(0.0);
            }
            for k in 0..j {
                if !self.inside[k] {
                    self.w[k] = (self.w[k] + t * self.s[k]).max(0.0);
                }
            }
            z[j] += t;
            self.w[j] += t * d.max(0.0);
            match event {
                Event::Arrived => {
                    self.w[j] = 0.0;
                    self.enter(j, d);
                    return true;
                }
                Event::Leaves(position) => {
                    let k = self.set[position];
                    (z[k], self.w[k]) = (0.0, 0.0);
                    self.leave(position);
                }
                Event::Enters(k) => {
                    self.w[k] = 0.0;
                    let pivot = self.factor.border(lcp.m, &self.set[..len], k);
                    // In exact arithmetic a contact that depends on C does not move; by rounding it may seem to.
                    if pivot <= DEPENDENT * lcp.m[k * n + k] {
                        return false;
                    }
                    self.enter(k, pivot);
                }
            }
        }
    }
}

impl ComplementaritySolver for Dantzig {
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Failure> {
        let n = lcp.size();
        z.fill(0.0);
        if lcp.is_solved_by_zero()? {
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        self.start(n);
        let negligible = NEGLIGIBLE * lcp.q.iter().fold(0.0_f64, |max, q| max.max(q.abs()));
        let (mut stats, bound) =
            (SolveStats { factorisations: 1, ..SolveStats::default() }, 50 * n as u32 + (1 << n.min(12)));
        for j in 0..n {
            self.w[j] = dot(&lcp.m[j * n..(j + 1) * n], z) + lcp.q[j];
            if self.w[j] >= -negligible {
                self.w[j] = self.w[j].max(0.0);
            } else if !self.drive(lcp, j, z, &mut stats.pivots, bound) {
                return Err(Failure::SolverFailed { residual: f64::INFINITY });
            }
        }
        // The impulses of the final set, computed once more from M and q.
        let p = &mut self.p[..self.len];
        for (p, &k) in p.iter_mut().zip(&self.set[..]) {
            *p = -lcp.q[k];
        }
        self.factor.solve(p);
        for (&k, p) in self.set[..self.len].iter().zip(&self.p[..]) {
            z[k] = p.max(0.0);
        }
        Ok(stats)
    }

    fn capacity(&self) -> usize {
        self.capacity
    }

    fn boxed_clone(&self) -> Box<dyn ComplementaritySolver> {
        Box::new(self.clone())
    }
}
