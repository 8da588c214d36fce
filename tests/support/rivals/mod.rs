//! Solvers that the default is held against, in tests and benches: an interior point, Gauss–Seidel, and the enumeration
//! of all active sets as the oracle. Lemke's method is in the library.

mod clarabel;
#[path = "../../../examples/custom_solver.rs"]
mod custom_solver;
mod enumeration;
mod relaxed_cones;

#[allow(unused_imports)] // Benches have no use for it.
pub use enumeration::ENUMERATION_LIMIT;
pub use relaxed_cones::relaxed_cones;

use rimbench::complementarity::Solver;
use rimbench::solver_entry::SolverEntry;
use std::sync::Arc;

/// Every rival; their answers are accepted as those of the default are, and all but the oracle have its fallback.
pub fn rivals() -> [SolverEntry; 3] {
    let rival = |name: &'static str, guaranteed: &'static str| SolverEntry {
        name: name.into(),
        guaranteed: guaranteed.into(),
        with_friction: false,
        ..SolverEntry::active_set()
    };
    [
        custom_solver::entry(),
        SolverEntry {
            tolerance: 1e-7,
            build: Arc::new(|_| Solver::other(clarabel::Clarabel::default())),
            ..rival("clarabel", "semidefinite, some impulses open every contact (none clamped without play)")
        },
        SolverEntry {
            fallback: false,
            build: Arc::new(|_| Solver::other(enumeration::Enumeration::default())),
            ..rival("enumeration", "semidefinite, feasible, n ≤ 12")
        },
    ]
}
