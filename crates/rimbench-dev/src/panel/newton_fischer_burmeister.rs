//! Semismooth Newton method on the Fischer–Burmeister function, globalised by a line search.
//!
//! The problem is scaled to unit diagonal and unit `b` and written as a system of equations,
//!
//! ```text
//! Φ_i(x) = φ(x_i, w_i) = 0            φ(a, b) = a + b − √(a² + b²),  zero iff a ≥ 0, b ≥ 0, a b = 0
//! J = D_a + D_b M                     D_a = 1 − x/√(x² + w²),  D_b = 1 − w/√(x² + w²);  1 − 1/√2 where x = w = 0
//! J d = −Φ                            steps t = 1, ½, ¼ … until Ψ = ½‖Φ‖² decreases;  d = −Jᵀ Φ where Newton's is no descent
//! ```
//! For positive semidefinite `H` every stationary point of Ψ is a solution, and near a solution with regular `H_AA` the
//! convergence is quadratic. With redundant contacts `J` becomes singular at the solution and the convergence, if there is
//! any, slow: a failure this harness counts. Contacts without inertia (`H_ii = 0`) are taken with weight one.
//!
//! # Source
//! De Luca, Facchinei, Kanzow, *A semismooth equation approach to the solution of nonlinear complementarity problems*,
//! Math. Programming 75 (1996); Fischer, *A special Newton-type optimization method*, Optimization 24 (1992).

use rimbench_core::complementarity::{ComplementaritySolver, Lcp, SolveStats, Unsolved};
use rimbench_core::linear_algebra::{Buffer, Lu, dot};

/// Residual (of the scaled problem) at which the iteration stops.
const ENOUGH: f64 = 1e-13;
/// Armijo's fraction, and the number of halvings before the attempt ends.
const DECREASE: f64 = 1e-4;
const HALVINGS: u32 = 40;
/// Newton's direction is taken if `∇Ψ·d ≤ −ρ ‖d‖^2.1`; the constants are those of the source.
const DESCENT: f64 = 1e-8;
const DESCENT_POWER: f64 = 2.1;
const ITERATIONS: u32 = 200;

/// Newton's method on the Fischer–Burmeister function. See the module.
///
/// Guaranteed for symmetric positive definite `H`; for semidefinite `H` only where the solution is unique and
/// nondegenerate. Starts from the impulses of the last problem. Free of allocation up to `capacity`.
#[derive(Debug, Clone)]
pub struct NewtonFischerBurmeister {
    n: usize,
    capacity: usize,
    last: Buffer<f64, 8>,
    scale: Buffer<f64, 8>,
    /// Scaled matrix and right-hand side.
    h: Buffer<f64, 64>,
    b: Buffer<f64, 8>,
    x: Buffer<f64, 8>,
    w: Buffer<f64, 8>,
    phi: Buffer<f64, 8>,
    jacobian: Buffer<f64, 64>,
    gradient: Buffer<f64, 8>,
    direction: Buffer<f64, 8>,
    trial: Buffer<f64, 8>,
    lu: Lu,
}

impl NewtonFischerBurmeister {
    /// Reserves room for problems up to `capacity` contacts; up to 8 need no heap.
    pub fn new(capacity: usize) -> Self {
        let vector = || Buffer::new(capacity);
        let matrix = || Buffer::new(capacity * capacity);
        NewtonFischerBurmeister {
            n: 0,
            capacity: capacity.max(8),
            last: vector(),
            scale: vector(),
            h: matrix(),
            b: vector(),
            x: vector(),
            w: vector(),
            phi: vector(),
            jacobian: matrix(),
            gradient: vector(),
            direction: vector(),
            trial: vector(),
            lu: Lu::new(capacity),
        }
    }

    fn resize(&mut self, n: usize) {
        self.n = n;
        self.capacity = self.capacity.max(n);
        let vectors = [
            &mut self.last,
            &mut self.scale,
            &mut self.b,
            &mut self.x,
            &mut self.w,
            &mut self.phi,
            &mut self.gradient,
            &mut self.direction,
            &mut self.trial,
        ];
        vectors.into_iter().for_each(|vector| vector.grow(n));
        [&mut self.h, &mut self.jacobian].into_iter().for_each(|matrix| matrix.grow(n * n));
        self.lu.grow(n);
        self.reset();
    }

    /// Scales the problem and returns the factor taken out of `b`.
    fn start(&mut self, lcp: Lcp<'_>) -> f64 {
        let n = self.n;
        for i in 0..n {
            let m_ii = lcp.h()[i * n + i];
            self.scale[i] = if m_ii > 0.0 { m_ii.sqrt().recip() } else { 1.0 };
        }
        let b_max = (0..n).fold(f64::MIN_POSITIVE, |max, i| max.max((self.scale[i] * lcp.b[i]).abs()));
        for i in 0..n {
            self.b[i] = self.scale[i] * lcp.b[i] / b_max;
            for j in 0..n {
                self.h[i * n + j] = self.scale[i] * lcp.h()[i * n + j] * self.scale[j];
            }
            self.x[i] = self.last[i] / (self.scale[i] * b_max);
        }
        b_max
    }

    /// Fills `w` and `phi` at a point; returns `‖Φ‖²`.
    fn evaluate(&mut self, at_trial: bool) -> f64 {
        let n = self.n;
        let x = if at_trial { &self.trial[..n] } else { &self.x[..n] };
        let mut sum = 0.0;
        for i in 0..n {
            let w = dot(&self.h[i * n..(i + 1) * n], x) + self.b[i];
            self.w[i] = w;
            self.phi[i] = fischer_burmeister(x[i], w);
            sum += self.phi[i] * self.phi[i];
        }
        sum
    }

    /// Largest `|min(x_i, w_i)|`.
    fn residual(&self) -> f64 {
        self.x[..self.n].iter().zip(&self.w[..]).fold(0.0_f64, |max, (x, w)| max.max(x.min(*w).abs()))
    }

    /// Fills `gradient` and `direction`; returns `∇Ψ·d`.
    fn choose_direction(&mut self) -> f64 {
        let n = self.n;
        self.gradient[..n].fill(0.0);
        for i in 0..n {
            let (x, w) = (self.x[i], self.w[i]);
            let norm = x.hypot(w);
            let kink = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
            let (d_a, d_b) = if norm > 0.0 { (1.0 - x / norm, 1.0 - w / norm) } else { (kink, kink) };
            for j in 0..n {
                self.jacobian[i * n + j] = d_b * self.h[i * n + j];
            }
            self.jacobian[i * n + i] += d_a;
            for j in 0..n {
                self.gradient[j] += self.jacobian[i * n + j] * self.phi[i];
            }
            self.direction[i] = -self.phi[i];
        }
        let (jacobian, direction) = (&mut self.jacobian[..n * n], &mut self.direction[..n]);
        let regular = self.lu.solve(jacobian, direction);
        let slope = dot(&self.gradient[..n], direction);
        let length = dot(direction, direction).sqrt();
        if regular && slope <= -DESCENT * length.powf(DESCENT_POWER) {
            return slope;
        }
        for (d, g) in direction.iter_mut().zip(&self.gradient[..]) {
            *d = -g;
        }
        -dot(&self.gradient[..n], &self.gradient[..n])
    }

    /// Goes along the direction as far as Ψ allows; false if it does not.
    fn line_search(&mut self, merit: &mut f64, slope: f64) -> bool {
        let n = self.n;
        let mut length = 1.0;
        for _ in 0..HALVINGS {
            for (trial, (x, d)) in self.trial[..n].iter_mut().zip(self.x.iter().zip(&self.direction[..])) {
                *trial = x + length * d;
            }
            let reached = self.evaluate(true);
            // ½‖Φ‖² on both sides.
            if 0.5 * reached <= 0.5 * *merit + DECREASE * length * slope {
                self.x[..n].copy_from_slice(&self.trial[..n]);
                *merit = reached;
                return true;
            }
            length *= 0.5;
        }
        false
    }
}

/// `a + b − √(a² + b²)`, without cancellation where both are positive.
fn fischer_burmeister(a: f64, b: f64) -> f64 {
    let norm = a.hypot(b);
    if a + b > 0.0 { 2.0 * a * b / (a + b + norm) } else { a + b - norm }
}

impl ComplementaritySolver for NewtonFischerBurmeister {
    fn attempt(&mut self, lcp: Lcp<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let n = lcp.size();
        impulses.fill(0.0);
        if lcp.is_solved_by_zero()? {
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        if n != self.n {
            self.resize(n);
        }
        let b_max = self.start(lcp);
        let mut merit = self.evaluate(false);
        let mut stats = SolveStats::default();
        while self.residual() > ENOUGH && stats.pivots < ITERATIONS {
            stats.pivots += 1;
            stats.factorisations += 1;
            let slope = self.choose_direction();
            if !self.line_search(&mut merit, slope) {
                break;
            }
        }
        for (p, (x, scale)) in impulses.iter_mut().zip(self.x.iter().zip(&self.scale[..])) {
            *p = (scale * b_max * x).max(0.0);
        }
        if impulses.iter().all(|p| p.is_finite()) {
            self.last[..n].copy_from_slice(impulses);
        } else {
            self.reset();
        }
        Ok(stats)
    }

    fn reset(&mut self) {
        self.last.fill(0.0);
    }

    fn capacity(&self) -> usize {
        self.capacity
    }
}
