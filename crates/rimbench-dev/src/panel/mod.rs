//! The panel of rival solvers: what `active-set` is held against. A program adds them to its catalogue.
//!
//! To add one: a file with the algorithm, and an entry in [`solvers`]; the tests run over the list.

mod clarabel;
mod enumeration;
mod newton_fischer_burmeister;
mod projected_gauss_seidel;

pub use clarabel::Clarabel;
pub use enumeration::{ENUMERATION_LIMIT, Enumeration};
pub use newton_fischer_burmeister::NewtonFischerBurmeister;
pub use projected_gauss_seidel::{ProjectedGaussSeidel, Sweeps};

use rimbench_core::complementarity::Solver;
use rimbench_core::solver_entry::SolverEntry;
use std::sync::Arc;

/// Sweeps of Gauss–Seidel where their number is fixed, and where it is bounded.
const FIXED_SWEEPS: u32 = 50;
const MOST_SWEEPS: u32 = 10_000;

/// Every rival, in the order of tables.
pub fn solvers() -> Vec<SolverEntry> {
    vec![
        rival(
            "pgs",
            "projected Gauss–Seidel from the last impulses, to a residual of 1e-10 or 10000 sweeps",
            "symmetric positive semidefinite with positive diagonal, feasible; as fast as it is well-conditioned",
            |capacity| Solver::other(ProjectedGaussSeidel::new(capacity, Sweeps::UntilSolved { most: MOST_SWEEPS })),
        ),
        rival(
            "pgs-50",
            "projected Gauss–Seidel from the last impulses, 50 sweeps whatever comes out, as in real-time engines",
            "none: a fixed number of sweeps is an approximation",
            |capacity| Solver::other(ProjectedGaussSeidel::new(capacity, Sweeps::Fixed(FIXED_SWEEPS))),
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
        build_with_friction: None,
        ..SolverEntry::active_set()
    }
}
