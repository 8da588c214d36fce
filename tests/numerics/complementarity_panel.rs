//! The bare solvers, without the fallback: what each is guaranteed to solve it must solve, and where it is known to fail it
//! must be seen to fail, by the natural residual and not by its own word.

use crate::support::{solver_by_name, solvers};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rimbench::complementarity::{ComplementaritySolver, Lcp, SolveStats, natural_residual};

/// `M = Bᵀ B + shift`, `B` rank×n, and a `q` that makes the problem solvable.
fn random(rng: &mut Pcg64, n: usize, rank: usize, shift: f64) -> (Vec<f64>, Vec<f64>) {
    let mut draw = |len: usize| (0..len).map(|_| rng.random_range(-1.0..1.0)).collect::<Vec<f64>>();
    let (b, c, slack) = (draw(rank * n), draw(rank), draw(n));
    let inner = |i: usize, j: usize| (0..rank).map(|r| b[r * n + i] * b[r * n + j]).sum::<f64>();
    let m = (0..n * n).map(|k| inner(k / n, k % n) + if k % (n + 1) == 0 { shift } else { 0.0 }).collect();
    let q = (0..n).map(|i| (0..rank).map(|r| b[r * n + i] * c[r]).sum::<f64>() + slack[i].max(0.0)).collect();
    (m, q)
}

/// A row of `n` contacts, each sharing a body with its neighbours: `tridiag(−1, 2, −1)`.
fn row_of_discs(n: usize) -> Vec<f64> {
    let coupling = |i: usize, j: usize| [2.0, -1.0, 0.0][i.abs_diff(j).min(2)];
    (0..n * n).map(|k| coupling(k / n, k % n)).collect()
}

/// The stats with the residual recomputed, infinite if the solver gave up; and whether it is within its tolerance.
fn attempt(name: &str, m: &[f64], q: &[f64]) -> (SolveStats, bool) {
    let entry = solver_by_name(name);
    let lcp = Lcp::new(m, q);
    let mut z = vec![f64::NAN; q.len()];
    let mut stats = match (entry.build)(q.len()).attempt(lcp, &mut z) {
        Ok(stats) => stats,
        Err(_) => SolveStats { residual: f64::INFINITY, ..SolveStats::default() },
    };
    if stats.residual == 0.0 {
        stats.residual = natural_residual(lcp, &z);
    }
    (stats, stats.residual <= entry.tolerance)
}

/// How many of 300 problems each solver solves: `[solver][regular, redundant]`.
fn solved_of_300() -> Vec<(&'static str, [usize; 2])> {
    let mut rng = Pcg64::seed_from_u64(61);
    let mut solved: Vec<_> = solvers().iter().map(|entry| (&*entry.name, [0; 2])).collect();
    for k in 0..300 {
        let n = 2 + k % 7;
        // At least a tenth of the diagonal is added, so that condition numbers stay below some hundred.
        let problems = [random(&mut rng, n, n, 0.3), random(&mut rng, n, n.div_ceil(2), 0.0)];
        for (kind, (m, q)) in problems.iter().enumerate() {
            for (name, counts) in &mut solved {
                counts[kind] += usize::from(attempt(name, m, q).1);
            }
        }
    }
    solved
}

#[test]
fn each_solver_keeps_what_its_class_promises() {
    let solved = solved_of_300();
    println!("regular, redundant: {solved:?}");
    for (name, [regular, redundant]) in solved {
        match name {
            // Guaranteed for every semidefinite problem with a solution.
            "active-set" | "lemke" | "enumeration" => assert_eq!((regular, redundant), (300, 300), "{name}"),
            // Convergent for both, and well-conditioned where regular.
            "pgs" => assert!(regular == 300 && redundant > 200, "{name}: {regular}, {redundant}"),
            "newton-fischer-burmeister" => assert_eq!(regular, 300, "{name}"),
            // Guaranteed unless a body is clamped without play, which is so for fewer than a tenth of the redundant ones.
            "clarabel" => assert!(regular == 300 && redundant >= 270, "{name}: {regular}, {redundant}"),
            // No guarantee.
            "pgs-50" => assert!(redundant < 300, "{name}: {redundant}"),
            _ => panic!("say here what `{name}` promises"),
        }
    }
}

/// The convergence factor of Gauss–Seidel on a row of n is cos²(π/(n+1)): 0.991 for 32, 0.9977 for 64. To 1e-10 that is
/// some 2500 and 9900 sweeps; fifty are nowhere near.
#[test]
fn fifty_sweeps_are_no_solution_of_a_long_row() {
    for n in [32, 64] {
        let (stats, solved) = attempt("pgs-50", &row_of_discs(n), &vec![-1.0; n]);
        assert!(!solved && stats.residual > 1e-4, "n = {n}: {stats:?}");
    }
    assert!(attempt("pgs", &row_of_discs(32), &[-1.0; 32]).1, "it gets there in the end");
}

/// A body of 1 kg on the ground under one of a million: M = [1, −1; −1, 1 + 1e-6], factor 1/(1 + 1e-6) per sweep, so
/// that ten thousand sweeps gain one per cent. Pivoting does not notice.
#[test]
fn relaxation_fails_under_a_heavy_body_and_pivoting_does_not() {
    let (m, q) = ([1.0, -1.0, -1.0, 1.0 + 1e-6], [-0.5, -1.0]);
    for name in ["pgs", "pgs-50"] {
        assert!(!attempt(name, &m, &q).1, "{name}");
    }
    for name in ["active-set", "lemke", "enumeration"] {
        assert!(attempt(name, &m, &q).1, "{name}");
    }
}

/// A body without play between two walls, `M = b bᵀ`, `q = b c`: pushed against one it reaches both at once, and each contact
/// depends on the other. Which of them seems to be first is decided by rounding, and must not matter.
#[test]
fn contacts_that_close_at_once_are_solved_whichever_is_first() {
    for (k, l) in (1..=30).flat_map(|k| (1..=30).map(move |l| (k, l))) {
        let (b, c) = ([f64::from(k) / 10.0, -f64::from(l) / 7.0], 0.3);
        let m = [b[0] * b[0], b[0] * b[1], b[1] * b[0], b[1] * b[1]];
        for c in [c, -c] {
            for name in ["active-set", "lemke", "enumeration"] {
                let (stats, solved) = attempt(name, &m, &b.map(|b| b * c));
                assert!(solved, "{name} {k} {l} {c}: {stats:?}");
            }
        }
    }
}

/// A body between two walls without play, and on the ground: no velocity opens both walls and the impulses on them are
/// unbounded, so an interior point has no central path to follow. It is lost on some of these; pivoting is not.
#[test]
fn a_body_clamped_without_play_may_defeat_an_interior_point() {
    let dot = |a: &[f64; 2], b: &[f64; 2]| a[0] * b[0] + a[1] * b[1];
    let mut failures = 0;
    for (k, l) in (1..=9).flat_map(|k| (1..=9).map(move |l| (k, l))) {
        let wall = [f64::from(k) / 10.0, f64::from(l) / 7.0];
        let contacts = [wall, wall.map(|b| -0.3 * b), [0.0, 0.7]];
        let m: Vec<f64> = (0..9).map(|entry| dot(&contacts[entry / 3], &contacts[entry % 3])).collect();
        let q = contacts.map(|contact| dot(&contact, &[2.0 / 3.0, -0.4]));
        for name in ["active-set", "lemke", "enumeration"] {
            assert!(attempt(name, &m, &q).1, "{name} {k} {l}");
        }
        failures += usize::from(!attempt("clarabel", &m, &q).1);
    }
    assert!((1..81).contains(&failures), "{failures} of 81");
}

/// The heavy body again, a million times heavier: `M = [1, −1; −1, 1 + 1e-12]`. The impulses are some 1e12, where doubles are
/// 2⁻¹² apart, so that none of them has `z₁ − z₂` within 4e-5 of 0.3.
#[test]
fn impulses_too_large_for_double_precision_are_found_by_no_solver() {
    let (m, q) = ([1.0, -1.0, -1.0, 1.0 + 1e-12], [-0.3, -1.0]);
    for entry in solvers() {
        let (stats, solved) = attempt(&entry.name, &m, &q);
        assert!(!solved && stats.residual > 4e-5, "{} {stats:?}", entry.name);
    }
}

#[test]
fn coincident_contacts_share_the_impulse() {
    for entry in solvers() {
        assert!(attempt(&entry.name, &[1.0; 4], &[-1.0; 2]).1, "{}", entry.name);
    }
}

#[test]
fn a_problem_without_a_solution_is_never_passed_off_as_solved() {
    let cases: [(&[f64], &[f64]); 3] = [
        (&[1.0, -1.0, -1.0, 1.0], &[-1.0, 0.0]),
        (&[0.0], &[-1.0]),
        (&[2.0, 0.0, 0.0, 0.0, 3.0, -3.0, 0.0, -3.0, 3.0], &[-1.0, -2.0, 1.0]),
    ];
    for (m, q) in cases {
        for entry in solvers() {
            let (stats, solved) = attempt(&entry.name, m, q);
            assert!(!solved && stats.residual > 0.1, "{} {stats:?}", entry.name);
        }
    }
}

/// Iterative solvers that start from the last impulses must need less the second time, and the same when reset.
#[test]
fn warm_starts_save_iterations_and_reset_forgets() {
    let (m, q) = (row_of_discs(12), vec![-1.0; 12]);
    for name in ["active-set", "pgs", "newton-fischer-burmeister"] {
        let mut solver = (solver_by_name(name).build)(12);
        let mut z = vec![0.0; 12];
        let mut pivots = || {
            let lcp = Lcp::new(&m, &q);
            solver.attempt(lcp, &mut z).unwrap().pivots
        };
        let (first, second) = (pivots(), pivots());
        assert!(second < first, "{name}: {first}, then {second}");
        solver.reset();
        assert_eq!(solver.attempt(Lcp::new(&m, &q), &mut z).unwrap().pivots, first, "{name}");
    }
}
