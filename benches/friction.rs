//! Contact problems with friction beside those without, turn by turn in one process; what counts is the ratio of the medians.
//!
//! 1. Four contacts, warm, the check included: with friction (all stick, all slide, two of each) and without it, that is the normal rows
//!    of the same problem, solved by the default solver. *Regular* contacts are a chain of four bodies; *redundant* ones are on two
//!    bodies, as in the wedge box, so that eight rows that stick have rank six. The push turns slowly, so that no answer is the one
//!    before and the states stay. Demanded: at most four times the problem without friction, with a matrix that changes from problem to
//!    problem as that of the mechanics does; and with one that stays, as that of a model within its macro step.
//! 2. Whole runs of the wedge box, with friction and without, per micro step of the actuator.
//!
//! Every answer is checked before anything is timed. Without `--bench` nothing is.

use rimbench::complementarity::{ComplementaritySolver, Lcp, SolverEntry};
use rimbench::cosim::StopFlag;
use rimbench::friction::{ContactState, FrictionProblem, FrictionSolver, natural_residual};
use rimbench::runs::{RunRequest, RunSpec, simulate};
use rimbench::statistics::median;
use std::hint::black_box;
use std::time::Instant;

use ContactState::{SlipPositive, Stick};

const TURNS: usize = 21;
/// Seconds for which a sequence is repeated: some thousand times what a look at the clock takes.
const LONG_ENOUGH: f64 = 1e-3;
const CONTACTS: usize = 4;
const ROWS: usize = 2 * CONTACTS;

/// Problems one after the other with the same states.
struct Sequence {
    name: String,
    h: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
    friction: Vec<f64>,
    states: [ContactState; CONTACTS],
}

impl Sequence {
    fn len(&self) -> usize {
        self.b.len()
    }

    fn problem(&self, index: usize) -> FrictionProblem<'_> {
        FrictionProblem { h: &self.h[index], b: &self.b[index], friction: &self.friction }
    }

    /// The normal rows of a problem.
    fn normal(&self, index: usize) -> (Vec<f64>, Vec<f64>) {
        let m = (0..CONTACTS).flat_map(|row| &self.h[index][row * ROWS..row * ROWS + CONTACTS]).copied().collect();
        (m, self.b[index][..CONTACTS].to_vec())
    }

    /// The states hold in every problem, whatever solver is asked.
    fn verify(&self) {
        let mut solver = FrictionSolver::new(CONTACTS, 1e-9);
        let mut impulses = [0.0; ROWS];
        for index in 0..self.len() {
            solver.solve(self.problem(index), &mut impulses).expect("the problem has a solution");
            assert!(natural_residual(self.problem(index), &impulses) <= 1e-9, "{}", self.name);
            assert_eq!(solver.states(), self.states, "{}", self.name);
        }
        assert_eq!(solver.counters().fallbacks, 0, "{}", self.name);
    }
}

/// Rows of four contacts, normal ones first, of `bodies` bodies `(ẋ, ẏ, ω)`.
fn rows(bodies: usize) -> Vec<Vec<f64>> {
    let place = |contact: usize| {
        let body = contact * bodies / CONTACTS;
        let arm = [[-0.4, -0.5], [0.5, -0.3]][contact % 2];
        (body, arm)
    };
    let row = |contact: usize, tangential: bool| {
        let (body, [x, y]) = place(contact);
        let mut row = vec![0.0; 3 * bodies];
        let own = if tangential { [1.0, 0.0, -y] } else { [0.0, 1.0, x] };
        row[3 * body..3 * body + 3].copy_from_slice(&own);
        // Chained: each body stands on the one before.
        if bodies == CONTACTS && body > 0 {
            let below = if tangential { [-1.0, 0.0, 0.6] } else { [0.0, -1.0, -x] };
            row[3 * body - 3..3 * body].copy_from_slice(&below);
        }
        row
    };
    (0..ROWS).map(|row_index| row(row_index % CONTACTS, row_index >= CONTACTS)).collect()
}

/// A sequence of problems in which the contacts do what is asked: the impulses are chosen, and `b` follows from them.
fn sequence(name: &str, bodies: usize, states: [ContactState; CONTACTS]) -> Sequence {
    let rows = rows(bodies);
    let friction = vec![0.5, 0.4, 0.45, 0.55];
    let (mut h, mut b) = (Vec::new(), Vec::new());
    for step in 0..16 {
        let turn = 0.02 * f64::from(step);
        let mass = |j: usize| [1.0, 1.0, 0.2][j % 3] * (1.0 + 0.1 * (turn + j as f64).sin());
        let product =
            |a: &[f64], b: &[f64]| a.iter().zip(b).enumerate().map(|(j, (a, b))| a * b / mass(j)).sum::<f64>();
        let matrix: Vec<f64> = rows.iter().flat_map(|a| rows.iter().map(|b| product(a, b))).collect();
        let mut impulses = [0.0; ROWS];
        let mut velocity = [0.0; ROWS];
        for contact in 0..CONTACTS {
            let p_n = 1.0 + 0.2 * (turn + contact as f64).sin();
            impulses[contact] = p_n;
            let slides = states[contact] == SlipPositive;
            impulses[CONTACTS + contact] = friction[contact] * p_n * if slides { -1.0 } else { 0.3 };
            velocity[CONTACTS + contact] = if slides { 0.5 } else { 0.0 };
        }
        let free = |row: usize| velocity[row] - (0..ROWS).map(|k| matrix[row * ROWS + k] * impulses[k]).sum::<f64>();
        b.push((0..ROWS).map(free).collect());
        h.push(matrix);
    }
    Sequence { name: name.to_owned(), h, b, friction, states }
}

/// Seconds per call of `pass`, which does `work` things.
fn seconds(work: usize, mut pass: impl FnMut()) -> f64 {
    pass();
    let (began, mut passes) = (Instant::now(), 0);
    while began.elapsed().as_secs_f64() < LONG_ENOUGH {
        pass();
        passes += 1;
    }
    began.elapsed().as_secs_f64() / (passes * work) as f64
}

/// Medians in ns per problem: without friction, with it, with it and a matrix that stays.
fn times(sequence: &Sequence) -> [f64; 3] {
    let normal: Vec<_> = (0..sequence.len()).map(|index| sequence.normal(index)).collect();
    let mut without = SolverEntry::active_set().checked(CONTACTS);
    let [mut with, mut again] = [(); 2].map(|()| FrictionSolver::new(CONTACTS, 1e-9));
    let (mut z, mut impulses) = ([0.0; CONTACTS], [0.0; ROWS]);
    let mut measured = [(); 3].map(|()| Vec::with_capacity(TURNS));
    // The velocities of one problem, with the matrix of the first.
    let scales: Vec<f64> = (0..sequence.len()).map(|index| 1.0 + index as f64 / 64.0).collect();
    let scaled: Vec<Vec<f64>> = scales.iter().map(|s| sequence.b[0].iter().map(|b| s * b).collect()).collect();
    for _ in 0..TURNS {
        measured[0].push(seconds(sequence.len(), || {
            for (m, q) in &normal {
                assert!(without.solve(black_box(Lcp::new(m, q)), &mut z).is_ok());
                black_box(&z);
            }
        }));
        measured[1].push(seconds(sequence.len(), || {
            for index in 0..sequence.len() {
                assert!(with.solve(black_box(sequence.problem(index)), &mut impulses).is_ok());
                black_box(&impulses);
            }
        }));
        assert!(again.solve(sequence.problem(0), &mut impulses).is_ok());
        measured[2].push(seconds(sequence.len(), || {
            for b in &scaled {
                assert!(
                    again.solve_again(black_box(FrictionProblem { b, ..sequence.problem(0) }), &mut impulses).is_ok()
                );
                black_box(&impulses);
            }
        }));
    }
    for solver in [&with, &again] {
        assert_eq!(solver.counters().fallbacks, 0);
        assert!(solver.counters().pivots <= 2 * CONTACTS as u64, "the states stay");
    }
    measured.map(|seconds| 1e9 * median(seconds).unwrap_or(f64::NAN))
}

fn spec(case: &str, scheme: &str, options: &[(&str, &str)]) -> RunSpec {
    let mut request = RunRequest::of(case, scheme);
    request.macro_step_s = Some(5e-3);
    options.iter().for_each(|(key, value)| request.put(key, value).expect("an option"));
    request.resolve(&rimbench::everything().expect("the program's own list")).expect("a run")
}

/// Seconds of a whole run.
fn run(spec: &RunSpec) -> f64 {
    let began = Instant::now();
    black_box(simulate(spec, Default::default(), None, StopFlag::never()).expect("a run"));
    began.elapsed().as_secs_f64()
}

fn main() {
    let bench = std::env::args().any(|argument| argument == "--bench");
    println!("four contacts, warm: ns without friction, with it, with it and the same matrix; ratios to the first");
    for (kind, bodies) in [("regular", 4), ("redundant", 2)] {
        for (doing, states) in
            [("stick", [Stick; 4]), ("slide", [SlipPositive; 4]), ("both", [Stick, Stick, SlipPositive, SlipPositive])]
        {
            let sequence = sequence(&format!("{kind}, {doing}"), bodies, states);
            sequence.verify();
            if bench {
                let [without, with, again] = times(&sequence);
                println!(
                    "{:20} {without:8.1} {with:8.1} {again:8.1}   {:.2} {:.2}",
                    sequence.name,
                    with / without,
                    again / without
                );
            }
        }
    }
    println!("demanded: at most four times; runs of the wedge box with friction, as parts of those without");
    for scheme in ["rim-nonsmooth", "rim-nonsmooth-gap", "rim-smooth", "zero-order-hold"] {
        let specs = [spec("wedge-box", scheme, &[]), spec("wedge-box-friction", scheme, &[])];
        if bench {
            let mut seconds = [(); 2].map(|()| Vec::with_capacity(TURNS));
            for _ in 0..TURNS {
                specs.iter().zip(&mut seconds).for_each(|(spec, seconds)| seconds.push(run(spec)));
            }
            let [without, with] = seconds.map(|seconds| median(seconds).unwrap_or(f64::NAN));
            println!("{scheme:20} {:.2}", with / without);
        }
    }
}
