//! The default solver beside the others, turn by turn in one process; what counts is the ratio of the medians.
//!
//! 1. The four-contact problems of the wedge box, from the corpus, in the order in which runs gave them, check included:
//!    *warm*, the longest stretch of each sequence in which the same contacts push, and *all*, changes included. Demanded
//!    are at most 50 ns per warm problem and 200 times less than Clarabel. A sequence is repeated until the clock does not
//!    matter before the next one comes: in a simulation too the problem has just been assembled and is at hand.
//! 2. Against size, n = 1 … 128: a *row* (each contact shares a body with its neighbours: regular) and a *board* (one rigid
//!    body on n points: rank 2, redundant), pushed by a slowly turning force. Demanded: faster than Lemke at every n, and
//!    boards no slower than rows.
//! 3. The factorisation from scratch of a regular active set, as `active-set` does it (a changed matrix against the same one
//!    again), beside faer's Cholesky: of a dense matrix, of a pile (a contact meets a fifth at most of the others) and of a row.
//!
//! Flops of a warm solve with n contacts, a of them active, matrix as before: impulses a², velocities 2 n a, check 2 n² + 4 n.
//! For n = 4, a = 2 that is 4 + 16 + 48 ≈ 70, or about 9 ns at two operations per cycle and 4 GHz. Up to four members are
//! factorised anew, another 7 for two.
//!
//! Every answer is checked before anything is timed. Without `--bench` nothing is.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltParams, cholesky_in_place, cholesky_in_place_scratch};
use faer::{MatMut, Par, Spec};
use rimbench::complementarity::{ActiveSet, Checked, ComplementaritySolver, Lcp, natural_residual};
use rimbench::corpus::Corpus;
use rimbench::statistics::median;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

const NAMES: [&str; 5] = ["active-set", "active-set-cold", "dantzig", "lemke", "clarabel"];
const TURNS: usize = 21;
/// Seconds for which a sequence is repeated: some thousand times what a look at the clock takes.
const LONG_ENOUGH: f64 = 1e-4;

/// Problems in the order of a run.
struct Sequence {
    problems: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Sequence {
    fn lcp(&self, index: usize) -> Lcp<'_> {
        let (m, q) = &self.problems[index];
        Lcp::new(m, q)
    }

    fn n(&self) -> usize {
        self.problems[0].1.len()
    }

    /// The longest part in which the same contacts push.
    fn steady(&self) -> Option<Sequence> {
        let mut solver = ActiveSet::new(self.n());
        let mut z = vec![0.0; self.n()];
        let mut pushing = |index: usize| {
            solver.attempt(self.lcp(index), &mut z).expect("the problem has a solution");
            z.iter().map(|z| *z > 0.0).collect::<Vec<_>>()
        };
        let sets: Vec<_> = (0..self.problems.len()).map(&mut pushing).collect();
        let mut first = 0;
        let parts = sets.chunk_by(|a, b| a == b).map(|part| {
            first += part.len();
            (first - part.len()..first, part[0].contains(&true))
        });
        let (longest, _) = parts.filter(|(_, pushes)| *pushes).max_by_key(|(part, _)| part.len())?;
        Some(Sequence { problems: self.problems[longest].to_vec() })
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
    let everything = rimbench::everything().expect("the program's own list");
    everything.solver(name).expect("a solver of the list").checked(n)
}

/// Every answer of every solver is one, by a residual computed here.
fn verify(sequences: &[Sequence], names: &[&str]) {
    for sequence in sequences {
        for name in names {
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
    let largest = sequences.iter().map(Sequence::n).max().unwrap_or(0);
    let mut z = vec![0.0; largest];
    let mut solvers: Vec<Checked> = names.iter().map(|name| solver(name, largest)).collect();
    let mut measured = vec![Vec::with_capacity(TURNS); names.len()];
    for _ in 0..TURNS {
        for (solver, measured) in solvers.iter_mut().zip(&mut measured) {
            let (mut solved, mut seconds) = (0, 0.0);
            for sequence in sequences {
                let mut pass = || {
                    let began = Instant::now();
                    for index in 0..sequence.problems.len() {
                        let answer = &mut z[..sequence.n()];
                        assert!(solver.solve(black_box(sequence.lcp(index)), answer).is_ok(), "solved before");
                        black_box(answer);
                    }
                    began.elapsed().as_secs_f64()
                };
                // The first pass brings the problems to hand and tells how many more it takes.
                let passes = 1 + (LONG_ENOUGH / pass()) as usize;
                seconds += (0..passes).map(|_| pass()).sum::<f64>();
                solved += passes * sequence.problems.len();
            }
            measured.push(1e9 * seconds / solved as f64);
        }
    }
    measured.into_iter().filter_map(median).collect()
}

/// Seconds per call.
fn repeated(mut call: impl FnMut()) -> f64 {
    let began = Instant::now();
    let mut calls = 0;
    while began.elapsed().as_secs_f64() < LONG_ENOUGH {
        (0..10).for_each(|_| call());
        calls += 10;
    }
    began.elapsed().as_secs_f64() / f64::from(calls)
}

/// Factorisation of `M`, all contacts pushing: ns of `active-set` and of faer.
fn factorisation(n: usize, entry: impl Fn(usize, usize) -> f64) -> [f64; 2] {
    let m: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
    let other: Vec<f64> = m.iter().map(|entry| 1.5 * entry).collect();
    // M z + q = 0 at z = 1.
    let q: Vec<f64> = m.chunks_exact(n).map(|row| -row.iter().sum::<f64>()).collect();
    let mut solver = ActiveSet::new(n);
    let mut z = vec![0.0; n];
    solver.attempt(Lcp::new(&m, &q), &mut z).expect("M is regular");
    assert_eq!(solver.active_set().len(), n);
    let mut solve = |m: &[f64], factorisations: u32| {
        let stats = solver.attempt(Lcp::new(black_box(m), &q), &mut z).expect("M is regular");
        assert_eq!((stats.pivots, stats.factorisations), (0, factorisations));
        black_box(&z);
    };
    let mut scratch = MemBuffer::new(cholesky_in_place_scratch::<f64>(n, Par::Seq, Spec::<LltParams, f64>::default()));
    let mut l = m.clone();
    let mut by_faer = || {
        l.copy_from_slice(black_box(&m));
        let (view, stack) = (MatMut::from_column_major_slice_mut(&mut l, n, n), MemStack::new(&mut scratch));
        cholesky_in_place(view, Default::default(), Par::Seq, stack, Spec::default()).expect("M is definite");
    };
    let [mut own, mut faer] = [Vec::new(), Vec::new()];
    for _ in 0..TURNS {
        let changed = repeated(|| [&other, &m].into_iter().for_each(|m| solve(m, 1))) / 2.0;
        own.push(1e9 * (changed - repeated(|| solve(&m, 0))));
        faer.push(1e9 * repeated(&mut by_faer));
    }
    [own, faer].map(|times| median(times).unwrap())
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
    for of in ["mechanics", "scheme"] {
        let all = wedge_box(of);
        let warm: Vec<Sequence> = all.iter().filter_map(Sequence::steady).collect();
        assert!(!warm.is_empty(), "{of}: no four-contact problems in the corpus");
        for (title, sequences) in [("warm", warm), ("all", all)] {
            verify(&sequences, &NAMES);
            if bench {
                print(format!("wedge box, {of}, {title}"), &times(&sequences, &NAMES));
            }
        }
    }
    for n in [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128] {
        let kinds = [("row", row(n)), ("board", board(n))];
        for (kind, sequence) in kinds {
            let sequences = [sequence];
            verify(&sequences, &NAMES[..4]);
            if bench {
                print(format!("{kind}, n = {n}"), &times(&sequences, &NAMES[..4]));
            }
        }
    }
    if bench {
        let dense = |i: usize, j: usize| if i == j { 4.0 } else { 1.0 / (1.0 + i.abs_diff(j) as f64) };
        let pile = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 4.0,
            1 | 8 | 9 => -0.6,
            _ => 0.0,
        };
        let row = |i: usize, j: usize| [2.0, -1.0, 0.0][i.abs_diff(j).min(2)];
        println!("factorisation, ns: here, by faer, ratio");
        for n in [16, 24, 32, 48, 64, 96, 128] {
            let kinds = [factorisation(n, dense), factorisation(n, pile), factorisation(n, row)];
            let [dense, pile, row] = kinds.map(|[own, faer]| format!("{own:9.0} {faer:8.0} {:5.2}", own / faer));
            println!("n = {n:3}   dense {dense}   pile {pile}   row {row}");
        }
    }
    println!(
        "demanded: wedge box, warm, at most 50 ns and 200 times less than {}; below {} at every n",
        NAMES[4], NAMES[3]
    );
}
