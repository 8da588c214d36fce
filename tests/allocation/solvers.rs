//! The pivoting solvers must not allocate once built: they run inside the micro step of a real-time simulation.

use crate::asked;
use crate::support::*;
use rimbench::complementarity::{ComplementaritySolver, Lcp};
use rimbench::friction::space::{SpaceProblem, SpaceSolver};

/// Those that state a capacity; that they are all is checked below.
const ALLOCATION_FREE: [&str; 3] = ["active-set", "lemke", "gauss-seidel"];

/// `M = Bᵀ B` of rank 3 with changing `B` and `q`.
fn problem(n: usize, step: usize, m: &mut [f64], q: &mut [f64]) {
    let b = |r: usize, i: usize| ((1 + r) as f64 * (i as f64 + 0.37) + 0.1 * step as f64).sin();
    for i in 0..n {
        for j in 0..n {
            m[i * n + j] = (0..3).map(|r| b(r, i) * b(r, j)).sum();
        }
        q[i] = (0..3).map(|r| b(r, i) * ((step + r) as f64).cos()).sum();
    }
}

fn allocations_of_solving(name: &str, built_for: usize, sizes: &[usize]) -> u64 {
    let mut solver = solver_by_name(name).checked(built_for);
    let largest = sizes.iter().copied().max().unwrap();
    let (mut m, mut q, mut z) = (vec![0.0; largest * largest], vec![0.0; largest], vec![0.0; largest]);
    let before = asked();
    for step in 0..40 {
        for &n in sizes {
            problem(n, step, &mut m[..n * n], &mut q[..n]);
            solver.solve(Lcp::new(&m[..n * n], &q[..n]), &mut z[..n]).unwrap();
        }
    }
    assert!(solver.counters().pivots > 0 && solver.solver.capacity() >= largest);
    asked() - before
}

#[test]
fn pivoting_solvers_do_not_allocate_up_to_their_capacity() {
    for name in ALLOCATION_FREE {
        assert_eq!(allocations_of_solving(name, 0, &[1, 4, 8]), 0, "{name} inline");
        assert_eq!(allocations_of_solving(name, 80, &[4, 40, 17, 80]), 0, "{name} on the heap");
    }
}

#[test]
fn a_larger_problem_grows_the_workspace_once() {
    for name in ALLOCATION_FREE {
        let grown = allocations_of_solving(name, 0, &[20]);
        // Twelve buffers in the largest solver, eleven in the fallback; 40 problems are solved.
        assert!(grown > 0 && grown <= 23, "{name}: {grown} allocations");
    }
}

/// Redundant feet in space on the border of their cones; asked for more than rounding allows, sweeps and ADMM take all
/// of their turns too.
#[test]
fn contacts_in_space_do_not_allocate_up_to_the_number_they_were_made_for() {
    let n = 8;
    let angle = |k: usize| 0.8 * k as f64 + 0.1;
    let row = |row: usize| {
        let (x, y) = (0.5 * angle(row % n).cos(), 0.5 * angle(row % n).sin());
        [[0.0, 0.0, 1.0, y, -x, 0.0], [1.0, 0.0, 0.0, 0.0, -0.4, -y], [0.0, 1.0, 0.0, 0.4, 0.0, x]][row / n]
    };
    let h: Vec<f64> =
        (0..9 * n * n).map(|k| row(k / (3 * n)).iter().zip(row(k % (3 * n))).map(|(a, b)| a * b).sum()).collect();
    let friction = vec![0.3; n];
    let (mut solver, mut vain) = (SpaceSolver::new(n, 1e-9), SpaceSolver::new(n, 1e-30));
    let (mut p, mut b) = (vec![0.0; 3 * n], vec![0.0; 3 * n]);
    let before = asked();
    for step in 0..60 {
        solver.reset();
        for foot in 0..n {
            let load = 0.1 + (1.0 + (foot * step) as f64).sin().abs();
            (p[foot], p[n + foot], p[2 * n + foot]) =
                (load, 0.3 * load * (step as f64).cos(), 0.3 * load * (step as f64).sin());
        }
        for (b, h) in b.iter_mut().zip(h.chunks(3 * n)) {
            *b = -h.iter().zip(&p).map(|(h, p)| h * p).sum::<f64>();
        }
        let problem = SpaceProblem::with_friction(&h, &b, &friction);
        solver.solve(problem, &mut p).unwrap();
        if step < 3 {
            assert!(vain.solve(problem, &mut p).is_err());
        }
    }
    assert_eq!((solver.counters().failures, vain.counters().fallbacks), (0, 3));
    assert_eq!(asked() - before, 0);
}

#[test]
fn a_solver_that_states_a_capacity_is_in_the_list_and_the_others_are_not() {
    for entry in solvers() {
        let stated = (entry.build)(4).capacity() >= 4;
        assert_eq!(stated, ALLOCATION_FREE.contains(&&*entry.name), "{}", entry.name);
    }
}
