//! Every solver in the list against known solutions, against enumeration, and against problems without a solution.
//!
//! With redundant contacts `z` is not unique, so what is compared is what is: `w` and the resultant `B z`.

use crate::support::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rimbench::complementarity::{ComplementaritySolver, Lcp, SolveStats, Unsolved};
use rimbench::known_problems::{KnownProblem, known_problems};
use rimbench::solver_entry::SolverEntry;
use std::path::Path;

/// A problem `M = Bᵀ B`, `q`, with `B` rank×n by rows.
#[derive(Debug, Clone)]
struct Contacts {
    n: usize,
    b: Vec<f64>,
    m: Vec<f64>,
    q: Vec<f64>,
}

impl Contacts {
    /// `q = Bᵀ c + slack`, `slack ≥ 0`: the optimality condition of `min ½‖B z + c‖² + slackᵀ z`, always solvable.
    fn solvable(n: usize, b: Vec<f64>, c: &[f64], slack: &[f64]) -> Self {
        let column = |i: usize| b.iter().skip(i).step_by(n);
        let inner = |i: usize, j: usize| column(i).zip(column(j)).map(|(x, y)| x * y).sum::<f64>();
        let m = (0..n * n).map(|k| inner(k / n, k % n)).collect();
        let q = (0..n).map(|i| column(i).zip(c).map(|(x, y)| x * y).sum::<f64>() + slack[i]).collect();
        Contacts { n, b, m, q }
    }

    fn random(rng: &mut Pcg64, n: usize, rank: usize) -> Self {
        let mut draw = |len: usize| (0..len).map(|_| rng.random_range(-1.0..1.0)).collect::<Vec<f64>>();
        let (b, c, slack) = (draw(rank * n), draw(rank), draw(n));
        Contacts::solvable(n, b, &c, &slack.iter().map(|s| s.max(0.0)).collect::<Vec<_>>())
    }

    fn lcp(&self) -> Lcp<'_> {
        Lcp::new(&self.m, &self.q)
    }

    fn w(&self, z: &[f64]) -> Vec<f64> {
        let row = |i: usize| &self.m[i * self.n..(i + 1) * self.n];
        (0..self.n).map(|i| row(i).iter().zip(z).map(|(m, z)| m * z).sum::<f64>() + self.q[i]).collect()
    }

    fn resultant(&self, z: &[f64]) -> Vec<f64> {
        self.b.chunks(self.n.max(1)).map(|row| row.iter().zip(z).map(|(b, z)| b * z).sum()).collect()
    }

    fn velocity_scale(&self) -> f64 {
        self.q.iter().fold(0.0, |max: f64, q| max.max(q.abs()))
    }
}

fn solve(entry: &SolverEntry, lcp: Lcp<'_>) -> Result<Vec<f64>, Unsolved> {
    let mut z = vec![f64::NAN; lcp.size()];
    let mut solver = entry.checked(lcp.size());
    let stats = solver.solve(lcp, &mut z)?;
    assert!(stats.residual <= entry.tolerance);
    assert_eq!(stats.residual, lcp.natural_residual(&z), "{}", entry.name);
    Ok(z)
}

fn assert_close(name: &str, what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= tolerance, "{name}: {what} {found:?}, expected {expected:?} ± {tolerance:e}");
    }
}

/// What an accepted residual still leaves open in `w`. Solvers that solve for `w = 0` directly leave round-off; the
/// others leave the residual, enlarged by the scales of the rows: an impulse that is wrong by `r/M_ii` at one contact
/// is a velocity `r √(M_jj/M_ii)` at another, and rows here are scaled up to 1:1e4. (An interior point that passed at
/// 1e-7 was seen with a velocity wrong by 7e-4 of ‖q‖, in one of 20 000 problems.) Twice that.
fn comparison_tolerance(entry: &SolverEntry) -> f64 {
    let stops_short = ["clarabel", "gauss-seidel"].contains(&&*entry.name);
    if stops_short { 2e4 * entry.tolerance } else { 1e-8 }
}

#[test]
fn problems_with_known_answers() {
    for KnownProblem { name, h: m, b: q, w: expected } in known_problems() {
        let n = q.len();
        for entry in solvers().iter().filter(|entry| entry.name != "enumeration" || n <= ENUMERATION_LIMIT) {
            let z = solve(entry, Lcp::new(&m, &q)).unwrap_or_else(|f| panic!("{} {name}: {f}", entry.name));
            let w: Vec<f64> = (0..n).map(|i| (0..n).map(|j| m[i * n + j] * z[j]).sum::<f64>() + q[i]).collect();
            assert_close(&entry.name, "w", &w, &expected, comparison_tolerance(entry));
        }
    }
}

#[test]
fn a_problem_without_solution_is_reported_with_its_residual() {
    // Two contacts that must both open but push each other shut; a contact nothing can open.
    let cases: [(&[f64], &[f64]); 3] = [
        (&[1.0, -1.0, -1.0, 1.0], &[-1.0, 0.0]),
        (&[0.0], &[-1.0]),
        (&[2.0, 0.0, 0.0, 0.0, 3.0, -3.0, 0.0, -3.0, 3.0], &[-1.0, -2.0, 1.0]),
    ];
    for (m, q) in cases {
        for entry in solvers() {
            let failure = solve(entry, Lcp::new(m, q)).unwrap_err();
            assert!(matches!(failure, Unsolved::NotFound { residual } if residual > 0.1), "{}", entry.name);
            // Nor does the bare one pass it off as solved.
            let (stats, solved) = attempt(&entry.name, m, q);
            assert!(!solved && stats.residual > 0.1, "{} {stats:?}", entry.name);
        }
    }
}

#[test]
fn no_contact_and_no_approach_need_no_impulse() {
    for entry in solvers() {
        assert_eq!(solve(entry, Lcp::new(&[], &[])), Ok(vec![]), "{}", entry.name);
        assert_eq!(solve(entry, Lcp::new(&[1.0, 1.0, 1.0, 1.0], &[0.0, 2.0])), Ok(vec![0.0, 0.0]));
    }
}

#[test]
fn input_that_is_not_finite_fails_and_leaves_the_solver_usable() {
    let good = Lcp::new(&[2.0, 1.0, 1.0, 2.0], &[-5.0, -6.0]);
    for entry in solvers() {
        let mut solver = entry.checked(2);
        let mut z = [0.0; 2];
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for m in [[bad, 1.0, 1.0, 2.0], [2.0, bad, bad, 2.0]] {
                assert!(solver.solve(Lcp::new(&m, &[-1.0, -1.0]), &mut z).is_err(), "{} {m:?}", entry.name);
                assert!(solver.solve(Lcp::new(&m, &[1.0, 1.0]), &mut z).is_err(), "{} {m:?}", entry.name);
            }
            assert!(solver.solve(Lcp::new(good.h(), &[bad, -1.0]), &mut z).is_err(), "{}", entry.name);
            assert!(solver.solve(Lcp::new(good.h(), &[bad, 1.0]), &mut z).is_err(), "{}", entry.name);
        }
        solver.solve(good, &mut z).unwrap();
        assert_close(&entry.name, "z", &z, &[4.0 / 3.0, 7.0 / 3.0], comparison_tolerance(entry));
    }
}

#[test]
fn enumeration_refuses_what_would_take_forever() {
    let n = ENUMERATION_LIMIT + 1;
    let mut enumeration = (solver_by_name("enumeration").build)(n);
    let (m, q) = (vec![1.0; n * n], vec![-1.0; n]);
    let lcp = Lcp::new(&m, &q);
    assert!(matches!(enumeration.attempt(lcp, &mut vec![0.0; n]), Err(Unsolved::TooLarge { .. })));
}

#[test]
fn the_same_sequence_gives_the_same_bits() {
    let run = |entry: &SolverEntry| {
        let mut rng = Pcg64::seed_from_u64(17);
        let mut solver = entry.checked(8);
        let mut trace = Vec::new();
        for k in 0..30 {
            let contacts = Contacts::random(&mut rng, 1 + k % 6, 2);
            let mut z = vec![0.0; contacts.n];
            let stats = solver.solve(contacts.lcp(), &mut z).unwrap();
            trace.push((stats, z.iter().map(|z| z.to_bits()).collect::<Vec<_>>()));
        }
        (trace, solver.counters())
    };
    for entry in solvers() {
        assert_eq!(run(entry), run(entry), "{}", entry.name);
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// The bare solvers, without the fallback: what each is guaranteed to solve it must solve, and where it is known to fail
// it must be seen to fail, by the natural residual and not by its own word.

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
        stats.residual = lcp.natural_residual(&z);
    }
    (stats, stats.residual <= entry.tolerance)
}

/// How many of 300 problems each solver solves: `[solver][regular, redundant]`.
fn solved_of_300() -> Vec<(&'static str, [usize; 2])> {
    let mut rng = Pcg64::seed_from_u64(61);
    let mut solved: Vec<_> = solvers().iter().map(|entry| (&*entry.name, [0; 2])).collect();
    for k in 0..300 {
        let n: usize = 2 + k % 7;
        // At least a tenth of the diagonal is added, so that condition numbers stay below some hundred.
        let [mut regular, redundant] = [n, n.div_ceil(2)].map(|rank| Contacts::random(&mut rng, n, rank));
        (0..n).for_each(|i| regular.m[i * (n + 1)] += 0.3);
        for (kind, problem) in [regular, redundant].iter().enumerate() {
            for (name, counts) in &mut solved {
                counts[kind] += usize::from(attempt(name, &problem.m, &problem.q).1);
            }
        }
    }
    solved
}

#[test]
fn each_solver_keeps_what_its_class_promises() {
    let solved = solved_of_300();
    for (name, [regular, redundant]) in solved {
        match name {
            // Guaranteed for every semidefinite problem with a solution.
            "active-set" | "lemke" | "enumeration" => assert_eq!((regular, redundant), (300, 300), "{name}"),
            // Convergent for both, and well-conditioned where regular.
            "gauss-seidel" => assert!(regular == 300 && redundant > 200, "{name}: {regular}, {redundant}"),
            // Guaranteed unless a body is clamped without play, which is so for fewer than a tenth of the redundant
            // ones.
            "clarabel" => assert!(regular == 300 && redundant >= 270, "{name}: {regular}, {redundant}"),
            _ => panic!("say here what `{name}` promises"),
        }
    }
}

/// A body of 1 kg on the ground under one of a million: M = [1, −1; −1, 1 + 1e-6], factor 1/(1 + 1e-6) per sweep, so
/// that ten thousand sweeps gain one per cent. Pivoting does not notice.
#[test]
fn relaxation_fails_under_a_heavy_body_and_pivoting_does_not() {
    let (m, q) = ([1.0, -1.0, -1.0, 1.0 + 1e-6], [-0.5, -1.0]);
    assert!(!attempt("gauss-seidel", &m, &q).1);
    for name in ["active-set", "lemke", "enumeration"] {
        assert!(attempt(name, &m, &q).1, "{name}");
    }
}

/// A body without play between two walls, `M = b bᵀ`, `q = b c`: pushed against one it reaches both at once, and each
/// contact depends on the other. Which of them seems to be first is decided by rounding, and must not matter.
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

/// The heavy body again, a million times heavier: `M = [1, −1; −1, 1 + 1e-12]`. The impulses are some 1e12, where
/// doubles are 2⁻¹² apart, so that none of them has `z₁ − z₂` within 4e-5 of 0.3.
#[test]
fn impulses_too_large_for_double_precision_are_found_by_no_solver() {
    let (m, q) = ([1.0, -1.0, -1.0, 1.0 + 1e-12], [-0.3, -1.0]);
    for entry in solvers() {
        let (stats, solved) = attempt(&entry.name, &m, &q);
        assert!(!solved && stats.residual > 4e-5, "{} {stats:?}", entry.name);
    }
}

/// Iterative solvers that start from the last impulses must need less the second time, and the same when reset.
#[test]
fn warm_starts_save_iterations_and_reset_forgets() {
    let (m, q) = (row_of_discs(12), vec![-1.0; 12]);
    for name in ["active-set", "gauss-seidel"] {
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

/// Rank-deficient problems on a coarse grid, so that ties, repeated contacts and `w = z = 0` are common.
fn redundant_contacts() -> impl Strategy<Value = Contacts> {
    let sizes = (1_usize..=6).prop_flat_map(|n| (Just(n), 1..=n.min(4)));
    let contacts = sizes.prop_flat_map(|(n, rank)| {
        let numbers = |len| prop::collection::vec(-6_i32..=6, len);
        let slack = prop::collection::vec(prop_oneof![2 => Just(0), 1 => 1..=8_i32], n);
        let exponents = prop_oneof![Just(vec![0; n]), prop::collection::vec(-2..=2, n)];
        let copies = prop::collection::vec((0..n, 0..n), 0..=2);
        (Just(n), numbers(rank * n), numbers(rank), slack, exponents, copies, any::<bool>())
    });
    contacts.prop_map(|(n, numbers, c, slack, exponents, copies, smooth)| {
        // Off the grid, rounding makes the dependent rows only nearly dependent.
        let real = |k: i32| f64::from(k) * if smooth { 0.1 } else { 0.25 };
        let mut b: Vec<f64> = numbers.into_iter().map(real).collect();
        for (i, exponent) in exponents.into_iter().enumerate() {
            b.iter_mut().skip(i).step_by(n).for_each(|entry| *entry *= 10_f64.powi(exponent));
        }
        for (from, to) in copies {
            for row in b.chunks_mut(n) {
                row[to] = row[from];
            }
        }
        let c: Vec<f64> = c.into_iter().map(real).collect();
        let slack: Vec<f64> = slack.into_iter().map(real).collect();
        Contacts::solvable(n, b, &c, &slack)
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 400,
        rng_seed: RngSeed::Fixed(2),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn every_solver_agrees_with_enumeration(contacts in redundant_contacts()) {
        let oracle = solve(solver_by_name("enumeration"), contacts.lcp()).unwrap();
        let (w, resultant) = (contacts.w(&oracle), contacts.resultant(&oracle));
        for entry in solvers() {
            let z = solve(entry, contacts.lcp()).unwrap();
            let tolerance = comparison_tolerance(entry);
            assert_close(&entry.name, "w", &contacts.w(&z), &w, tolerance * contacts.velocity_scale());
            let weakest = (0..contacts.n).map(|i| contacts.m[i * (contacts.n + 1)]).filter(|m| *m > 0.0);
            let impulse = contacts.velocity_scale() / weakest.fold(f64::INFINITY, f64::min).sqrt();
            assert_close(&entry.name, "B z", &contacts.resultant(&z), &resultant, tolerance * impulse);
        }
    }

}

// ---------------------------------------------------------------------------------------------------------------------
// Frictional problems of Siconos (capsules, rovers, box stacks, a rock pile, a tower of slabs, spheres), of which the
// normal rows were taken and symmetrised. They are not in this tree, see `support::data_of_others`.

/// Reads such a file, numbers little-endian: 8 bytes of name · u32 stretches, each u16 length and source · u64 · u32
/// problems, each u16 n · u8 kind of matrix (0 that of the problem before, 1 upper triangle by rows, 2 all) · for 1 and
/// 2 a bit per entry, lowest first, set where it is not zero, then those as f64 · b as f64; at the end 32 bytes of
/// checksum.
fn problems_of_others(path: &Path) -> Vec<(Vec<f64>, Vec<f64>)> {
    let bytes = std::fs::read(path).unwrap();
    let mut at = 8;
    let mut take = |length: usize| {
        at += length;
        &bytes[at - length..at]
    };
    let length = |bytes: &[u8]| bytes.iter().rev().fold(0_usize, |sum, byte| 256 * sum + usize::from(*byte));
    let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap());
    let mut problems: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    for _ in 0..length(take(4)) {
        let source = length(take(2));
        take(source + 8);
        for _ in 0..length(take(4)) {
            let (n, kind) = (length(take(2)), take(1)[0]);
            let h = if kind == 0 {
                problems[problems.len() - 1].0.clone()
            } else {
                let cells: Vec<_> =
                    (0..n).flat_map(|i| (if kind == 1 { i } else { 0 }..n).map(move |j| (i, j))).collect();
                let (mut h, bits) = (vec![0.0; n * n], take(cells.len().div_ceil(8)).to_vec());
                let filled = cells.into_iter().enumerate().filter(|(k, _)| bits[k / 8] >> (k % 8) & 1 == 1);
                for (_, (i, j)) in filled {
                    h[i * n + j] = number(take(8));
                    if kind == 1 {
                        h[j * n + i] = h[i * n + j];
                    }
                }
                h
            };
            problems.push((h, (0..n).map(|_| number(take(8))).collect()));
        }
    }
    problems
}

#[test]
fn the_pivoting_solvers_solve_the_problems_of_others() {
    let Some(folder) = data_of_others("siconos") else { return };
    for (file, count) in [("frictional_normal_rows_small.lcp", 42), ("frictional_normal_rows_large.lcp", 2)] {
        let problems = problems_of_others(&folder.join(file));
        assert_eq!(problems.len(), count);
        for (name, (h, b)) in
            ["active-set", "lemke"].into_iter().flat_map(|name| problems.iter().map(move |p| (name, p)))
        {
            assert!(attempt(name, h, b).1, "{name}, n = {}", b.len());
        }
    }
}
