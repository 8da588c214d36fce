//! The default contact solver beside its rivals, the check included; what counts are ratios.
//!
//! 1. The problems with known answers, from nothing (*cold*) and from their own answer (*warm*), beside Lemke's method,
//!    Gauss–Seidel (the solver from outside, `examples/custom_solver.rs`) and Clarabel.
//! 2. Against size: a *row* (each contact shares a body with its neighbours: regular) and a *board* (one rigid body on
//!    n points: rank 2, redundant), pushed by a slowly turning force. Demanded: faster than Lemke at every n, and
//!    boards no slower than rows.
//! 3. In space, with friction: feet that slide in directions that turn, beside Gauss–Seidel, ADMM and Clarabel; and
//!    micro steps of whole runs of machines in space, beside those of planar ones.
//!
//! Flops of a warm solve with n contacts, a of them active, matrix as before: impulses a², velocities 2 n a, check 2
//! n² + 4 n. For n = 4, a = 2 that is 4 + 16 + 48 ≈ 70, or about 9 ns at two operations per cycle and 4 GHz. Up to four
//! members are factorised anew, another 7 for two.
//!
//! Every answer is checked before anything is timed.
//!
//! With `--csv` only the default solver is timed, on rows and boards of growing size, cold and in sequence, for
//! `benches/peers/daqp_rows.py`.

#[allow(dead_code)] // The oracle of the tests.
#[path = "../tests/support/rivals/mod.rs"]
mod rivals;

use criterion::{Criterion, Throughput, criterion_group};
use rimbench::catalogue::Catalogue;
use rimbench::complementarity::{Lcp, SparseLcp, SparseSolver};
use rimbench::cosim::{Bounds, StopFlag};
use rimbench::friction::ContactSweeps;
use rimbench::friction::space::{SpaceAdmm, SpaceProblem, SpaceSolver};
use rimbench::known_problems::known_problems;
use rimbench::linear_algebra::{SymmetricPattern, SymmetricRows};
use rimbench::runs::{RunRequest, simulate};
use rimbench::solver_entry::SolverEntry;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Matrices and right-hand sides, in the order in which they are solved.
type Problems = Vec<(Vec<f64>, Vec<f64>)>;

/// Contacts between neighbours in a row of bodies: the matrix is the same all the time.
fn row(n: usize) -> Problems {
    let coupling = |i: usize, j: usize| [2.0, -1.0, 0.0][i.abs_diff(j).min(2)];
    pushed((0..n * n).map(|k| coupling(k / n, k % n)).collect(), n, |i, turn| (0.3 * i as f64 + turn).sin() - 0.5)
}

/// A rigid board on n points: `H_ij = 1/m + x_i x_j / I`; its weight acts at a point that moves.
fn board(n: usize) -> Problems {
    let x = |i: usize| if n == 1 { 0.0 } else { 2.0 * i as f64 / (n - 1) as f64 - 1.0 };
    let h = (0..n * n).map(|k| 1.0 + 3.0 * x(k / n) * x(k % n)).collect();
    pushed(h, n, |i, turn| -1.0 - 3.0 * 0.9 * turn.sin() * x(i))
}

/// A row at rest, its first contact hit: the impulse goes through all of them.
fn hit_row(n: usize) -> Problems {
    let hit = |step: i32| (0..n).map(|i| if i == 0 { -1.0 - 0.02 * f64::from(step) } else { 0.0 }).collect();
    row(n).into_iter().zip(0..).map(|((h, _), step)| (h, hit(step))).collect()
}

fn pushed(h: Vec<f64>, n: usize, b: impl Fn(usize, f64) -> f64) -> Problems {
    (0..16).map(|step| (h.clone(), (0..n).map(|i| b(i, 0.02 * f64::from(step))).collect())).collect()
}

/// Times each solver on all problems, one after the other, or each twice: from nothing, then from its answer.
fn compare(c: &mut Criterion, title: &str, problems: &Problems, solvers: &[SolverEntry], start: Option<bool>) {
    let mut group = c.benchmark_group(title);
    group.throughput(Throughput::Elements(problems.len() as u64));
    for entry in solvers {
        let solver = |(h, b): &(Vec<f64>, Vec<f64>)| {
            let (mut solver, mut impulses) = (entry.checked(b.len()), vec![0.0; b.len()]);
            solver.solve(Lcp::new(h, b), &mut impulses).expect("the problem has a solution");
            assert!(Lcp::new(h, b).natural_residual(&impulses) <= solver.tolerance(), "{}", entry.name);
            (solver, impulses)
        };
        // One for all problems of a sequence, or one for each.
        let mut prepared: Vec<_> = match start {
            Some(_) => problems.iter().map(solver).collect(),
            None => vec![solver(&problems[0])],
        };
        group.bench_function(&*entry.name, |bencher| {
            bencher.iter(|| {
                for (at, (h, b)) in problems.iter().enumerate() {
                    let count = prepared.len();
                    let (solver, impulses) = &mut prepared[at % count];
                    if start == Some(false) {
                        solver.reset();
                    }
                    assert!(solver.solve(black_box(Lcp::new(h, b)), impulses).is_ok(), "solved before");
                    black_box(&impulses);
                }
            });
        });
    }
    group.finish();
}

/// Feet of one body in space, three rows each, which slide in directions that turn: Newton with its fallbacks, the
/// methods that stand behind it, and Clarabel on the associated law, which is another problem. All start from the
/// answer of the problem before but Clarabel.
fn cones(c: &mut Criterion) {
    for feet in [3_usize, 4, 6, 16] {
        let size = 3 * feet;
        let arm = |k: usize| (k as f64 * 6.0 / feet as f64 + 0.4).sin_cos();
        let row = |row: usize| {
            let (y, x) = arm(row % feet);
            [[0.0, 0.0, 1.0, y, -x, 0.0], [1.0, 0.0, 0.0, 0.0, -0.8, -y], [0.0, 1.0, 0.0, 0.8, 0.0, x]][row / feet]
        };
        let product = |a: [f64; 6], b: [f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let h: Vec<f64> = (0..size * size).map(|k| product(row(k / size), row(k % size))).collect();
        let friction = vec![0.3; feet];
        let problems: Vec<Vec<f64>> = (0..64)
            .map(|step| {
                let (s, c) = (0.02 * f64::from(step)).sin_cos();
                (0..size).map(|k| product(row(k), [0.3 * c, 0.3 * s, -1.0, 0.1 * s, 0.1 * c, 0.2 * s])).collect()
            })
            .collect();
        let problem = |b| SpaceProblem::with_friction(&h, b, &friction);
        let mut group = c.benchmark_group(format!("cones, {feet} feet"));
        group.throughput(Throughput::Elements(problems.len() as u64));
        let mut impulses = vec![0.0; size];
        let mut solver = SpaceSolver::new(feet, 1e-9);
        group.bench_function("newton and fallbacks", |bencher| {
            bencher.iter(|| {
                for b in &problems {
                    solver.solve(black_box(problem(b)), &mut impulses).expect("it has a solution");
                }
            });
        });
        let mut sweeps = ContactSweeps::<2>::new(feet);
        group.bench_function("gauss-seidel", |bencher| {
            bencher
                .iter(|| problems.iter().map(|b| sweeps.sweep(problem(b), 1e-8, 5000, &mut impulses).0).sum::<u32>());
        });
        let mut admm = SpaceAdmm::new(feet);
        group.bench_function("admm", |bencher| {
            bencher
                .iter(|| problems.iter().map(|b| admm.iterate(problem(b), 1e-8, 5000, &mut impulses).0).sum::<u32>());
        });
        group.bench_function("clarabel, associated law", |bencher| {
            bencher.iter(|| problems.iter().filter_map(|b| rivals::relaxed_cones(problem(b), b)).count());
        });
        group.finish();
    }
}

/// Runs of gap tracking at H = 10 ms, per micro step of 50 µs; steps of the mechanics and the making of models are in
/// it.
fn micro_steps(c: &mut Criterion) {
    let catalogue = Catalogue::standard();
    let mut group = c.benchmark_group("micro steps");
    for case in ["gripper", "wedge-box-friction", "tripod", "wedge-box-space"] {
        let mut request = RunRequest { duration_s: Some(1.0), ..RunRequest::of(case, "rim-nonsmooth-gap") };
        request.put("macro_step_s", "10e-3").expect("an option");
        let spec = request.resolve(&catalogue).expect("a run");
        group.throughput(Throughput::Elements(20_000));
        group.bench_function(case, |bencher| {
            bencher.iter(|| simulate(&spec, Bounds::default(), None, StopFlag::never()).expect("it completes"));
        });
    }
    group.finish();
}

fn solvers(c: &mut Criterion) {
    let mut all = vec![SolverEntry::active_set(), SolverEntry::lemke()];
    all.extend(rivals::rivals().into_iter().filter(|solver| solver.name != "enumeration"));
    let known = known_problems().into_iter().map(|problem| (problem.h, problem.b)).collect();
    compare(c, "known answers, cold", &known, &all, Some(false));
    compare(c, "known answers, warm", &known, &all, Some(true));
    for n in [1, 2, 4, 8, 16, 32, 64, 128] {
        compare(c, &format!("row, n = {n}"), &row(n), &all[..2], None);
        compare(c, &format!("board, n = {n}"), &board(n), &all[..2], None);
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = solvers, cones, micro_steps
}

/// The shortest of many passes over a sequence, per problem, µs, with one solver for all problems or one for each;
/// with `new` these are copies of it in every pass.
fn shortest<S: Clone>(
    problems: &Problems,
    mut solvers: Vec<S>,
    new: Option<&S>,
    mut solve: impl FnMut(&mut S, &[f64]),
) -> f64 {
    let (mut shortest, started, count) = (f64::INFINITY, Instant::now(), solvers.len());
    while started.elapsed() < Duration::from_millis(100) {
        solvers.iter_mut().zip(new.into_iter().cycle()).for_each(|(solver, new)| solver.clone_from(new));
        let pass = Instant::now();
        problems.iter().enumerate().for_each(|(at, (_, b))| solve(&mut solvers[at % count], b));
        shortest = shortest.min(pass.elapsed().as_secs_f64());
    }
    1e6 * shortest / problems.len() as f64
}

/// Prints what the default solver takes per problem, from nothing and from the answer of the one before, µs; of rows
/// also where only the non-zeros of H are kept, as in cases with many contacts.
fn print_csv() {
    println!("problem,contacts,state,ours_us,ours_by_pattern_us");
    for (name, make) in [("row", row as fn(usize) -> Problems), ("hit-row", hit_row), ("board", board)] {
        for n in [1, 4, 16, 64, 256] {
            let (problems, mut p) = (make(n), vec![0.0; n]);
            let h = &problems[0].0;
            for cold in [true, false] {
                let mut solver = SolverEntry::active_set().checked(n);
                let tolerance = solver.tolerance();
                solver.solve(Lcp::new(h, &problems[0].1), &mut p).expect("the problem has a solution");
                let dense = shortest(&problems, vec![solver], None, |solver, b| {
                    let problem = black_box(Lcp::new(h, b));
                    let solved = if cold {
                        solver.reset();
                        solver.solve(problem, &mut p)
                    } else {
                        solver.solve_again(problem, &mut p)
                    };
                    solved.expect("the problem has a solution");
                });
                let neighbours: Vec<Vec<usize>> =
                    (0..n).map(|i| (i.saturating_sub(1)..n.min(i + 2)).collect()).collect();
                let pattern = SymmetricPattern::new(&neighbours);
                let entries: Vec<f64> =
                    (0..n).flat_map(|i| pattern.columns(i).iter().map(move |&j| h[i * n + j as usize])).collect();
                // Forgetting its set it would still start from what it knows of the last problems.
                let new = SparseSolver::new(&pattern, tolerance);
                let mut sparse = || {
                    let solvers = vec![new.clone(); if cold { problems.len() } else { 1 }];
                    shortest(&problems, solvers, cold.then_some(&new), |solver, b| {
                        let problem = SparseLcp::by_pattern(SymmetricRows { pattern: &pattern, entries: &entries }, b);
                        solver.solve_again(black_box(problem), &mut p).expect("the problem has a solution");
                    })
                };
                let by_pattern = if name == "board" { String::new() } else { format!("{:.4}", sparse()) };
                println!("{name},{n},{},{dense:.4},{by_pattern}", if cold { "cold" } else { "sequence" });
            }
        }
    }
}

fn main() {
    if std::env::args().any(|argument| argument == "--csv") {
        return print_csv();
    }
    benches();
    Criterion::default().configure_from_args().final_summary();
}
