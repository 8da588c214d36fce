//! The default contact solver beside its rivals, the check included; what counts are ratios.
//!
//! 1. The four-contact problems of the wedge box, from the corpus, in the order in which runs gave them: *warm*, the longest
//!    stretch of each sequence in which the same contacts push, and *all*, changes included. Demanded are at most 50 ns per warm
//!    problem and 200 times less than Clarabel.
//! 2. Against size: a *row* (each contact shares a body with its neighbours: regular) and a *board* (one rigid body on n points:
//!    rank 2, redundant), pushed by a slowly turning force. Demanded: faster than Lemke at every n, and boards no slower than rows.
//!
//! Flops of a warm solve with n contacts, a of them active, matrix as before: impulses a², velocities 2 n a, check 2 n² + 4 n.
//! For n = 4, a = 2 that is 4 + 16 + 48 ≈ 70, or about 9 ns at two operations per cycle and 4 GHz. Up to four members are
//! factorised anew, another 7 for two.
//!
//! Every answer is checked before anything is timed.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rimbench::complementarity::{ActiveSet, ComplementaritySolver, Lcp};
use rimbench::corpus::Corpus;
use std::hint::black_box;
use std::path::Path;

/// Problems in the order of a run.
type Sequence = Vec<(Vec<f64>, Vec<f64>)>;

/// The longest part in which the same contacts push.
fn steady(sequence: &Sequence) -> Option<Sequence> {
    let mut solver = ActiveSet::new(4);
    let mut pushing = |(h, b): &(Vec<f64>, Vec<f64>)| {
        let mut impulses = vec![0.0; b.len()];
        solver.attempt(Lcp::new(h, b), &mut impulses).expect("the problem has a solution");
        impulses.iter().map(|p| *p > 0.0).collect::<Vec<_>>()
    };
    let sets: Vec<_> = sequence.iter().map(&mut pushing).collect();
    let mut end = 0;
    let parts = sets.chunk_by(|a, b| a == b).map(|part| {
        end += part.len();
        (end - part.len()..end, part[0].contains(&true))
    });
    let (longest, _) = parts.filter(|(_, pushes)| *pushes).max_by_key(|(part, _)| part.len())?;
    Some(sequence[longest].to_vec())
}

/// Stretches with four contacts of the mechanics or of a scheme.
fn wedge_box(of: &str) -> Vec<Sequence> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/contact-problems/corpus.lcp");
    let stretches =
        Corpus::<false>::read(&path).expect("the committed corpus").of_source("wedge-box").stretches.into_iter();
    let of_four = stretches
        .filter(|stretch| stretch.source.ends_with(of) && stretch.problems.iter().all(|problem| problem.b.len() == 4));
    of_four.map(|stretch| stretch.problems.into_iter().map(|p| (p.h.to_vec(), p.b)).collect()).collect()
}

/// Contacts between neighbours in a row of bodies: the matrix is the same all the time.
fn row(n: usize) -> Sequence {
    let coupling = |i: usize, j: usize| [2.0, -1.0, 0.0][i.abs_diff(j).min(2)];
    pushed((0..n * n).map(|k| coupling(k / n, k % n)).collect(), n, |i, turn| (0.3 * i as f64 + turn).sin() - 0.5)
}

/// A rigid board on n points: `H_ij = 1/m + x_i x_j / I`; its weight acts at a point that moves.
fn board(n: usize) -> Sequence {
    let x = |i: usize| if n == 1 { 0.0 } else { 2.0 * i as f64 / (n - 1) as f64 - 1.0 };
    let h = (0..n * n).map(|k| 1.0 + 3.0 * x(k / n) * x(k % n)).collect();
    pushed(h, n, |i, turn| -1.0 - 3.0 * 0.9 * turn.sin() * x(i))
}

fn pushed(h: Vec<f64>, n: usize, b: impl Fn(usize, f64) -> f64) -> Sequence {
    (0..16).map(|step| (h.clone(), (0..n).map(|i| b(i, 0.02 * f64::from(step))).collect())).collect()
}

/// Times each solver on all problems of the sequences, one after the other.
fn compare(c: &mut Criterion, title: &str, sequences: &[Sequence], names: &[&str]) {
    let everything = rimbench::everything().expect("the program's own list");
    let problems: Vec<_> = sequences.iter().flatten().collect();
    let n = problems[0].1.len();
    let mut group = c.benchmark_group(title);
    group.throughput(Throughput::Elements(problems.len() as u64));
    for name in names {
        let mut solver = everything.solver(name).expect("a solver of the list").checked(n);
        let mut impulses = vec![0.0; n];
        for (h, b) in &problems {
            solver.solve(Lcp::new(h, b), &mut impulses).expect("the problem has a solution");
            assert!(Lcp::new(h, b).natural_residual(&impulses) <= solver.tolerance(), "{name}");
        }
        group.bench_function(*name, |bencher| {
            bencher.iter(|| {
                for (h, b) in &problems {
                    assert!(solver.solve(black_box(Lcp::new(h, b)), &mut impulses).is_ok(), "solved before");
                    black_box(&impulses);
                }
            });
        });
    }
    group.finish();
}

fn solvers(c: &mut Criterion) {
    const NAMES: [&str; 3] = ["active-set", "lemke", "clarabel"];
    for of in ["mechanics", "scheme"] {
        let all = wedge_box(of);
        let warm: Vec<Sequence> = all.iter().filter_map(steady).collect();
        assert!(!warm.is_empty(), "{of}: no four-contact problems in the corpus");
        compare(c, &format!("wedge box, {of}, warm"), &warm, &NAMES);
        compare(c, &format!("wedge box, {of}, all"), &all, &NAMES);
    }
    for n in [1, 2, 4, 8, 16, 32, 64, 128] {
        compare(c, &format!("row, n = {n}"), &[row(n)], &NAMES[..2]);
        compare(c, &format!("board, n = {n}"), &[board(n)], &NAMES[..2]);
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = solvers
}
criterion_main!(benches);
