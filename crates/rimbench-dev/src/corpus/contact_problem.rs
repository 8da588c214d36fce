//! What a corpus is made of.

use rimbench_core::complementarity::Lcp;
use rimbench_core::friction::FrictionProblem;
use std::sync::Arc;

/// One problem as a solver was given it: `w = H P + b`, `0 ≤ w ⟂ P ≥ 0`; with `FRICTION` under Coulomb's law, normal rows before
/// tangential ones.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Problem<const FRICTION: bool> {
    /// One row per unknown, row-major, 1/kg; shared with the problem before where it is the same.
    pub h: Arc<[f64]>,
    /// One per unknown, m/s.
    pub b: Vec<f64>,
    /// Coefficient of each contact; none without friction.
    pub friction: Vec<f64>,
}

/// A problem without friction.
pub type ContactProblem = Problem<false>;
/// A problem with friction.
pub type FrictionalProblem = Problem<true>;

impl<const FRICTION: bool> Problem<FRICTION> {
    /// First bytes of a file of such problems.
    pub(super) const MAGIC: &'static [u8; 8] = if FRICTION { b"RIMFRI1\n" } else { b"RIMLCP1\n" };
    /// Unknowns per contact: a normal impulse, and one along the surface where there is friction.
    pub(super) const UNKNOWNS: usize = if FRICTION { 2 } else { 1 };

    /// All unknowns.
    pub fn unknowns(&self) -> usize {
        self.b.len()
    }

    /// Contacts.
    pub fn contacts(&self) -> usize {
        self.unknowns() / Self::UNKNOWNS
    }

    /// Whether no impulse is a solution.
    pub(super) fn is_solved_by_zero(&self) -> bool {
        self.b[..self.contacts()].iter().all(|right| *right >= 0.0)
    }
}

impl ContactProblem {
    /// The problem as solvers take it.
    pub fn lcp(&self) -> Lcp<'_> {
        Lcp::new(&self.h, &self.b)
    }
}

impl FrictionalProblem {
    /// The problem as solvers take it.
    pub fn problem(&self) -> FrictionProblem<'_> {
        FrictionProblem::with_friction(&self.h, &self.b, &self.friction)
    }
}

/// Problems that one solver was given one after the other, apart from those without contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch<const FRICTION: bool = false> {
    /// Case, settings, scheme, macro step, and which of the run's solvers.
    pub source: String,
    /// How many problems that solver had been given before, with and without contact.
    pub first: u64,
    /// The problems; never empty.
    pub problems: Vec<Problem<FRICTION>>,
}

/// Stretches of contact problems from many runs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Corpus<const FRICTION: bool = false> {
    /// In the order of the harvest.
    pub stretches: Vec<Stretch<FRICTION>>,
}

/// A corpus of problems with friction.
pub type FrictionalCorpus = Corpus<true>;

impl<const FRICTION: bool> Corpus<FRICTION> {
    /// All problems, in order.
    pub fn problems(&self) -> impl Iterator<Item = &Problem<FRICTION>> {
        self.stretches.iter().flat_map(|stretch| &stretch.problems)
    }

    /// Number of problems.
    pub fn len(&self) -> usize {
        self.problems().count()
    }

    /// True if there is no problem.
    pub fn is_empty(&self) -> bool {
        self.stretches.is_empty()
    }

    /// Most contacts of a problem.
    pub fn largest(&self) -> usize {
        self.problems().map(Problem::contacts).max().unwrap_or(0)
    }

    /// Only the stretches whose source begins with `prefix`.
    pub fn of_source(&self, prefix: &str) -> Self {
        let stretches = self.stretches.iter().filter(|stretch| stretch.source.starts_with(prefix));
        Corpus { stretches: stretches.cloned().collect() }
    }
}
