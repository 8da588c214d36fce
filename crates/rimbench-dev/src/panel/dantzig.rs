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
//! gives up what it has (and pays `n |C|` per pivot for watching it), and it has no warm start.
//!
//! What a dependent contact does, and what rounding makes of it, stands in `dependence`.
//!
//! # Source
//! Cottle, Dantzig, *Complementary pivot theory of mathematical programming*, Linear Algebra Appl. 1 (1968); Baraff, *Fast
//! contact force computation for nonpenetrating rigid bodies*, SIGGRAPH 1994.

mod dependence;

use rimbench_core::complementarity::{ComplementaritySolver, Lcp, SolveStats, Unsolved};
use rimbench_core::linear_algebra::{Buffer, Factor, dot};

/// A violation below this part of `‖q‖_∞` is none.
const NEGLIGIBLE: f64 = 1e-13;
/// Components of a direction below this part of the driven contact's own do not move.
const NO_MOTION: f64 = 1e-12;

/// Dantzig and Cottle's principal pivoting. See the module.
///
/// Guaranteed for symmetric positive definite `M`; for semidefinite `M` with a solution unless degenerate pivots cycle, as they
/// do in the two largest problems of others (`docs/results/solvers.md`).
/// Free of allocation up to `capacity`.
#[derive(Debug, Clone)]
pub struct Dantzig {
    capacity: usize,
    set: Buffer<usize, 8>,
    len: usize,
    inside: Buffer<bool, 8>,
    factor: Factor,
    w: Buffer<f64, 8>,
    /// `√M_ii`.
    root: Buffer<f64, 8>,
    /// `M_CC⁻¹ M_Cj` of the driven contact, and of the one bordered last.
    p: Buffer<f64, 8>,
    bordering: Buffer<f64, 8>,
    /// The contact bordered last.
    bordered: usize,
    /// Rates of `w`.
    s: Buffer<f64, 8>,
}

/// What ends a step of a drive.
#[derive(Clone, Copy)]
enum Event {
    /// The driven contact has reached `w = 0`.
    Arrived,
    /// The member at this position has reached `z = 0`.
    Leaves(usize),
    /// This contact, with this pivot, has reached `w = 0`.
    Enters(usize, f64),
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
            root: Buffer::new(capacity),
            p: Buffer::new(capacity),
            bordering: Buffer::new(capacity),
            bordered: 0,
            s: Buffer::new(capacity),
        }
    }

    fn start(&mut self, lcp: Lcp<'_>) {
        let n = lcp.q.len();
        self.capacity = self.capacity.max(n);
        self.set.grow(n);
        self.inside.grow(n);
        for vector in [&mut self.w, &mut self.root, &mut self.p, &mut self.bordering, &mut self.s] {
            vector.grow(n);
        }
        for (k, root) in self.root[..n].iter_mut().enumerate() {
            *root = lcp.m[k * n + k].max(0.0).sqrt();
        }
        self.inside.fill(false);
        self.factor.clear(n);
        self.len = 0;
    }

    fn enter(&mut self, m: &[f64], j: usize, pivot: f64) {
        if self.bordered != j {
            self.border(m, j);
        }
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

    /// Borders contact `j` and makes it the one that is driven.
    fn turn_to(&mut self, m: &[f64], j: usize) -> f64 {
        let d = self.border(m, j);
        self.p[..self.len].copy_from_slice(&self.bordering[..self.len]);
        d
    }

    /// Drives contact `j`, all before it being complementary; false if nothing blocks or the pivots run out.
    fn drive(&mut self, lcp: Lcp<'_>, j: usize, z: &mut [f64], pivots: &mut u32, bound: u32) -> bool {
        loop {
            let d = self.turn_to(lcp.m, j);
            if d == 0.0 && self.stands_still(lcp, j, z) {
                self.w[j] = 0.0;
                self.take_back(lcp.m, j, z, pivots);
                return true;
            }
            let Some((t, event)) = self.next_event(lcp.m, j, d, z) else { return false };
            if *pivots >= bound {
                return false;
            }
            *pivots += 1;
            for (&k, p) in self.set[..self.len].iter().zip(&self.p[..]) {
                z[k] = (z[k] - t * p).max(0.0);
            }
            for k in 0..j {
                if !self.inside[k] {
                    self.w[k] = (self.w[k] + t * self.s[k]).max(0.0);
                }
            }
            z[j] += t;
            self.w[j] += t * d;
            match event {
                Event::Arrived => {
                    self.w[j] = 0.0;
                    self.enter(lcp.m, j, d);
                    return true;
                }
                Event::Leaves(position) => {
                    let k = self.set[position];
                    (z[k], self.w[k]) = (0.0, 0.0);
                    self.leave(position);
                }
                Event::Enters(k, pivot) => {
                    self.w[k] = 0.0;
                    self.enter(lcp.m, k, pivot);
                }
            }
        }
    }

    /// How far `z_j` can grow, and what happens then; writes the rates of `w`.
    fn next_event(&mut self, m: &[f64], j: usize, d: f64, z: &[f64]) -> Option<(f64, Event)> {
        let (n, len) = (z.len(), self.len);
        let (mut t, mut event) = (f64::INFINITY, None);
        if d > 0.0 {
            (t, event) = (-self.w[j] / d, Some(Event::Arrived));
        }
        for (position, (&k, &p)) in self.set[..len].iter().zip(&self.p[..]).enumerate() {
            // Compared as velocities: p z-units of k against the one of j.
            if p * self.root[k] > NO_MOTION * self.root[j] && z[k] < t * p {
                (t, event) = (z[k] / p, Some(Event::Leaves(position)));
            }
        }
        self.s[..j].fill(0.0);
        if d == 0.0 {
            return event.map(|event| (t, event));
        }
        for k in (0..j).filter(|&k| !self.inside[k]) {
            let coupling: f64 = self.set[..len].iter().zip(&self.p[..]).map(|(&a, p)| m[k * n + a] * p).sum();
            self.s[k] = m[j * n + k] - coupling;
        }
        loop {
            let (mut first, mut entrant) = (t, None);
            for k in (0..j).filter(|&k| !self.inside[k]) {
                let s = self.s[k];
                if s < -NO_MOTION * self.root[k] * self.root[j] && self.w[k] < -first * s {
                    (first, entrant) = (-self.w[k] / s, Some(k));
                }
            }
            let Some(k) = entrant else { return event.map(|event| (t, event)) };
            let pivot = self.border(m, k);
            if pivot > 0.0 {
                return Some((first, Event::Enters(k, pivot)));
            }
            // It depends on C: what it seems to move is rounding.
            self.s[k] = 0.0;
        }
    }
}

impl ComplementaritySolver for Dantzig {
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let n = lcp.size();
        z.fill(0.0);
        if lcp.is_solved_by_zero()? {
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        self.start(lcp);
        let negligible = NEGLIGIBLE * lcp.q.iter().fold(0.0_f64, |max, q| max.max(q.abs()));
        let (mut stats, bound) =
            (SolveStats { factorisations: 1, ..SolveStats::default() }, 50 * n as u32 + (1 << n.min(12)));
        for j in 0..n {
            self.w[j] = dot(&lcp.m[j * n..(j + 1) * n], z) + lcp.q[j];
            if self.w[j] >= -negligible {
                self.w[j] = self.w[j].max(0.0);
            } else if !self.drive(lcp, j, z, &mut stats.pivots, bound) {
                return Err(Unsolved::NotFound { residual: f64::INFINITY });
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
