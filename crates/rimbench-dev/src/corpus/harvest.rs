//! Runs cases that have contacts and keeps stretches of the problems their solvers were given.

use super::contact_problem::{ContactProblem, Corpus, FrictionalCorpus, FrictionalProblem, Stretch};
use super::recorder::{recording, recording_friction};
use super::tape::Tape;
use rimbench_cases::cases::{Case, Contacts, ParameterSet, Parameters};
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::runs::{RunRequest, RunSpec, simulate};
use rimbench_core::complementarity::Lcp;
use rimbench_core::cosim::{Bounds, Outcome, StopFlag};
use rimbench_core::error::Result;
use rimbench_core::friction::{ContactState, FrictionProblem};
use rimbench_core::schemes::ModelOptions;
use rimbench_core::solver_entry::SolverEntry;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Parameters of a case that a harvest sets, besides a harvest at the defaults.
#[derive(Debug, Clone, Copy)]
pub struct Variation {
    /// The case.
    pub case: &'static str,
    /// Keys and values, as in `--set`.
    pub settings: &'static [(&'static str, &'static str)],
}

/// What is varied. Cases that are not listed here are harvested at their defaults.
pub const VARIATIONS: &[Variation] = &[
    Variation { case: "wedge-box", settings: &[("restitution", "0.5")] },
    Variation { case: "wedge-box", settings: &[("ledge_height_m", "0.03"), ("disc_mass_kg", "150")] },
    Variation { case: "wedge-box-two-ledges", settings: &[("restitution", "0.3")] },
    Variation { case: "n-wedge-box", settings: &[("supports", "2")] },
    Variation { case: "n-wedge-box", settings: &[("supports", "3")] },
    Variation { case: "n-wedge-box", settings: &[("supports", "16")] },
    Variation { case: "n-wedge-box", settings: &[("supports", "32")] },
    Variation { case: "n-wedge-box", settings: &[("supports", "64")] },
    Variation { case: "n-wedge-box", settings: &[("washboard_height_m", "0.01")] },
    Variation { case: "disc-row", settings: &[("discs", "4")] },
    Variation { case: "disc-row", settings: &[("discs", "24")] },
    Variation { case: "disc-row", settings: &[("discs", "48")] },
    Variation { case: "disc-pile", settings: &[("columns", "4"), ("layers", "3")] },
    Variation { case: "disc-pile", settings: &[("columns", "7"), ("layers", "5")] },
    Variation { case: "disc-pile", settings: &[("columns", "8"), ("layers", "6")] },
    Variation { case: "half-car", settings: &[("restitution", "0.3")] },
    Variation { case: "gripper", settings: &[("box_mass_kg", "500")] },
];

/// The same for the cases with friction, which are harvested apart.
pub const FRICTION_VARIATIONS: &[Variation] = &[
    Variation { case: "wedge-box-friction", settings: &[("friction", "0.5")] },
    Variation { case: "wedge-box-friction", settings: &[("friction", "0.3"), ("ledge_lead_m", "0")] },
    Variation { case: "rocking-block-friction", settings: &[("friction", "0.15")] },
    Variation { case: "slider-crank", settings: &[("friction", "0.3")] },
    Variation { case: "slider-crank", settings: &[("restitution", "0.4"), ("tangential_restitution", "0.4")] },
    Variation { case: "woodpecker", settings: &[("restitution", "0")] },
];

/// Schemes that differ in what their complementarity problems look like: none in the scheme, contacts closed at `t_k`,
/// all contacts with gaps, one problem per macro step.
const SCHEMES: [&str; 4] = ["zero-order-hold", "rim-nonsmooth", "rim-nonsmooth-gap", "rim-smooth-active"];
/// Macro steps, as multiples of the case's own.
const MACRO_STEPS: [f64; 2] = [0.2, 1.0];

/// What to harvest.
#[derive(Debug, Clone)]
pub struct Harvest {
    /// The cases; those without contacts contribute nothing.
    pub cases: Vec<Arc<Case>>,
    /// Bytes of the file that the problems of one solver of one run may take; one problem is kept in any case.
    pub bytes_per_solver: usize,
}

impl Default for Harvest {
    fn default() -> Self {
        Harvest { cases: Catalogue::standard().cases().to_vec(), bytes_per_solver: 6000 }
    }
}

impl Harvest {
    /// What the corpus of problems with friction is made by: these problems are all small.
    pub fn with_friction() -> Self {
        Harvest { bytes_per_solver: 1500, ..Harvest::default() }
    }
}

/// Runs every case that has contacts without friction, at its defaults and with its [`VARIATIONS`], under four schemes and two macro
/// steps, and keeps stretches of the problems of every solver; `progress` is told the source of each run.
///
/// Runs that do not complete are left out: their last problems are those of a state that has left all bounds. So are
/// problems without contact, which a solver is given while nothing is closed. Each run
/// is made twice, once to choose and once to keep, so that memory does not grow with its length. The same program gives
/// the same corpus to the last bit.
///
/// # Errors
/// A variation that the case does not allow.
pub fn harvest(plan: &Harvest, progress: &mut dyn FnMut(&str)) -> Result<Corpus> {
    let mut corpus = Corpus::default();
    for_every_run(plan, VARIATIONS, |spec, source| {
        if has_friction(&spec.parameters) {
            return Ok(());
        }
        let mechanics_solvers = solvers_of_mechanics(spec)?;
        if mechanics_solvers > 0 {
            progress(source);
            corpus.stretches.extend(stretches_of(spec, source, mechanics_solvers, plan.bytes_per_solver)?);
        }
        Ok(())
    })?;
    Ok(corpus)
}

/// Does the same for the cases that have friction, with the [`FRICTION_VARIATIONS`].
///
/// Micro steps of a model that go on with their states pose no problem, and are not among them.
///
/// # Errors
/// A variation that the case does not allow.
pub fn harvest_with_friction(plan: &Harvest, progress: &mut dyn FnMut(&str)) -> Result<FrictionalCorpus> {
    let mut corpus = Corpus::default();
    for_every_run(plan, FRICTION_VARIATIONS, |spec, source| {
        if has_friction(&spec.parameters) {
            progress(source);
            corpus.stretches.extend(frictional_stretches_of(spec, source, plan.bytes_per_solver)?);
        }
        Ok(())
    })?;
    Ok(corpus)
}

/// Whether the case has friction with these parameters.
fn has_friction(parameters: &Parameters) -> bool {
    Contacts::read(parameters).friction > 0.0
}

/// Every case at its defaults and with its variations, under all schemes and macro steps.
fn for_every_run(
    plan: &Harvest,
    variations: &[Variation],
    mut run: impl FnMut(&RunSpec, &str) -> Result<()>,
) -> Result<()> {
    let catalogue = Catalogue::standard();
    for case in &plan.cases {
        let variations = variations.iter().filter(|variation| variation.case == case.name);
        for settings in std::iter::once(&[][..]).chain(variations.map(|variation| variation.settings)) {
            for scheme in SCHEMES {
                for factor in MACRO_STEPS {
                    let macro_step = factor * case.defaults.macro_step_s;
                    let (spec, source) = run_of(&catalogue, case, settings, scheme, macro_step)?;
                    run(&spec, &source)?;
                }
            }
        }
    }
    Ok(())
}

/// A run, and what to call it.
fn run_of(
    catalogue: &Catalogue,
    case: &Arc<Case>,
    settings: &[(&str, &str)],
    scheme: &str,
    macro_step: f64,
) -> Result<(RunSpec, String)> {
    let mut parameters = case.default_parameters();
    let mut source = case.name.clone().into_owned();
    for (key, value) in settings {
        parameters.set(key, value)?;
        source += &format!(" {key}={value}");
    }
    source += &format!(" {scheme} H={macro_step}");
    let request = RunRequest { macro_step_s: Some(macro_step), ..RunRequest::of(&*case.name, scheme) };
    Ok((request.resolve_for(catalogue, case, &parameters)?, source))
}

/// The run with another solver on both sides.
fn with_solver(spec: &RunSpec, solver: &Arc<SolverEntry>) -> RunSpec {
    let model = spec.model.clone().map(|model| ModelOptions { solver: solver.clone(), ..model });
    RunSpec { solver: solver.clone(), model, ..spec.clone() }
}

/// How many solvers the mechanics of a run builds; none if it has no contacts.
fn solvers_of_mechanics(spec: &RunSpec) -> Result<usize> {
    let (solver, built) = recording(|_, _, _| {});
    (spec.case.build)(&spec.parameters, &solver).map(|_| built.count())
}

/// The stretches of one run that are kept.
fn stretches_of(spec: &RunSpec, source: &str, mechanics_solvers: usize, budget: usize) -> Result<Vec<Stretch>> {
    let tapes: Tapes<false, Vec<bool>> = Tapes::default();
    let run = |note: fn(&mut Tape<false, Vec<bool>>, Lcp<'_>, &[f64])| {
        let tapes = tapes.clone();
        let (solver, _) = recording(move |solver, lcp, impulses| tapes.of(solver, |tape| note(tape, lcp, impulses)));
        completes(&with_solver(spec, &solver))
    };
    if !run(|tape, lcp, impulses| tape.mark(problem_of(lcp), impulses.iter().map(|p| *p > 0.0).collect()))? {
        return Ok(Vec::new());
    }
    tapes.rewind(budget);
    run(|tape, lcp, _| tape.keep(|| problem_of(lcp)))?;
    Ok(tapes.stretches(source, mechanics_solvers))
}

fn problem_of(lcp: Lcp<'_>) -> ContactProblem {
    ContactProblem { h: lcp.h().into(), b: lcp.b.to_vec(), friction: Vec::new() }
}

/// The same with friction, where a change is one of states.
fn frictional_stretches_of(spec: &RunSpec, source: &str, budget: usize) -> Result<Vec<Stretch<true>>> {
    let (solver, built) = recording_friction(|_, _, _| {});
    (spec.case.build)(&spec.parameters, &solver)?;
    let mechanics_solvers = built.count();
    let tapes: Tapes<true, Vec<ContactState>> = Tapes::default();
    let run = |note: fn(&mut Tape<true, Vec<ContactState>>, FrictionProblem<'_>, &[f64])| {
        let tapes = tapes.clone();
        let (solver, _) = recording_friction(move |solver, problem, p| tapes.of(solver, |tape| note(tape, problem, p)));
        completes(&with_solver(spec, &solver))
    };
    if !run(|tape, problem, p| tape.mark(frictional_problem_of(problem), states_of(problem, p)))? {
        return Ok(Vec::new());
    }
    tapes.rewind(budget);
    run(|tape, problem, _| tape.keep(|| frictional_problem_of(problem)))?;
    Ok(tapes.stretches(source, mechanics_solvers))
}

fn frictional_problem_of(problem: FrictionProblem<'_>) -> FrictionalProblem {
    FrictionalProblem { h: problem.h().into(), b: problem.b.to_vec(), friction: problem.cone.friction.to_vec() }
}

fn states_of(problem: FrictionProblem<'_>, impulses: &[f64]) -> Vec<ContactState> {
    let (p_n, p_t) = impulses.split_at(problem.contacts());
    let state = |((p_n, p_t), mu): ((&f64, &f64), &f64)| ContactState::of_impulses(*p_n, *p_t, *mu);
    p_n.iter().zip(p_t).zip(problem.cone.friction).map(state).collect()
}

fn completes(spec: &RunSpec) -> Result<bool> {
    let run = simulate(spec, Bounds::default(), None, StopFlag::never())?;
    Ok(run.report.outcome == Outcome::Completed)
}

/// The tapes of all solvers of a run, in the order in which these were built.
struct Tapes<const FRICTION: bool, S>(Arc<Mutex<BTreeMap<usize, Tape<FRICTION, S>>>>);

impl<const FRICTION: bool, S> Default for Tapes<FRICTION, S> {
    fn default() -> Self {
        Tapes(Arc::default())
    }
}

impl<const FRICTION: bool, S> Clone for Tapes<FRICTION, S> {
    fn clone(&self) -> Self {
        Tapes(Arc::clone(&self.0))
    }
}

impl<const FRICTION: bool, S: PartialEq> Tapes<FRICTION, S> {
    fn of(&self, solver: usize, note: impl FnOnce(&mut Tape<FRICTION, S>)) {
        note(self.0.lock().unwrap_or_else(PoisonError::into_inner).entry(solver).or_default());
    }

    fn rewind(&self, budget: usize) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).values_mut().for_each(|tape| tape.rewind(budget));
    }

    fn stretches(&self, source: &str, mechanics_solvers: usize) -> Vec<Stretch<FRICTION>> {
        let name = |solver: usize| if solver < mechanics_solvers { "mechanics" } else { "scheme" };
        let tapes = std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner)).into_iter();
        tapes.flat_map(|(solver, tape)| tape.stretches(&format!("{source} {}", name(solver)))).collect()
    }
}
