//! The panel of rival solvers: what `active-set` is held against, named in the program beside it.
//!
//! To add one: a file with the algorithm, and a line in [`SOLVERS`]; the tests run over the list.

mod active_set_cold;
mod clarabel;
mod clarabel_velocity;
mod dantzig;
mod enumeration;
mod newton_fischer_burmeister;
mod newton_minimum_map;
mod projected_sor;

pub use active_set_cold::ActiveSetCold;
pub use clarabel::Clarabel;
pub use clarabel_velocity::ClarabelVelocity;
pub use dantzig::Dantzig;
pub use enumeration::{ENUMERATION_LIMIT, Enumeration};
pub use newton_fischer_burmeister::NewtonFischerBurmeister;
pub use newton_minimum_map::NewtonMinimumMap;
pub use projected_sor::{ProjectedSor, Sweeps};

use rimbench_core::complementarity::{Solver, SolverEntry};

/// Sweeps of the relaxation methods where their number is fixed, and where it is bounded.
const FIXED_SWEEPS: u32 = 50;
const MOST_SWEEPS: u32 = 10_000;
/// Relaxation factor: half way between Gauss–Seidel and the end of convergence. Not tuned.
const RELAXATION: f64 = 1.5;

/// Every rival, in the order of tables.
pub const SOLVERS: &[SolverEntry] = &[
    SolverEntry {
        name: "active-set-cold",
        about: "active-set from no contact at every problem: what the warm start is worth is the difference",
        guaranteed: "symmetric positive semidefinite, feasible",
        tolerance: 1e-9,
        fallback: true,
        build: |capacity| Solver::other(ActiveSetCold::new(capacity)),
    },
    SolverEntry {
        name: "dantzig",
        about: "principal pivoting of Dantzig and Cottle, one contact after the other; no warm start",
        guaranteed: "symmetric positive semidefinite, feasible, unless degenerate pivots cycle",
        tolerance: 1e-9,
        fallback: true,
        build: |capacity| Solver::other(Dantzig::new(capacity)),
    },
    SolverEntry {
        name: "pgs",
        about: "projected Gauss–Seidel from the last impulses, to a residual of 1e-10 or 10000 sweeps",
        guaranteed: "symmetric positive semidefinite with positive diagonal, feasible; as fast as it is well-conditioned",
        tolerance: 1e-9,
        fallback: true,
        build: |capacity| Solver::other(ProjectedSor::new(capacity, 1.0, Sweeps::UntilSolved { most: MOST_SWEEPS })),
    },
    SolverEntry {
        name: "pgs-50",
        about: "projected Gauss–Seidel from the last impulses, 50 sweeps whatever comes out, as in real-time engines",
        guaranteed: "none: a fixed number of sweeps is an approximation",
        tolerance: 1e-9,
        fallback: true,
        build: |capacity| Solver::other(ProjectedSor::new(capacity, 1.0, Sweeps::Fixed(FIXED_SWEEPS))),
    },
    SolverEntry {
        name: "psor",
        about: "projected over-relaxation (factor 1.5) from the last impulses, to a residual of 1e-10 or 10000 sweeps",
        guaranteed: "symmetric positive semidefinite with positive diagonal, feasible; as fast as it is well-conditioned",
        tolerance: 1e-9,
        fallback: true,
        build: |capacity| {
            Solver::other(ProjectedSor::new(capacity, RELAXATION, Sweeps::UntilSolved { most: MOST_SWEEPS }))
        },
    },
    SolverEntry {
        name: "psor-50",
        about: "projected over-relaxation (factor 1.5) from the last impulses, 50 sweeps whatever comes out",
        guaranteed: "none: a fixed number of sweeps is an approximation",
        tolerance: 1e-9,
        fallback: true,
        build: |capacity| Solver::other(ProjectedSor::new(capacity, RELAXATION, Sweeps::Fixed(FIXED_SWEEPS))),
    },
    SolverEntry {
        name: "newton-minimum-map",
        about: "damped semismooth Newton on min(M_ii z, w) from the last impulses",
        guaranteed: "none globally; local at nondegenerate solutions with regular M_AA",
        tolerance: 1e-9,
        fallback: true,
        build: |capacity| Solver::other(NewtonMinimumMap::new(capacity)),
    },
    SolverEntry {
        name: "newton-fischer-burmeister",
        about: "semismooth Newton on the Fischer–Burmeister function with line search, from the last impulses",
        guaranteed: "symmetric positive definite",
        tolerance: 1e-9,
        fallback: true,
        build: |capacity| Solver::other(NewtonFischerBurmeister::new(capacity)),
    },
    SolverEntry {
        name: "clarabel",
        about: "interior point on the equivalent quadratic program, unpolished; allocates at every problem",
        guaranteed: "symmetric positive semidefinite, some impulses open every contact (none clamped without play)",
        tolerance: 1e-7,
        fallback: true,
        build: |_| Solver::other(Clarabel::new()),
    },
    SolverEntry {
        name: "clarabel-velocity",
        about: "interior point on the velocity form (least constraint), unpolished; allocates at every problem",
        guaranteed: "symmetric positive semidefinite, some impulses open every contact (none clamped without play)",
        tolerance: 1e-7,
        fallback: true,
        build: |_| Solver::other(ClarabelVelocity::new()),
    },
    SolverEntry {
        name: "enumeration",
        about: "all 2^n active sets with pseudo-inverses, best residual; the oracle of the tests",
        guaranteed: "symmetric positive semidefinite, feasible, n ≤ 12",
        tolerance: 1e-9,
        fallback: false,
        build: |_| Solver::other(Enumeration::new()),
    },
];

/// Makes the panel known by name, for as long as the program runs.
pub fn register() {
    rimbench_core::complementarity::register(SOLVERS);
}
