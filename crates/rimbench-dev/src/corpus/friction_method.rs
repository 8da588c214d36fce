//! The methods for contacts with friction, each without the others behind it, and all in turn.

use super::contact_problem::FrictionalCorpus;
use rimbench_core::complementarity::{SolveStats, Unsolved};
use rimbench_core::friction::{
    ActiveStates, ContactState, ContactSweeps, CopositiveLemke, ENUMERATION_LIMIT, Enumeration, FrictionProblem,
    FrictionSolver, StateMethod,
};
use rimbench_core::name::{Name, by_name};

/// A method for contacts with friction. Each is asked only where no impulse is no solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrictionMethod {
    /// The active set of states, from those of the problem before.
    ActiveStates,
    /// All combinations of states, up to five contacts.
    Enumeration,
    /// Lemke on the copositive problem.
    Lemke,
    /// One contact after the other.
    Sweeps,
    /// What a simulation has: the first, and the others in turn where its answer is not good enough.
    InTurn,
}

by_name!(FrictionMethod, NAMES, "solver of contacts with friction");

impl FrictionMethod {
    /// All of them, by name.
    pub const NAMES: [(&str, FrictionMethod); 5] = [
        ("active-states", FrictionMethod::ActiveStates),
        ("enumeration", FrictionMethod::Enumeration),
        ("lemke", FrictionMethod::Lemke),
        ("sweeps", FrictionMethod::Sweeps),
        ("in-turn", FrictionMethod::InTurn),
    ];

    /// Natural residual up to which an answer counts: that of simulations.
    pub const TOLERANCE: f64 = 1e-9;

    /// Far below, for those that can be asked for a residual.
    const WANTED: f64 = 1e-12;

    /// Returns the name.
    pub fn name(self) -> Name {
        Name::Borrowed(Self::NAMES[self as usize].0)
    }

    /// Makes room for this many contacts.
    pub(super) fn build(self, contacts: usize) -> BareFriction {
        let method = match self {
            FrictionMethod::ActiveStates => Method::States(ActiveStates::new(contacts)),
            FrictionMethod::Enumeration => Method::All(Enumeration::new(contacts)),
            FrictionMethod::Lemke => Method::Lemke(Box::new(CopositiveLemke::new(contacts))),
            FrictionMethod::Sweeps => Method::Sweeps,
            FrictionMethod::InTurn => Method::InTurn(Box::new(FrictionSolver::new(contacts, Self::TOLERANCE))),
        };
        BareFriction { method, states: Vec::with_capacity(contacts) }
    }
}

/// One of them with its states.
pub(super) struct BareFriction {
    method: Method,
    states: Vec<ContactState>,
}

enum Method {
    States(ActiveStates),
    All(Enumeration),
    Lemke(Box<CopositiveLemke>),
    Sweeps,
    InTurn(Box<FrictionSolver>),
}

impl BareFriction {
    /// Forgets the problems before.
    pub(super) fn forget(&mut self) {
        self.states.clear();
        if let Method::InTurn(solver) = &mut self.method {
            solver.reset();
        }
    }

    /// Writes impulses and says what it took; the residual is recomputed here unless the method has done that.
    pub(super) fn attempt(&mut self, problem: FrictionProblem<'_>, p: &mut [f64]) -> Result<SolveStats, Unsolved> {
        if let Method::InTurn(solver) = &mut self.method {
            return solver.solve(problem, p);
        }
        let n = problem.contacts();
        if self.states.len() != n {
            self.states.clear();
            self.states.resize(n, ContactState::Open);
        }
        if problem.is_solved_by_zero()? {
            p.fill(0.0);
            self.states.fill(ContactState::Open);
            return Ok(SolveStats::default());
        }
        let (states, wanted) = (&mut self.states[..], FrictionMethod::WANTED);
        let attempted = match &mut self.method {
            Method::States(solver) => {
                let attempted = solver.attempt(problem, false, states, p);
                if attempted.is_err() {
                    // Whatever was tried last is no good start.
                    states.fill(ContactState::Open);
                }
                return attempted;
            }
            Method::All(solver) => solver.attempt(problem, wanted, states, p),
            Method::Lemke(solver) => solver.attempt(problem, states, p),
            Method::Sweeps | Method::InTurn(_) => ContactSweeps.attempt(problem, wanted, states, p),
        };
        let residual = problem.natural_residual(p);
        match attempted {
            // Sweeps that stop above what they were asked for may be good enough.
            Err(Unsolved::NotFound { .. }) if residual <= FrictionMethod::TOLERANCE => {
                Ok(SolveStats { residual, ..SolveStats::default() })
            }
            attempted => Ok(SolveStats { residual, ..attempted? }),
        }
    }
}

/// How far the problems of a corpus are from having several solutions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uniqueness {
    /// Problems with so few contacts that all solutions can be listed.
    pub listed: usize,
    /// Of these, those with solutions whose velocities differ by more than 1e-6 of `‖b‖_∞`.
    pub several: usize,
    /// Of these, those with solutions that differ in impulses only, by more than 1e-6 of the largest.
    pub several_impulses: usize,
    /// Of these, those in which no combination of states is a solution.
    pub none: usize,
    /// Least `min (H_nn − μ |H_nt|)/H_nn` of all problems: at 0 and below a contact can be pushed in by its own friction.
    pub least_margin: f64,
    /// Problems in which that is not above 0.
    pub beyond_painleve: usize,
}

impl Uniqueness {
    /// Lists the solutions of every problem that has few enough contacts.
    pub fn of(corpus: &FrictionalCorpus) -> Self {
        let mut found = Uniqueness {
            listed: 0,
            several: 0,
            several_impulses: 0,
            none: 0,
            least_margin: f64::INFINITY,
            beyond_painleve: 0,
        };
        let mut enumeration = Enumeration::new(ENUMERATION_LIMIT);
        for problem in corpus.problems() {
            let posed = problem.problem();
            let margin = posed.painleve_margin();
            found.least_margin = found.least_margin.min(margin);
            found.beyond_painleve += usize::from(margin <= 0.0);
            let Ok(solutions) = enumeration.solutions(posed, FrictionMethod::TOLERANCE) else { continue };
            found.listed += 1;
            let velocities = |impulses: &[f64]| {
                let mut w = vec![0.0; problem.b.len()];
                posed.velocities(impulses, &mut w);
                w
            };
            let Some((first, others)) = solutions.split_first() else {
                found.none += 1;
                continue;
            };
            let w = velocities(&first.impulses);
            let largest = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let differs = |x: &[f64], y: &[f64], bound: f64| x.iter().zip(y).any(|(x, y)| (x - y).abs() > bound);
            let bound = 1e-6 * posed.scale();
            let most = solutions.iter().map(|solution| largest(&solution.impulses)).fold(0.0, f64::max);
            if others.iter().any(|other| differs(&velocities(&other.impulses), &w, bound)) {
                found.several += 1;
            } else if others.iter().any(|other| differs(&other.impulses, &first.impulses, 1e-6 * most)) {
                found.several_impulses += 1;
            }
        }
        found
    }
}
