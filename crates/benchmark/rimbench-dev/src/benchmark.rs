//! A benchmark, and what it counts.

use super::history::COUNTERS;
use rimbench_core::complementarity::SolverCounters;
use rimbench_core::error::Result;

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

/// A benchmark of the suite.
#[derive(Debug, Clone, Copy)]
pub struct Benchmark {
    /// Name in data; of a run its case and its scheme.
    pub name: &'static str,
    /// What [`Work::answer`] must be, and by how much it may differ (round-off of other libraries).
    answer: [f64; 2],
    prepare: fn(&str) -> Result<Repetition>,
}

impl Benchmark {
    pub(super) const fn new(name: &'static str, answer: [f64; 2], prepare: fn(&str) -> Result<Repetition>) -> Self {
        Benchmark { name, answer, prepare }
    }

    /// Sets everything up.
    ///
    /// # Errors
    /// Those of building what is measured: a defect.
    pub fn prepare(&self) -> Result<Repetition> {
        (self.prepare)(self.name)
    }

    /// What is wrong with an answer, if anything.
    pub fn fault(&self, answer: f64) -> Option<String> {
        let [expected, tolerance] = self.answer;
        let right = (answer - expected).abs() <= tolerance;
        (!right).then(|| format!("wrong answer {answer:.6e}, expected {expected:.6e} ± {tolerance:.1e}"))
    }
}
