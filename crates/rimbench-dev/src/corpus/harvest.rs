//! Runs cases that have contacts and keeps stretches of the problems their solvers were given.

use super::contact_problem::{ContactProblem, Corpus, Stretch};
use super::format::{matrix_bytes, same_bits};
use super::recorder::recording;
use super::selection::{Mark, select};
use rimbench_cases::cases::Case;
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::runs::{RunRequest, RunSpec, simulate};
use rimbench_core::complementarity::{Lcp, SolverEntry};
use rimbench_core::cosim::{Bounds, Outcome, StopFlag};
use rimbench_core::error::Result;
use rimbench_core::schemes::ModelOptions;
use std::collections::BTreeMap;
use std::ops::Range;
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

/// Runs every case that has contacts, at its defaults and with its [`VARIATIONS`], under four schemes and two macro
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
    let (mut corpus, catalogue) = (Corpus::default(), Catalogue::standard());
    for case in &plan.cases {
        let variations = VARIATIONS.iter().filter(|variation| variation.case == case.name);
        for settings in std::iter::once(&[][..]).chain(variations.map(|variation| variation.settings)) {
            for scheme in SCHEMES {
                for factor in MACRO_STEPS {
                    let macro_step = factor * case.defaults.macro_step_s;
                    let (spec, source) = run_of(&catalogue, case, settings, scheme, macro_step)?;
                    let mechanics_solvers = solvers_of_mechanics(&spec)?;
                    if mechanics_solvers > 0 {
                        progress(&source);
                        corpus.stretches.extend(stretches_of(
                            &spec,
                            &source,
                            mechanics_solvers,
                            plan.bytes_per_solver,
                        )?);
                    }
                }
            }
        }
    }
    Ok(corpus)
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
    let tapes: Arc<Mutex<BTreeMap<usize, Tape>>> = Arc::default();
    let locked = || tapes.lock().unwrap_or_else(PoisonError::into_inner);
    let on_tape = |note: fn(&mut Tape, Lcp<'_>, &[f64])| {
        let tapes = Arc::clone(&tapes);
        let (solver, _) = recording(move |solver, lcp, z| {
            note(tapes.lock().unwrap_or_else(PoisonError::into_inner).entry(solver).or_default(), lcp, z);
        });
        simulate(&with_solver(spec, &solver), Bounds::default(), None, StopFlag::never())
    };
    if on_tape(Tape::mark)?.report.outcome != Outcome::Completed {
        return Ok(Vec::new());
    }
    for tape in locked().values_mut() {
        tape.rewind(budget);
    }
    on_tape(|tape, lcp, _| tape.keep(lcp))?;
    let name = |solver: usize| if solver < mechanics_solvers { "mechanics" } else { "scheme" };
    let tapes = std::mem::take(&mut *locked()).into_iter();
    Ok(tapes.flat_map(|(solver, tape)| tape.stretches(&format!("{source} {}", name(solver)))).collect())
}

/// The problems of one solver: first all of them, marked; then those chosen.
#[derive(Default)]
struct Tape {
    marks: Vec<Mark>,
    previous: Option<ContactProblem>,
    active: Vec<bool>,
    position: usize,
    chosen: Vec<Range<usize>>,
    kept: Vec<Vec<ContactProblem>>,
}

impl Tape {
    /// The problem with the matrix of the one before, if it is the same.
    fn take(&mut self, lcp: Lcp<'_>) -> (ContactProblem, bool) {
        let shared = self.previous.take().filter(|previous| same_bits(&previous.m, lcp.m)).map(|previous| previous.m);
        let same = shared.is_some();
        (ContactProblem { m: shared.unwrap_or_else(|| lcp.m.into()), q: lcp.q.to_vec() }, same)
    }

    fn mark(&mut self, lcp: Lcp<'_>, z: &[f64]) {
        let n = lcp.q.len();
        let (problem, same_matrix) = self.take(lcp);
        let active: Vec<bool> = z.iter().map(|z| *z > 0.0).collect();
        let matrix_bytes = match self.marks.last() {
            Some(mark) if same_matrix => mark.matrix_bytes,
            _ => matrix_bytes(lcp.m, n),
        };
        let trivial = lcp.q.iter().all(|q| *q >= 0.0);
        self.marks.push(Mark { n, changed: active != self.active, trivial, same_matrix, matrix_bytes });
        (self.previous, self.active) = (Some(problem), active);
    }

    fn rewind(&mut self, budget: usize) {
        self.chosen = select(&self.marks, budget);
        self.kept = self.chosen.iter().map(|stretch| Vec::with_capacity(stretch.len())).collect();
        (self.marks, self.previous, self.position) = (Vec::new(), None, 0);
    }

    fn keep(&mut self, lcp: Lcp<'_>) {
        let position = self.position;
        self.position += 1;
        if let Some(slot) = self.chosen.iter().position(|stretch| stretch.contains(&position)) {
            let (problem, _) = self.take(lcp);
            self.kept[slot].push(problem.clone());
            self.previous = Some(problem);
        }
    }

    /// Problems without contact need no solver and are left out; they were marked, so that the choice is one of the run.
    fn stretches(self, source: &str) -> Vec<Stretch> {
        let with_contact = |problem: &ContactProblem| !problem.q.is_empty();
        let stretch = |(range, problems): (Range<usize>, Vec<ContactProblem>)| {
            let skipped = problems.iter().position(with_contact)?;
            let problems = problems.into_iter().filter(with_contact).collect();
            Some(Stretch { source: source.to_owned(), first: (range.start + skipped) as u64, problems })
        };
        self.chosen.into_iter().zip(self.kept).filter_map(stretch).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_without_contact_are_left_out_and_the_others_keep_their_place() {
        let mut tape = Tape { chosen: vec![3..8, 9..11], kept: vec![Vec::new(); 2], ..Tape::default() };
        for position in 0..12 {
            let (m, q) = ([1.0], [f64::from(position)]);
            let contacts = usize::from(![3, 4, 6, 9, 10].contains(&position));
            tape.keep(Lcp::new(&m[..contacts], &q[..contacts]));
        }
        let stretches = tape.stretches("ball");
        let q: Vec<f64> = stretches[0].problems.iter().map(|problem| problem.q[0]).collect();
        assert_eq!((stretches.len(), stretches[0].first, q), (1, 5, vec![5.0, 7.0]));
    }
}
