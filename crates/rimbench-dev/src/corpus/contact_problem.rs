//! What a corpus is made of.

use rimbench_core::complementarity::Lcp;
use rimbench_core::friction::FrictionProblem;
use std::sync::Arc;

/// What both kinds of problems are to a corpus.
pub trait Posed: Clone {
    /// Contacts.
    fn contacts(&self) -> usize;

    /// Unknowns: a normal impulse of each, and one along the surface where there is friction.
    fn unknowns(&self) -> usize;

    /// Whether no impulse is a solution.
    fn is_solved_by_zero(&self) -> bool;

    /// The matrix.
    fn matrix(&self) -> &Arc<[f64]>;

    /// The same problem with this matrix, which is the same to the bit.
    fn with_matrix(self, matrix: Arc<[f64]>) -> Self;
}

/// One problem `w = M z + q`, `0 ≤ w ⟂ z ≥ 0`, as a solver was given it.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactProblem {
    /// `n×n`, row-major, 1/kg; shared with the problem before where it is the same.
    pub m: Arc<[f64]>,
    /// Length `n`, m/s.
    pub q: Vec<f64>,
}

impl Posed for ContactProblem {
    fn contacts(&self) -> usize {
        self.q.len()
    }

    fn unknowns(&self) -> usize {
        self.q.len()
    }

    fn is_solved_by_zero(&self) -> bool {
        self.q.iter().all(|q| *q >= 0.0)
    }

    fn matrix(&self) -> &Arc<[f64]> {
        &self.m
    }

    fn with_matrix(self, m: Arc<[f64]>) -> Self {
        ContactProblem { m, ..self }
    }
}

/// One problem with friction, as a solver was given it: `w = H P + b` under Coulomb's law, normal rows before tangential ones.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionalProblem {
    /// `2n×2n`, row-major, 1/kg; shared with the problem before where it is the same.
    pub h: Arc<[f64]>,
    /// Length `2n`, m/s.
    pub b: Vec<f64>,
    /// Coefficient of each contact.
    pub friction: Vec<f64>,
}

impl FrictionalProblem {
    /// The problem as solvers take it.
    pub fn problem(&self) -> FrictionProblem<'_> {
        FrictionProblem { h: &self.h, b: &self.b, friction: &self.friction }
    }
}

impl Posed for FrictionalProblem {
    fn contacts(&self) -> usize {
        self.friction.len()
    }

    fn unknowns(&self) -> usize {
        self.b.len()
    }

    fn is_solved_by_zero(&self) -> bool {
        self.b[..self.friction.len()].iter().all(|b| *b >= 0.0)
    }

    fn matrix(&self) -> &Arc<[f64]> {
        &self.h
    }

    fn with_matrix(self, h: Arc<[f64]>) -> Self {
        FrictionalProblem { h, ..self }
    }
}

impl ContactProblem {
    /// The problem as solvers take it.
    pub fn lcp(&self) -> Lcp<'_> {
        Lcp::new(&self.m, &self.q)
    }
}

/// Problems that one solver was given one after the other, apart from those without contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch<P = ContactProblem> {
    /// Case, settings, scheme, macro step, and which of the run's solvers.
    pub source: String,
    /// How many problems that solver had been given before, with and without contact.
    pub first: u64,
    /// The problems; never empty.
    pub problems: Vec<P>,
}

/// Stretches of contact problems from many runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Corpus<P = ContactProblem> {
    /// In the order of the harvest.
    pub stretches: Vec<Stretch<P>>,
}

impl<P> Default for Corpus<P> {
    fn default() -> Self {
        Corpus { stretches: Vec::new() }
    }
}

impl<P: Posed> Corpus<P> {
    /// All problems, in order.
    pub fn problems(&self) -> impl Iterator<Item = &P> {
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
        self.problems().map(P::contacts).max().unwrap_or(0)
    }

    /// Only the stretches whose source begins with `prefix`.
    pub fn of_source(&self, prefix: &str) -> Self {
        let stretches = self.stretches.iter().filter(|stretch| stretch.source.starts_with(prefix));
        Corpus { stretches: stretches.cloned().collect() }
    }
}
