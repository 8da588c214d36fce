//! What a corpus is made of.

use rimbench_core::complementarity::Lcp;
use rimbench_core::friction::FrictionProblem;
use std::sync::Arc;

/// What both kinds of problems are to a corpus.
pub trait Posed: Clone {
    /// First bytes of a file of such problems.
    const MAGIC: &'static [u8; 8];
    /// Unknowns per contact: a normal impulse, and one along the surface where there is friction.
    const UNKNOWNS: usize;

    /// A problem by its matrix, right-hand side and coefficients of friction, none where there is no friction.
    fn of(matrix: Arc<[f64]>, right: Vec<f64>, friction: Vec<f64>) -> Self;

    /// The matrix, row-major, 1/kg.
    fn matrix(&self) -> &Arc<[f64]>;

    /// The right-hand side, m/s.
    fn right(&self) -> &[f64];

    /// The coefficient of each contact, or none.
    fn friction(&self) -> &[f64];

    /// All unknowns.
    fn unknowns(&self) -> usize {
        self.right().len()
    }

    /// Contacts.
    fn contacts(&self) -> usize {
        self.unknowns() / Self::UNKNOWNS
    }

    /// Whether no impulse is a solution.
    fn is_solved_by_zero(&self) -> bool {
        self.right()[..self.contacts()].iter().all(|right| *right >= 0.0)
    }
}

/// One problem `w = H P + b`, `0 ≤ w ⟂ P ≥ 0`, as a solver was given it.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactProblem {
    /// `n×n`, row-major, 1/kg; shared with the problem before where it is the same.
    pub h: Arc<[f64]>,
    /// Length `n`, m/s.
    pub b: Vec<f64>,
}

impl ContactProblem {
    /// The problem as solvers take it.
    pub fn lcp(&self) -> Lcp<'_> {
        Lcp::new(&self.h, &self.b)
    }
}

impl Posed for ContactProblem {
    const MAGIC: &'static [u8; 8] = b"RIMLCP1\n";
    const UNKNOWNS: usize = 1;

    fn of(h: Arc<[f64]>, b: Vec<f64>, _friction: Vec<f64>) -> Self {
        ContactProblem { h, b }
    }

    fn matrix(&self) -> &Arc<[f64]> {
        &self.h
    }

    fn right(&self) -> &[f64] {
        &self.b
    }

    fn friction(&self) -> &[f64] {
        &[]
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
        FrictionProblem::with_friction(&self.h, &self.b, &self.friction)
    }
}

impl Posed for FrictionalProblem {
    const MAGIC: &'static [u8; 8] = b"RIMFRI1\n";
    const UNKNOWNS: usize = 2;

    fn of(h: Arc<[f64]>, b: Vec<f64>, friction: Vec<f64>) -> Self {
        FrictionalProblem { h, b, friction }
    }

    fn matrix(&self) -> &Arc<[f64]> {
        &self.h
    }

    fn right(&self) -> &[f64] {
        &self.b
    }

    fn friction(&self) -> &[f64] {
        &self.friction
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
