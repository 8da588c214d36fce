//! The projected Gauss–Seidel method of game engines.
//!
//! ```text
//! for i = 1 … n:   P_i ← max(0, P_i − (H P + b)_i / H_ii)            one sweep, always with the newest P
//! ```
//! Every sweep lowers the objective `½ Pᵀ H P + bᵀ P`, and the iterates converge for every symmetric positive semidefinite
//! `H` with positive diagonal if there is a solution: linearly, with a factor that approaches 1 as contacts become nearly
//! dependent or bodies unequal in mass. A fixed number of sweeps is therefore fast and predictable, and no solution where
//! it matters: a long pile, a heavy body on a light one.
//!
//! It starts from the impulses of the last problem. A row with `H_ii = 0` keeps `P_i = 0`.
//!
//! # Source
//! Cryer, *The solution of a quadratic programming problem using systematic overrelaxation*, SIAM J. Control 9 (1971);
//! convergence for semidefinite `H`: Luo, Tseng, *On the convergence of a matrix splitting algorithm for the symmetric
//! monotone linear complementarity problem*, SIAM J. Control Optim. 29 (1991).

use rimbench_core::complementarity::{ComplementaritySolver, Lcp, SolveStats, Unsolved};
use rimbench_core::linear_algebra::{Buffer, dot};

/// Residual at which [`Sweeps::UntilSolved`] stops, a tenth of what is accepted.
const ENOUGH: f64 = 1e-10;
/// The residual is measured after this many sweeps each; it costs as much as one.
const BETWEEN_CHECKS: u32 = 10;

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sweeps {
    /// After so many, whatever came out: what real-time engines do.
    Fixed(u32),
    /// At a natural residual of 1e-10, or after so many.
    UntilSolved {
        /// Bound of the number of sweeps.
        most: u32,
    },
}

/// Projected Gauss–Seidel. See the module.
///
/// Converges for symmetric positive semidefinite `H` with positive diagonal when a solution exists; not within any bound
/// of sweeps that depends on `n` alone. Free of allocation up to `capacity`.
#[derive(Debug, Clone)]
pub struct ProjectedGaussSeidel {
    sweeps: Sweeps,
    /// Size of the last problem.
    n: usize,
    capacity: usize,
    last: Buffer<f64, 8>,
}

impl ProjectedGaussSeidel {
    /// Reserves room for problems up to `capacity` contacts.
    pub fn new(capacity: usize, sweeps: Sweeps) -> Self {
        ProjectedGaussSeidel { sweeps, n: 0, capacity: capacity.max(8), last: Buffer::new(capacity) }
    }

    fn sweep(&self, lcp: Lcp<'_>, impulses: &mut [f64]) {
        let n = impulses.len();
        for i in 0..n {
            let row = &lcp.h()[i * n..(i + 1) * n];
            if row[i] > 0.0 {
                impulses[i] = (impulses[i] - (dot(row, impulses) + lcp.b[i]) / row[i]).max(0.0);
            }
        }
    }
}

impl ComplementaritySolver for ProjectedGaussSeidel {
    fn attempt(&mut self, lcp: Lcp<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let n = lcp.size();
        if lcp.is_solved_by_zero()? {
            impulses.fill(0.0);
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        if n != self.n {
            self.capacity = self.capacity.max(n);
            self.last.grow(n);
            self.n = n;
            self.reset();
        }
        impulses.copy_from_slice(&self.last[..n]);
        let most = match self.sweeps {
            Sweeps::Fixed(count) | Sweeps::UntilSolved { most: count } => count,
        };
        let mut stats = SolveStats::default();
        while stats.pivots < most {
            self.sweep(lcp, impulses);
            stats.pivots += 1;
            let check = self.sweeps != Sweeps::Fixed(most) && stats.pivots.is_multiple_of(BETWEEN_CHECKS);
            if check && lcp.natural_residual(impulses) <= ENOUGH {
                break;
            }
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
