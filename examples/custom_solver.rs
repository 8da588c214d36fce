//! A solver of contact problems from outside, on the problems with known answers:
//! `cargo run --release --example custom_solver`. `cargo bench -p rimbench-benches --bench solvers` times it beside the
//! default, Lemke's method and Clarabel.

use rimbench::complementarity::{ComplementaritySolver, Lcp, SolveStats, Solver, Unsolved};
use rimbench::known_problems::known_problems;
use rimbench::solver_entry::SolverEntry;
use std::sync::Arc;

/// Projected Gauss–Seidel from the last impulses: `P_i ← max(0, P_i − (H P + b)_i / H_ii)`, to a residual of 1e-10 or
/// 10 000 sweeps.
#[derive(Clone)]
struct ProjectedGaussSeidel {
    last: Vec<f64>,
    size: usize,
}

impl ComplementaritySolver for ProjectedGaussSeidel {
    fn attempt(&mut self, lcp: Lcp<'_>, p: &mut [f64]) -> Result<SolveStats, Unsolved> {
        if lcp.is_solved_by_zero()? {
            p.fill(0.0);
            return Ok(SolveStats::default());
        }
        lcp.require_finite_matrix()?;
        let n = lcp.size();
        if self.size != n {
            self.last.resize(self.last.len().max(n), 0.0); // allocates beyond the capacity only
            self.last.fill(0.0);
            self.size = n;
        }
        p.copy_from_slice(&self.last[..n]);
        let mut stats = SolveStats::default();
        while stats.pivots < 10_000 && (stats.pivots % 10 > 0 || lcp.natural_residual(p) > 1e-10) {
            for (i, row) in lcp.h().chunks_exact(n).enumerate().filter(|(i, row)| row[*i] > 0.0) {
                let w = lcp.b[i] + row.iter().zip(&*p).map(|(h, p)| h * p).sum::<f64>();
                p[i] = (p[i] - w / row[i]).max(0.0);
            }
            stats.pivots += 1;
        }
        self.last[..n].copy_from_slice(p);
        if p.iter().any(|p| !p.is_finite()) {
            self.reset();
        }
        Ok(stats)
    }
    fn reset(&mut self) {
        self.last.fill(0.0);
    }
    fn capacity(&self) -> usize {
        self.last.len()
    }
}

/// The solver as a catalogue takes it, with Lemke's method where its answer is not accurate enough.
pub fn entry() -> SolverEntry {
    SolverEntry {
        name: "gauss-seidel".into(),
        about: "projected Gauss–Seidel from the last impulses, to a residual of 1e-10 or 10000 sweeps".into(),
        guaranteed:
            "symmetric positive semidefinite with positive diagonal, feasible; as fast as it is well-conditioned".into(),
        tolerance: 1e-9,
        fallback: true,
        digest: None,
        build: Arc::new(|capacity| Solver::other(ProjectedGaussSeidel { last: vec![0.0; capacity.max(8)], size: 0 })),
        with_friction: false,
    }
}

fn main() -> Result<(), Unsolved> {
    let mut solver = entry().checked(32);
    for problem in known_problems() {
        let mut impulses = vec![0.0; problem.b.len()];
        solver.reset();
        let stats = solver.solve(Lcp::new(&problem.h, &problem.b), &mut impulses)?;
        println!("{}: {} sweeps, residual {:.0e}", problem.name, stats.pivots, stats.residual);
    }
    let counters = solver.counters();
    println!("{} problems, {} of them by Lemke's method", counters.solves, counters.fallbacks);
    Ok(())
}
