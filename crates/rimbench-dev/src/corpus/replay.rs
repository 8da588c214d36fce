//! Gives a corpus to a solver and measures what it does.

use super::contact_problem::{Corpus, FrictionalCorpus, Problem, Stretch};
use super::friction_method::{BareFriction, FrictionMethod};
use rimbench_core::complementarity::{ComplementaritySolver, SolveStats, Solver, Unsolved};
use rimbench_core::name::Name;
use rimbench_core::solver_entry::SolverEntry;
use rimbench_statistics::Pool;
use std::hint::black_box;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What a solver knows when it is given a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// The problems of the stretch before this one.
    Warm,
    /// Nothing.
    Cold,
}

/// What a solver made of one problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solve {
    /// Contacts.
    pub n: usize,
    /// Pivots, factorisations, and the natural residual.
    pub stats: SolveStats,
    /// The residual is within the solver's tolerance.
    pub solved: bool,
    /// The solver refuses problems of this size.
    pub refused: bool,
    /// Median wall time of a solve with its check, without the clock, ns.
    pub time_ns: f64,
}

/// What a solver made of a corpus.
#[derive(Debug, Clone)]
pub struct Replay {
    /// The solver's name.
    pub solver: Name,
    /// What it knew.
    pub start: Start,
    /// One per problem, in the order of the corpus.
    pub solves: Vec<Solve>,
    /// Mean wall time of a solve with its check where whole stretches are timed, ns: without the clock's resolution.
    pub mean_ns: f64,
    /// What the solver said when it panicked, a defect; then none of the problems counts as solved.
    pub panic: Option<String>,
}

impl Replay {
    /// Time of each problem, ns, +∞ where it was not solved; faster than the clock can tell is one nanosecond.
    pub fn costs(&self) -> Vec<f64> {
        self.solves.iter().map(|solve| if solve.solved { solve.time_ns.max(1.0) } else { f64::INFINITY }).collect()
    }
}

/// A stretch is repeated until it has taken this long, but at least once and at most [`REPETITIONS`] times.
const ENOUGH: Duration = Duration::from_millis(10);
const REPETITIONS: usize = 31;

/// Gives every problem to the bare solver, without the fallback, and judges each answer by the natural residual.
///
/// A solver that panics fails at every problem, and the others are none the worse for it.
///
/// Everything but the times is the same at every call. A time is the median over repetitions of the whole stretch, so
/// that a warm start always has the same past; the clock's own time, measured first, is subtracted.
pub fn replay(corpus: &Corpus, solver: &Arc<SolverEntry>, start: Start) -> Replay {
    let build = || (solver.build)(corpus.largest());
    caught(corpus, &solver.name, solver.tolerance, start, build)
}

/// Does the same with problems that have friction and a method that solves them.
pub fn replay_with_friction(corpus: &FrictionalCorpus, method: FrictionMethod, start: Start) -> Replay {
    let build = || method.build(corpus.largest());
    caught(corpus, &method.name(), FrictionMethod::TOLERANCE, start, build)
}

/// A solver without its fallback.
trait Bare<const FRICTION: bool> {
    /// Forgets the problems before.
    fn reset(&mut self);

    /// Writes impulses, and says how good they are.
    fn solve(&mut self, problem: &Problem<FRICTION>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved>;
}

impl Bare<false> for Solver {
    fn reset(&mut self) {
        ComplementaritySolver::reset(self);
    }

    fn solve(&mut self, problem: &Problem<false>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        ComplementaritySolver::solve(self, black_box(problem.lcp()), impulses)
    }
}

impl Bare<true> for BareFriction {
    fn reset(&mut self) {
        self.forget();
    }

    fn solve(&mut self, problem: &Problem<true>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        self.attempt(black_box(problem.problem()), impulses)
    }
}

/// A solver that panics fails at every problem.
fn caught<const FRICTION: bool, B: Bare<FRICTION>>(
    corpus: &Corpus<FRICTION>,
    name: &Name,
    tolerance: f64,
    start: Start,
    build: impl Fn() -> B,
) -> Replay {
    let replayed = catch_unwind(AssertUnwindSafe(|| replay_or_panic(corpus, name, tolerance, start, build())));
    replayed.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        let failed = |problem: &Problem<FRICTION>| judge(problem.contacts(), Err(Unsolved::NonFinite), tolerance);
        let solves = corpus.problems().map(failed).collect();
        let panic = Some(text.unwrap_or("no message").to_owned());
        Replay { solver: name.clone(), start, solves, mean_ns: f64::NAN, panic }
    })
}

fn replay_or_panic<const FRICTION: bool, B: Bare<FRICTION>>(
    corpus: &Corpus<FRICTION>,
    name: &Name,
    tolerance: f64,
    start: Start,
    mut bare: B,
) -> Replay {
    let mut impulses = vec![0.0; corpus.problems().map(Problem::unknowns).max().unwrap_or(0)];
    let clock_ns = clock_ns();
    let solves = Vec::with_capacity(corpus.len());
    let mut replay = Replay { solver: name.clone(), start, solves, mean_ns: f64::NAN, panic: None };
    let (mut total_ns, mut count) = (0.0, 0.0);
    for stretch in &corpus.stretches {
        let first = replay.solves.len();
        let began = Instant::now();
        pass(stretch, &mut bare, start, &mut impulses, |n, result, _| replay.solves.push(judge(n, result, tolerance)));
        let repetitions =
            (ENOUGH.as_secs_f64() / began.elapsed().as_secs_f64()).clamp(1.0, REPETITIONS as f64) as usize;
        let mut times = vec![Vec::with_capacity(repetitions); stretch.problems.len()];
        let mut whole = Vec::with_capacity(repetitions);
        for _ in 0..repetitions {
            let mut column = times.iter_mut();
            pass(stretch, &mut bare, start, &mut impulses, |_, _, elapsed| {
                if let Some(times) = column.next() {
                    times.push(elapsed.as_nanos() as f64 - clock_ns);
                }
            });
            whole.push(untimed_pass_ns(stretch, &mut bare, start, &mut impulses));
        }
        for (solve, times) in replay.solves[first..].iter_mut().zip(&mut times) {
            solve.time_ns = median_of(std::mem::take(times)).max(0.0);
        }
        total_ns += median_of(whole);
        count += stretch.problems.len() as f64;
    }
    replay.mean_ns = total_ns / count;
    replay
}

/// One pass over a stretch, with a clock around every solve.
fn pass<const FRICTION: bool>(
    stretch: &Stretch<FRICTION>,
    solver: &mut impl Bare<FRICTION>,
    start: Start,
    impulses: &mut [f64],
    mut done: impl FnMut(usize, Result<SolveStats, Unsolved>, Duration),
) {
    solver.reset();
    for problem in &stretch.problems {
        if start == Start::Cold {
            solver.reset();
        }
        let began = Instant::now();
        let result = solver.solve(problem, &mut impulses[..problem.unknowns()]);
        let elapsed = began.elapsed();
        done(problem.contacts(), result, elapsed);
    }
}

/// One pass over a stretch, with a clock around the whole.
fn untimed_pass_ns<const FRICTION: bool>(
    stretch: &Stretch<FRICTION>,
    solver: &mut impl Bare<FRICTION>,
    start: Start,
    impulses: &mut [f64],
) -> f64 {
    solver.reset();
    let began = Instant::now();
    for problem in &stretch.problems {
        if start == Start::Cold {
            solver.reset();
        }
        black_box(solver.solve(problem, &mut impulses[..problem.unknowns()])).ok();
    }
    began.elapsed().as_nanos() as f64
}

fn judge(n: usize, result: Result<SolveStats, Unsolved>, tolerance: f64) -> Solve {
    let unsolved = SolveStats { residual: f64::INFINITY, ..SolveStats::default() };
    let refused = matches!(result, Err(Unsolved::TooLarge { .. }));
    let stats = result.unwrap_or(unsolved);
    Solve { n, stats, solved: stats.residual <= tolerance, refused, time_ns: f64::NAN }
}

/// What reading the clock twice takes.
fn clock_ns() -> f64 {
    let readings: Vec<f64> = (0..1001)
        .map(|_| {
            let began = Instant::now();
            black_box(());
            began.elapsed().as_nanos() as f64
        })
        .collect();
    median_of(readings)
}

fn median_of(times: Vec<f64>) -> f64 {
    Pool::of(times).median().unwrap_or(f64::NAN)
}
