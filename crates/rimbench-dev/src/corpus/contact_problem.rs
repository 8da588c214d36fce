//! What a corpus is made of.

use rimbench_core::complementarity::Lcp;
use std::sync::Arc;

/// One problem `w = M z + q`, `0 ≤ w ⟂ z ≥ 0`, as a solver was given it.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactProblem {
    /// `n×n`, row-major, 1/kg; shared with the problem before where it is the same.
    pub m: Arc<[f64]>,
    /// Length `n`, m/s.
    pub q: Vec<f64>,
}

impl ContactProblem {
    /// The problem as solvers take it.
    pub fn lcp(&self) -> Lcp<'_> {
        Lcp::new(&self.m, &self.q)
    }
}

/// Problems that one solver was given one after the other, apart from those without contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Case, settings, scheme, macro step, and which of the run's solvers.
    pub source: String,
    /// How many problems that solver had been given before, with and without contact.
    pub first: u64,
    /// The problems; never empty.
    pub problems: Vec<ContactProblem>,
}

/// Stretches of contact problems from many runs.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Corpus {
    /// In the order of the harvest.
    pub stretches: Vec<Stretch>,
}

impl Corpus {
    /// All problems, in order.
    pub fn problems(&self) -> impl Iterator<Item = &ContactProblem> {
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

    /// Largest `n`.
    pub fn largest(&self) -> usize {
        self.problems().map(|problem| problem.q.len()).max().unwrap_or(0)
    }

    /// Only the stretches whose source begins with `prefix`.
    pub fn of_source(&self, prefix: &str) -> Corpus {
        let stretches = self.stretches.iter().filter(|stretch| stretch.source.starts_with(prefix));
        Corpus { stretches: stretches.cloned().collect() }
    }
}
