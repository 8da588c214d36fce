//! The default solver beside the others, turn by turn in one process; what counts is the ratio of the medians.
//!
//! 1. The four-contact problems of the wedge box, from the corpus, in the order in which runs gave them, behind the check
//!    and with it: demanded are at most 50 ns per problem and 200 times less than Clarabel.
//! 2. Against size, n = 1 … 128: a *row* (each contact shares a body with its neighbours: regular) and a *board* (one rigid
//!    body on n points: rank 2, redundant), pushed by a slowly turning force. Demanded: faster than Lemke at every n, and
//!    boards no slower than rows.
//!
//! Flops of a warm solve with n contacts, a of them active, matrix as before: impulses a², velocities 2 n a, check 2 n² + 4 n.
//! For n = 4, a = 2 that is 4 + 16 + 48 ≈ 70, or about 9 ns at two operations per cycle and 4 GHz.
//!
//! Every answer is checked before anything is timed. Without `--bench` nothing is.

use rimbench::complementarity::{Checked, ComplementaritySolver, Lcp, natural_residual, solver_by_name};
use rimbench::corpus::Corpus;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

const NAMES: [&str; 5] = ["active-set", "active-set-cold", "dantzig", "lemke", "clarabel"];
const TURNS: usize = 21;

/// Problems in the order of a run.
struct Sequence {
    problems: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Sequence {
    fn lcp(&self, index: usize) -> Lcp<'_> {
        let (m, q) = &self.problems[index];
        Lcp { m, q }
    }

    fn n(&self) -> usize {
        self.problems[0].1.len()
    }
}

/// Stretches with four contacts; `of` is a part of the source.
fn wedge_box(of: &str) -> Vec<Sequence> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/contact-problems/corpus.lcp");
    let corpus = Corpus::read(&path).expect("the committed corpus").of_source("wedge-box");
    let four = corpus
        .stretches
        .into_iter()
        .filter(|stretch| stretch.source.ends_with(of) && stretch.problems.iter().all(|problem| problem.q.len() == 4));
    four.map(|stretch| Sequence { problems: stretch.problems.into_iter().map(|p| (p.m.to_vec(), p.q)).collect() })
        .collect()
}

/// Contacts between neighbours in a row of bodies: the matrix is the same all the time.
fn row(n: usize) -> Sequence {
    let coupling = |i: usize, j: usize| [2.0, -1.0, 0.0][i.abs_diff(j).min(2)];
    pushed((0..n * n).map(|k| coupling(k / n, k % n)).collect(), n, |i, turn| (0.3 * i as f64 + turn).sin() - 0.5)
}

/// A rigid board on n points: `M_ij = 1/m + x_i x_j / I`; its weight acts at a point that moves.
fn board(n: usize) -> Sequence {
    let x = |i: usize| if n == 1 { 0.0 } else { 2.0 * i as f64 / (n - 1) as f64 - 1.0 };
    pushed((0..n * n).map(|k| 1.0 + 3.0 * x(k / n) * x(k % n)).collect(), n, |i, turn| {
        -1.0 - 3.0 * 0.9 * turn.sin() * x(i)
    })
}

fn pushed(m: Vec<f64>, n: usize, q: impl Fn(usize, f64) -> f64) -> Sequence {
    let problem = |step: usize| (m.clone(), (0..n).map(|i| q(i, 0.02 * step as f64)).collect());
    Sequence { problems: (0..16).map(problem).collect() }
}

fn solver(name: &str, n: usize) -> Checked {
    solver_by_name(name).expect("a solver of the list").checked(n)
}

/// Every answer of every solver is one, by a residual computed here.
fn verify(sequences: &[Sequence]) {
    for sequence in sequences {
        for name in NAMES {
            let mut solver = solver(name, sequence.n());
            let mut z = vec![0.0; sequence.n()];
            for index in 0..sequence.problems.len() {
                solver.solve(sequence.lcp(index), &mut z).expect("the problem has a solution");
                assert!(natural_residual(sequence.lcp(index), &z) <= solver.tolerance(), "{name}");
            }
        }
    }
}

/// Median time per problem of each solver, ns, all taking turns.
fn times(sequences: &[Sequence], names: &[&str]) -> Vec<f64> {
    let count: usize = sequences.iter().map(|sequence| sequence.problems.len()).sum();
    let largest = sequences.iter().map(Sequence::n).max().unwrap_or(0);
    let mut z = vec![0.0; largest];
    let mut solvers: Vec<Checked> = names.iter().map(|name| solver(name, largest)).collect();
    let mut measured = vec![Vec::with_capacity(TURNS); names.len()];
    // Enough passes for the clock not to matter.
    let passes = (20_000 / (count * largest * largest)).max(1);
    for _ in 0..TURNS {
        for (solver, measured) in solvers.iter_mut().zip(&mut measured) {
            let began = Instant::now();
            for _ in 0..passes {
                for sequence in sequences {
                    for index in 0..sequence.problems.len() {
                        let lcp = black_box(sequence.lcp(index));
                        black_box(solver.solve(lcp, &mut z[..sequence.n()])).expect("solved before");
                    }
                }
            }
            measured.push(1e9 * began.elapsed().as_secs_f64() / (passes * count) as f64);
        }
    }
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[TURNS / 2]
    };
    measured.into_iter().map(median).collect()
}

fn main() {
    let bench = std::env::args().any(|argument| argument == "--bench");
    println!(
        "{:28} {:>11} {:>11} {:>11} {:>11} {:>11}  ns per problem",
        "", NAMES[0], "cold", NAMES[2], NAMES[3], NAMES[4]
    );
    let print = |title: String, times: &[f64]| {
        let numbers: String = times.iter().map(|time| format!(" {time:11.1}")).collect();
        let ratios: String = times[1..].iter().map(|time| format!(" {:.1}", time / times[0])).collect();
        println!("{title:28}{numbers}  ratios to the first{ratios}");
    };
    for (title, of) in [("wedge box, mechanics", "mechanics"), ("wedge box, scheme", "scheme")] {
        let sequences = wedge_box(of);
        assert!(!sequences.is_empty(), "{title}: no four-contact problems in the corpus");
        verify(&sequences);
        if bench {
            print(title.to_owned(), &times(&sequences, &NAMES));
        }
    }
    for n in [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128] {
        let kinds = [("row", row(n)), ("board", board(n))];
        for (kind, sequence) in kinds {
            let sequences = [sequence];
            if n <= 32 {
                verify(&sequences);
            }
            if bench {
                print(format!("{kind}, n = {n}"), &times(&sequences, &NAMES[..4]));
            }
        }
    }
    println!("demanded: wedge box at most 50 ns and 200 times less than {}; below {} at every n", NAMES[4], NAMES[3]);
}
