//! The panel of rival solvers: what `active-set` is held against. A program adds them to its catalogue.
//!
//! To add one: a file with the algorithm, and an entry in [`solvers`]; the tests run over the list.

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
use std::sync::Arc;

/// Sweeps of the relaxation methods where their number is fixed, and where it is bounded.
const FIXED_SWEEPS: u32 = 50;
const MOST_SWEEPS: u32 = 10_000;
/// Relaxation factor: half way between Gauss–Seidel and the end of convergence. Not tuned.
const RELAXATION: f64 = 1.5;

/// Every rival, in the order of tables.
pub fn solvers() -> Vec<SolverEntry> {
    vec![
        rival(
            "active-set-cold",
            "active-set from no contact at every problem: what the warm start is worth is the difference",
            "symmetric positive semidefinite, feasible",
            |capacity| Solver::other(ActiveSetCold::new(capacity)),
        ),
        rival(
            "dantzig",
            "principal pivoting of Dantzig and Cottle, one contact after the other; no warm start",
            "symmetric positive semidefinite, feasible, unless degenerate pivots cycle",
            |capacity| Solver::other(Dantzig::new(capacity)),
        ),
        rival(
            "pgs",
            "projected Gauss–Seidel from the last impulses, to a residual of 1e-10 or 10000 sweeps",
            "symmetric positive semidefinite with positive diagonal, feasible; as fast as it is well-conditioned",
            |capacity| Solver::other(ProjectedSor::new(capacity, 1.0, Sweeps::UntilSolved { most: MOST_SWEEPS })),
        ),
        rival(
            "pgs-50",
            "projected Gauss–Seidel from the last impulses, 50 sweeps whatever comes out, as in real-time engines",
            "none: a fixed number of sweeps is an approximation",
            |capacity| Solver::other(ProjectedSor::new(capacity, 1.0, Sweeps::Fixed(FIXED_SWEEPS))),
        ),
        rival(
            "psor",
            "projected over-relaxation (factor 1.5) from the last impulses, to a residual of 1e-10 or 10000 sweeps",
            "symmetric positive semidefinite with positive diagonal, feasible; as fast as it is well-conditioned",
            |capacity| {
                Solver::other(ProjectedSor::new(capacity, RELAXATION, Sweeps::UntilSolved { most: MOST_SWEEPS }))
            },
        ),
        rival(
            "psor-50",
            "projected over-relaxation (factor 1.5) from the last impulses, 50 sweeps whatever comes out",
            "none: a fixed number of sweeps is an approximation",
            |capacity| Solver::other(ProjectedSor::new(capacity, RELAXATION, Sweeps::Fixed(FIXED_SWEEPS))),
        ),
        rival(
            "newton-minimum-map",
            "damped semismooth Newton on min(M_ii z, w) from the last impulses",
            "none globally; local at nondegenerate solutions with regular M_AA",
            |capacity| Solver::other(NewtonMinimumMap::new(capacity)),
        ),
        rival(
            "newton-fischer-burmeister",
            "semismooth Newton on the Fischer–Burmeister function with line search, from the last impulses",
            "symmetric positive definite",
            |capacity| Solver::other(NewtonFischerBurmeister::new(capacity)),
        ),
        SolverEntry {
            tolerance: 1e-7,
            ..rival(
                "clarabel",
                "interior point on the equivalent quadratic program, unpolished; allocates at every problem",
                "symmetric positive semidefinite, some impulses open every contact (none clamped without play)",
                |_| Solver::other(Clarabel::new()),
            )
        },
        SolverEntry {
            tolerance: 1e-7,
            ..rival(
                "clarabel-velocity",
                "interior point on the velocity form (least constraint), unpolished; allocates at every problem",
                "symmetric positive semidefinite, some impulses open every contact (none clamped without play)",
                |_| Solver::other(ClarabelVelocity::new()),
            )
        },
        SolverEntry {
            fallback: false,
            ..rival(
                "enumeration",
                "all 2^n active sets with pseudo-inverses, best residual; the oracle of the tests",
                "symmetric positive semidefinite, feasible, n ≤ 12",
                |_| Solver::other(Enumeration::new()),
            )
        },
    ]
}

/// A solver whose answers are accepted as those of the default are, and which has its fallback.
fn rival(
    name: &'static str,
    about: &'static str,
    guaranteed: &'static str,
    build: impl Fn(usize) -> Solver + Send + Sync + 'static,
) -> SolverEntry {
    SolverEntry {
        name: name.into(),
        about: about.into(),
        guaranteed: guaranteed.into(),
        build: Arc::new(build),
        witness: None,
        ..SolverEntry::active_set()
    }
}
