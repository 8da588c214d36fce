//! An entry of a list of solvers.

use crate::complementarity::{ActiveSet, Checked, Lemke, Solver};
use crate::friction::FrictionSolver;
use std::borrow::Cow;
use std::fmt;
use std::sync::Arc;

/// Builds a bare solver with room for problems up to the given size.
pub type BuildSolver = Arc<dyn Fn(usize) -> Solver + Send + Sync>;

/// A solver that can be named in an experiment.
#[derive(Clone)]
pub struct SolverEntry {
    /// The name in data, for example `active-set`.
    pub name: Cow<'static, str>,
    /// The idea in a sentence.
    pub about: Cow<'static, str>,
    /// The class of problems it is guaranteed to solve in exact arithmetic.
    pub guaranteed: Cow<'static, str>,
    /// Natural residual up to which an answer is accepted.
    pub tolerance: f64,
    /// True if a rejected problem is given to `lemke`.
    pub fallback: bool,
    /// Digest of its code, a part of what determines a run; none of what is built in.
    pub digest: Option<Cow<'static, str>>,
    /// Builds the bare solver with room for problems up to the given `n`.
    pub build: BuildSolver,
    /// True if contacts with friction go with it, which a [solver over their states](FrictionSolver) solves in its
    /// place.
    pub with_friction: bool,
}

impl fmt::Debug for SolverEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SolverEntry").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Default for SolverEntry {
    fn default() -> Self {
        SolverEntry::active_set()
    }
}

impl SolverEntry {
    /// Builds the solver behind the check and with the fallback its entry states.
    pub fn checked(&self, capacity: usize) -> Checked {
        let fallback = self.fallback.then(|| Lemke::new(capacity));
        Checked::wrap((self.build)(capacity), fallback, self.tolerance)
    }

    /// Builds the solver of contacts with friction behind the check, with its fallbacks; none if they do not go with
    /// this one.
    pub fn checked_with_friction(&self, contacts: usize) -> Option<FrictionSolver> {
        self.with_friction.then(|| FrictionSolver::new(contacts, self.tolerance))
    }

    /// Tells whether it goes from one active set to the next, as the default does.
    pub fn goes_by_active_sets(&self) -> bool {
        (self.build)(0).goes_by_active_sets()
    }

    /// Describes the default of simulations.
    pub fn active_set() -> Self {
        SolverEntry {
            name: "active-set".into(),
            about: "symmetric principal pivoting (Keller) from the last active set; the real-time default".into(),
            guaranteed: "symmetric positive semidefinite, feasible".into(),
            tolerance: 1e-9,
            fallback: true,
            digest: None,
            build: Arc::new(|capacity| Solver::ActiveSet(Box::new(ActiveSet::new(capacity)))),
            with_friction: true,
        }
    }

    /// Describes the fallback of the others.
    pub fn lemke() -> Self {
        SolverEntry {
            name: "lemke".into(),
            about: "Lemke's complementary pivoting with the lexicographic rule; no warm start".into(),
            guaranteed: "positive semidefinite, feasible".into(),
            tolerance: 1e-9,
            fallback: false,
            digest: None,
            build: Arc::new(|capacity| Solver::other(Lemke::new(capacity))),
            with_friction: false,
        }
    }
}

/// Describes the solvers that simulations need, the default first.
pub fn standard_solvers() -> Vec<SolverEntry> {
    vec![SolverEntry::active_set(), SolverEntry::lemke()]
}
