//! Problems of hundreds of contacts, of which few are coupled: too large for a file, so made from their cases whenever they are asked for.

use crate::panel::Clarabel;
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::runs::{RunRequest, simulate};
use rimbench_core::complementarity::{ComplementaritySolver, Lcp, SolveStats, SparseLcp, SparseSolver, Unsolved};
use rimbench_core::cosim::{Bounds, Outcome, StopFlag};
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::ReducedInterfaceModel;
use rimbench_core::linear_algebra::{SymmetricPattern, SymmetricRows};
use rimbench_core::name::Name;
use rimbench_core::solver_entry::SolverEntry;
use rimbench_statistics::Pool;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A case at one size.
#[derive(Debug, Clone, Copy)]
pub struct LargeSystem {
    /// The case.
    pub case: &'static str,
    /// Keys and values, as in `--set`.
    pub settings: &'static [(&'static str, &'static str)],
    /// Length of the run that poses the problems, s.
    pub duration_s: f64,
}

const fn of(case: &'static str, settings: &'static [(&'static str, &'static str)], duration_s: f64) -> LargeSystem {
    LargeSystem { case, settings, duration_s }
}

/// From 65 to 1560 possible contacts; of each case from the smallest on. Discs of large heaps and packings are lighter, or the cylinder
/// could not hold them.
pub const LARGE_SYSTEMS: &[LargeSystem] = &[
    of("disc-row", &[("discs", "32"), ("disc_gap_m", "0"), ("wall_gap_m", "0")], 0.25),
    of("disc-row", &[("discs", "128"), ("disc_gap_m", "0"), ("wall_gap_m", "0")], 0.25),
    of("disc-row", &[("discs", "512"), ("disc_gap_m", "0"), ("wall_gap_m", "0")], 0.25),
    of("disc-pile", &[("columns", "8"), ("layers", "6"), ("wall_gap_m", "0")], 0.25),
    of("disc-pile", &[("columns", "10"), ("layers", "8"), ("wall_gap_m", "0")], 0.25),
    of("disc-pile", &[("columns", "15"), ("layers", "12"), ("wall_gap_m", "0")], 0.25),
    of("disc-pile", &[("columns", "22"), ("layers", "18"), ("wall_gap_m", "0"), ("disc_mass_kg", "10")], 0.25),
    of("falling-chain", &[("links", "40")], 0.6),
    of("falling-chain", &[("links", "128")], 0.6),
    of("falling-chain", &[("links", "512")], 0.6),
    of("packed-box", &[("columns", "6"), ("layers", "6"), ("disc_mass_kg", "5")], 0.4),
    of("packed-box", &[("columns", "10"), ("layers", "12"), ("disc_mass_kg", "2")], 0.4),
    of("packed-box", &[("columns", "20"), ("layers", "20"), ("disc_mass_kg", "0.5")], 0.4),
];

/// Stretches of a run, evenly over it, and problems in each.
const STRETCHES: usize = 4;
const PROBLEMS: usize = 6;
/// A solver is given what it can solve of a system in this time, but one problem at least if it is likely to be done with that by then.
const LIMIT: Duration = Duration::from_secs(5);
/// Time goes with this power of the number of contacts, in guessing whether it is: that of a dense factorisation.
const POWER: f64 = 3.0;
/// A stretch is repeated until it has taken this long, but at least once and at most so many times.
const ENOUGH: Duration = Duration::from_millis(20);
const REPETITIONS: usize = 11;

/// One problem of a [`LargeCorpus`].
#[derive(Debug, Clone, PartialEq)]
struct LargeProblem {
    /// Entries of `H` where the pattern says, 1/kg.
    entries: Vec<f64>,
    /// m/s.
    b: Vec<f64>,
}

/// Stretches of consecutive problems that the mechanics of one system poses.
#[derive(Debug, Clone)]
pub struct LargeCorpus {
    /// The system.
    pub system: LargeSystem,
    pattern: Arc<SymmetricPattern>,
    stretches: Vec<Vec<LargeProblem>>,
}

impl LargeCorpus {
    /// Runs a system and poses the problems of its mechanics under the forces of that run, each held over its macro step.
    ///
    /// # Errors
    /// Parameters that the case does not have; [`Error::Incompatible`] if the run does not complete or keeps every entry of its matrices.
    pub fn of(system: LargeSystem) -> Result<Self> {
        let set = system.settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        let request =
            RunRequest { set, duration_s: Some(system.duration_s), ..RunRequest::of(system.case, "rim-nonsmooth-gap") };
        let spec = request.resolve(&Catalogue::standard())?;
        let refused = |why: &str| Error::Incompatible(format!("{} {:?}: {why}", system.case, system.settings));
        let run = simulate(&spec, Bounds::default(), None, StopFlag::never())?;
        let column =
            run.trajectory.index_of("force_to_mechanics_n").filter(|_| run.report.outcome == Outcome::Completed);
        let column = column.ok_or_else(|| refused("the run does not complete"))?;
        let forces: Vec<f64> = run.trajectory.column(column).collect();
        let mut mechanics = (spec.case.build)(&spec.parameters, &spec.solver)?.sides.mechanics;
        let mut model = mechanics.capabilities().empty_interface_model().ok_or_else(|| refused("has no model"))?;
        let pattern = model.delassus_pattern().cloned().ok_or_else(|| refused("keeps every entry of its matrices"))?;
        let steps = (spec.macro_step / spec.micro_step).round().max(1.0);
        let (h, steps) = (spec.macro_step / steps, steps as usize);
        let every = forces.len().div_ceil(STRETCHES).max(1);
        let mut stretches = Vec::new();
        for (point, &force) in forces.iter().enumerate() {
            let mut stretch = Vec::new();
            for step in 0..steps {
                if point % every == every / 2 && step < PROBLEMS {
                    mechanics
                        .capabilities()
                        .interface_model(h, &mut model)
                        .map_err(|failure| refused(&failure.to_string()))?;
                    stretch.extend(LargeProblem::of(&model, force));
                }
                mechanics.step(0.0, &[force], h).map_err(|failure| refused(&failure.to_string()))?;
            }
            stretches.extend((!stretch.is_empty()).then_some(stretch));
        }
        Ok(LargeCorpus { system, pattern, stretches })
    }

    /// Returns the number of possible contacts.
    pub fn contacts(&self) -> usize {
        self.pattern.size()
    }

    /// Returns the number of problems.
    pub fn len(&self) -> usize {
        self.stretches.iter().map(Vec::len).sum()
    }

    /// Tells whether nothing ever touched.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl LargeProblem {
    /// The problem of the mechanics' next step under this force (N), if there is one.
    ///
    /// ```text
    /// b = w + h a + H_ui h λ + gap term
    /// ```
    fn of(model: &ReducedInterfaceModel, force: f64) -> Option<Self> {
        let (rows, pushed, h) = (model.contact_rows()?, model.interface_column(0)?, model.mechanics_step);
        let b = |contact: usize| {
            model.w[contact] + h * (model.a[contact] + pushed[contact] * force) + model.step_gap_velocity(contact)
        };
        let b: Vec<f64> = (0..model.contacts()).map(b).collect();
        b.iter().any(|b| *b < 0.0).then(|| LargeProblem { entries: rows.entries.to_vec(), b })
    }

    fn dense(&self, pattern: &SymmetricPattern) -> Vec<f64> {
        let n = self.b.len();
        let mut h = vec![0.0; n * n];
        let rows = SymmetricRows { pattern, entries: &self.entries };
        for i in 0..n {
            rows.row(i).for_each(|(j, entry)| h[i * n + j] = entry);
        }
        h
    }
}

/// Who is given large problems.
pub struct Contestant {
    name: Name,
    tolerance: f64,
    /// Whether it is given whole matrices.
    wants_whole: bool,
    /// Begins with problems of a pattern, knowing nothing.
    start: Box<dyn Fn(&SymmetricPattern) -> Attempt>,
}

/// Solves one problem, given what is not zero in its matrix and, where wanted, the whole of it.
type Attempt = Box<dyn FnMut(SymmetricRows<'_>, &[f64], &[f64], &mut [f64]) -> Result<SolveStats, Unsolved>>;

impl Contestant {
    /// What simulations have, the active set on a sparse factor; Clarabel, given what is not zero; then the given solvers.
    pub fn with(others: &[Arc<SolverEntry>]) -> Vec<Self> {
        let tolerance = SolverEntry::active_set().tolerance;
        let sparse = Contestant {
            name: "active-set (sparse)".into(),
            tolerance,
            wants_whole: false,
            start: Box::new(move |pattern| {
                let mut solver = SparseSolver::new(pattern, tolerance);
                Box::new(move |rows, _, b, impulses| solver.solve(SparseLcp::by_pattern(rows, b), impulses))
            }),
        };
        let clarabel = Contestant {
            name: "clarabel (sparse)".into(),
            tolerance: 1e-7,
            wants_whole: false,
            start: Box::new(|_| {
                let mut solver = Clarabel::new();
                Box::new(move |rows, _, b, impulses| solver.attempt_rows(rows, b, impulses))
            }),
        };
        let dense = |entry: &Arc<SolverEntry>| {
            let build = entry.build.clone();
            Contestant {
                name: entry.name.clone(),
                tolerance: entry.tolerance,
                wants_whole: true,
                start: Box::new(move |pattern| {
                    let mut solver = build(pattern.size());
                    Box::new(move |_, whole, b, impulses| solver.attempt(Lcp::new(whole, b), impulses))
                }),
            }
        };
        let others = others.iter().filter(|solver| solver.name != "enumeration").map(dense);
        [sparse, clarabel].into_iter().chain(others).collect()
    }
}

/// What a contestant made of a corpus.
#[derive(Debug, Clone, PartialEq)]
pub struct LargeReplay {
    /// Who.
    pub solver: Name,
    /// Problems that it was given before its time was over.
    pub given: usize,
    /// Those whose answer has a natural residual within its tolerance.
    pub solved: usize,
    /// The worst residual of these.
    pub worst_residual: f64,
    /// Pivots or iterations of all.
    pub pivots: u64,
    /// Median time of those solved, ns; the check is not in it, but for the sparse active set, which has one of its own.
    pub median_ns: f64,
    /// The longest, ns.
    pub longest_ns: f64,
}

/// Gives a corpus to a contestant: each stretch from nothing, and its later problems from the ones before.
///
/// Every answer is judged by the natural residual, by the same function for all. `before` is what it made of a smaller one: whoever is
/// likely to take more than the limit for a single problem is given none.
pub fn replay_large(
    corpus: &LargeCorpus,
    contestant: &Contestant,
    before: Option<(usize, &LargeReplay)>,
) -> LargeReplay {
    let nothing = LargeReplay {
        solver: contestant.name.clone(),
        given: 0,
        solved: 0,
        worst_residual: f64::NAN,
        pivots: 0,
        median_ns: f64::NAN,
        longest_ns: f64::NAN,
    };
    let likely = before.map(|(contacts, replay)| {
        let growth = (corpus.contacts() as f64 / contacts as f64).powf(POWER);
        if replay.given == 0 { f64::INFINITY } else { growth * replay.longest_ns }
    });
    if likely.is_some_and(|likely| likely > LIMIT.as_nanos() as f64) {
        return nothing;
    }
    let (started, mut replay, mut times) = (Instant::now(), nothing, Vec::new());
    let mut impulses = vec![0.0; corpus.contacts()];
    for stretch in &corpus.stretches {
        // Whole matrices are made outside the clock, and only for those who want them.
        let wants = contestant.wants_whole;
        let dense: Vec<Vec<f64>> =
            stretch.iter().map(|p| if wants { p.dense(&corpus.pattern) } else { Vec::new() }).collect();
        let mut of_problems = vec![Vec::new(); stretch.len()];
        let (began, mut spent) = (Instant::now(), 0);
        while spent == 0 || (spent < REPETITIONS && began.elapsed() < ENOUGH) {
            let mut solve = (contestant.start)(&corpus.pattern);
            for (at, (problem, dense)) in stretch.iter().zip(&dense).enumerate() {
                if spent == 0 && started.elapsed() > LIMIT {
                    break;
                }
                let rows = SymmetricRows { pattern: &corpus.pattern, entries: &problem.entries };
                let clock = Instant::now();
                let found = solve(rows, dense, &problem.b, &mut impulses);
                let time = clock.elapsed().as_nanos() as f64;
                if spent == 0 {
                    replay.given += 1;
                    // The longest is also that of an answer that was none.
                    replay.longest_ns = replay.longest_ns.max(time);
                    let whole = if wants { dense.clone() } else { problem.dense(&corpus.pattern) };
                    let residual = Lcp::new(&whole, &problem.b).natural_residual(&impulses);
                    let Ok(stats) = found else { continue };
                    replay.pivots += u64::from(stats.pivots);
                    if residual > contestant.tolerance {
                        continue;
                    }
                    replay.solved += 1;
                    replay.worst_residual = replay.worst_residual.max(residual);
                    of_problems[at].push(time);
                } else if !of_problems[at].is_empty() {
                    of_problems[at].push(time);
                }
            }
            spent += 1;
        }
        times.extend(of_problems.into_iter().filter_map(|times| Pool::of(times).median()));
    }
    replay.median_ns = Pool::of(times).median().unwrap_or(f64::NAN);
    replay
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_problems_are_solved_alike_by_those_that_keep_what_is_not_zero_and_those_given_all_of_it() {
        let corpus = LargeCorpus::of(LARGE_SYSTEMS[0]).unwrap();
        assert_eq!((corpus.contacts(), corpus.len()), (65, STRETCHES * PROBLEMS));
        for contestant in Contestant::with(&[Arc::new(SolverEntry::lemke())]) {
            let replay = replay_large(&corpus, &contestant, None);
            assert!(replay.given > 0 && replay.solved == replay.given, "{replay:?}");
            // Whoever took longer than it is given for a smaller system is given none of this one.
            let slow = LargeReplay { longest_ns: 1e10, ..replay };
            assert_eq!(replay_large(&corpus, &contestant, Some((64, &slow))).given, 0);
        }
    }

    #[test]
    fn large_systems_are_ones_that_their_cases_allow() {
        let catalogue = Catalogue::standard();
        for system in LARGE_SYSTEMS {
            let case = catalogue.case(system.case).unwrap();
            let mut parameters = case.default_parameters();
            system.settings.iter().for_each(|(key, value)| parameters.set(key, value).unwrap());
        }
    }
}
