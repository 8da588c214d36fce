//! A benchmark, and what it counts.

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
    /// Floating-point operations of elimination and complementarity, from the counters by dense operation counts.
    pub flops_estimate: u64,
    /// A number that must come out.
    pub answer: f64,
}

/// One repetition, ready to be done; as often as one likes, with the same answer and the same work.
pub type Repetition = Box<dyn FnMut() -> Result<Work>>;

/// A benchmark of the suite.
#[derive(Debug, Clone, Copy)]
pub struct Benchmark {
    /// Name in data.
    pub name: &'static str,
    /// One line.
    pub about: &'static str,
    /// What [`Work::answer`] must be, and by how much it may differ (round-off of other libraries).
    pub answer: [f64; 2],
    /// Sets everything up.
    pub prepare: fn() -> Result<Repetition>,
}

impl Benchmark {
    /// What is wrong with an answer, if anything.
    pub fn fault(&self, answer: f64) -> Option<String> {
        let [expected, tolerance] = self.answer;
        let right = (answer - expected).abs() <= tolerance;
        (!right).then(|| format!("wrong answer {answer:.6e}, expected {expected:.6e} ± {tolerance:.1e}"))
    }
}

/// Size of the mechanics of a case.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Size {
    /// Velocities n.
    pub n: u64,
    /// Joint rows n_b.
    pub bilateral: u64,
    /// Contacts n_u.
    pub contacts: u64,
    /// Interface rows n_i.
    pub interface: u64,
}

pub(super) const WEDGE_BOX: Size = Size { n: 6, bilateral: 2, contacts: 4, interface: 1 };
impl Size {
    /// Estimates the floating-point operations of eliminations and complementarity problems, all rows taken as dense.
    ///
    /// ```text
    /// elimination     S 2 n n_b² · Cholesky n_b³/3 · Y 2 n n_b n_c + 2 n_b² n_c · H n n_c (n_c + 1)        n_c = n_u + n_i
    /// solve           w and residual 4 n_u²          pivot 2 n_u²          factorisation n_u³/3
    /// ```
    /// It weighs the counters by their cost; it is no bound (three quarters of the wedge box's rows are zero).
    pub(super) fn flops(self, eliminations: u64, lcp: &SolverCounters) -> u64 {
        let Size { n, bilateral: b, contacts: u, interface: i } = self;
        let c = u + i;
        let elimination = 2 * n * b * b + b.pow(3) / 3 + 2 * n * b * c + 2 * b * b * c + n * c * (c + 1);
        eliminations * elimination + lcp.solves * 4 * u * u + lcp.pivots * 2 * u * u + lcp.factorisations * u.pow(3) / 3
    }
}
