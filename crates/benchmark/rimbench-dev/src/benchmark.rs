//! A benchmark, and what it counts.

use super::history::COUNTERS;
use rimbench_core::complementarity::SolverCounters;
use rimbench_core::cosim::{Bounds, Outcome, StopFlag, Trajectory};
use rimbench_core::error::{Error, Result};
use rimbench_core::name::Name;
use rimbench_harness::monotonic_clock;
use rimbench_runs::{RunSpec, simulate};

/// What one repetition of a benchmark did.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// Macro steps.
    pub macro_steps: u64,
    /// Micro steps of the mechanics.
    pub mechanics_micro_steps: u64,
    /// Micro steps of the actuator.
    pub actuator_micro_steps: u64,
    /// Eliminations Eq. 3 → Eq. 4.
    pub eliminations: u64,
    /// Complementarity work of both sides.
    pub lcp: SolverCounters,
    /// A number that must come out.
    pub answer: f64,
}

impl Work {
    /// Counts in the order of [`COUNTERS`].
    pub fn counters(&self) -> [u64; COUNTERS.len()] {
        let SolverCounters { solves, pivots, factorisations, fallbacks, .. } = self.lcp;
        let [mechanics, actuator] = [self.mechanics_micro_steps, self.actuator_micro_steps];
        [self.macro_steps, mechanics, actuator, self.eliminations, solves, pivots, factorisations, fallbacks]
    }
}

/// One repetition, ready to be done; as often as one likes, with the same answer and the same work.
pub type Repetition = Box<dyn FnMut() -> Result<Work>>;

/// What a benchmark does.
#[derive(Debug, Clone)]
enum Measured {
    /// What the suite has by this name.
    BuiltIn(fn(&str) -> Result<Repetition>),
    /// A run.
    Run(Box<RunSpec>),
}

/// A benchmark of the suite, or a run that a file names.
#[derive(Debug, Clone)]
pub struct Benchmark {
    /// Name in data; of a run its case and its scheme.
    pub name: Name,
    /// What [`Work::answer`] must be, and by how much it may differ (round-off of other libraries); none: any number.
    answer: Option<[f64; 2]>,
    measured: Measured,
}

impl Benchmark {
    pub(super) const fn new(name: &'static str, answer: [f64; 2], prepare: fn(&str) -> Result<Repetition>) -> Self {
        Benchmark { name: Name::Borrowed(name), answer: Some(answer), measured: Measured::BuiltIn(prepare) }
    }

    /// Makes a benchmark of a run, which has to complete.
    pub fn of_run((name, spec): (String, RunSpec)) -> Self {
        Benchmark { name: name.into(), answer: None, measured: Measured::Run(Box::new(spec)) }
    }

    /// Sets everything up.
    ///
    /// # Errors
    /// Those of building what is measured: a defect.
    pub fn prepare(&self) -> Result<Repetition> {
        match &self.measured {
            Measured::BuiltIn(prepare) => prepare(&self.name),
            Measured::Run(spec) => Ok(whole_run(RunSpec::clone(spec))),
        }
    }

    /// What is wrong with an answer, if anything.
    pub fn fault(&self, answer: f64) -> Option<String> {
        let Some([expected, tolerance]) = self.answer else {
            return (!answer.is_finite()).then(|| "the run does not complete".to_owned());
        };
        let right = (answer - expected).abs() <= tolerance;
        (!right).then(|| format!("wrong answer {answer:.6e}, expected {expected:.6e} ± {tolerance:.1e}"))
    }
}

/// A run, whose answer is the mean of its interface force, N.
pub(super) fn whole_run(spec: RunSpec) -> Repetition {
    Box::new(move || {
        let result = simulate(&spec, Bounds::default(), Some(monotonic_clock), StopFlag::never())?;
        let work = &result.report.work;
        let mut lcp = work.sides.mechanics.solver;
        lcp.add(&work.scheme);
        let completed = result.report.outcome == Outcome::Completed;
        // Schemes that agree on the peak to all digits still differ in the mean: the answer tells them apart.
        let forces = forces(&result.trajectory, &spec.case.interface_columns[0].force)?;
        Ok(Work {
            macro_steps: work.cosim.macro_steps,
            mechanics_micro_steps: work.sides.mechanics.micro_steps,
            actuator_micro_steps: work.sides.actuator.micro_steps,
            eliminations: work.sides.mechanics.eliminations,
            lcp,
            answer: if completed { forces.sum::<f64>() / result.trajectory.len() as f64 } else { f64::NAN },
        })
    })
}

pub(super) fn forces(trajectory: &Trajectory, column: &str) -> Result<impl Iterator<Item = f64>> {
    let names = || trajectory.columns().iter().map(String::as_str);
    let index = trajectory.index_of(column).ok_or_else(|| Error::unknown("column", column, names()))?;
    Ok(trajectory.column(index))
}
