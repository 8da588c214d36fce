//! The solver a simulation holds: checked after every problem, with fallbacks, and counted.

use super::{ActiveStates, ContactState, ContactSweeps, CopositiveLemke, Enumeration, FrictionProblem};
use crate::complementarity::{ProblemRecorder, RecordedProblem, SolveStats, SolverCounters, Unsolved};

/// Solves one problem after the other, each from the states of the last; every answer is measured by the natural residual.
///
/// `P = 0` where that is a solution. Else the [`ActiveStates`]; where their answer is not good enough, [`Enumeration`] (up to five
/// contacts), [`CopositiveLemke`] and [`ContactSweeps`] in turn. Free of allocation up to the number of contacts it was made for.
#[derive(Debug, Clone)]
pub struct FrictionSolver {
    tolerance: f64,
    states: Vec<ContactState>,
    /// Of the last problem.
    len: usize,
    /// Whether the active states have seen the present matrix.
    same_matrix: bool,
    active: ActiveStates,
    enumeration: Enumeration,
    lemke: CopositiveLemke,
    counters: SolverCounters,
    /// Its number, and who is told.
    witness: Option<(usize, ProblemRecorder)>,
}

impl FrictionSolver {
    /// Makes room for this many contacts; accepts natural residuals up to `tolerance`.
    pub fn new(contacts: usize, tolerance: f64) -> Self {
        FrictionSolver {
            tolerance,
            states: vec![ContactState::Open; contacts],
            len: 0,
            same_matrix: false,
            active: ActiveStates::new(contacts),
            enumeration: Enumeration::new(contacts),
            lemke: CopositiveLemke::new(contacts),
            counters: SolverCounters::default(),
            witness: None,
        }
    }

    /// Tells `witness` of every problem and its answer.
    #[inline]
    pub fn recorded_by(self, witness: Option<&ProblemRecorder>) -> Self {
        FrictionSolver { witness: witness.map(|witness| (witness.number(), witness.clone())), ..self }
    }

    /// Returns the natural residual up to which an answer is accepted.
    #[inline]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Returns the states of the last problem.
    #[inline]
    pub fn states(&self) -> &[ContactState] {
        &self.states[..self.len]
    }

    /// Says from which states the next problem starts.
    #[inline]
    pub fn start_from(&mut self, states: impl Iterator<Item = ContactState>) {
        self.len = 0;
        for state in states {
            if self.len == self.states.len() {
                self.states.push(state);
            } else {
                self.states[self.len] = state;
            }
            self.len += 1;
        }
    }

    /// Returns the counts since construction; pivots are changes of states, or what the fallback counts.
    #[inline]
    pub fn counters(&self) -> SolverCounters {
        self.counters
    }

    /// Writes the solution to `impulses`, `[P_n; P_t]`.
    ///
    /// # Errors
    /// [`Unsolved::NotFound`] with the least residual of all attempts: a jam that loads itself, or a problem beyond the methods.
    #[inline]
    pub fn solve(&mut self, problem: FrictionProblem<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        self.same_matrix = false;
        self.solve_again(problem, impulses)
    }

    /// [`solve`](Self::solve) with the matrix and the coefficients of the last problem, whose factor serves again.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    #[inline]
    pub fn solve_again(&mut self, problem: FrictionProblem<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let solved = self.find(problem, impulses);
        if let Some((solver, witness)) = &self.witness {
            let (h, b, friction) = (problem.h(), problem.b, problem.cone.friction);
            witness.tell(RecordedProblem { solver: *solver, h, b, friction, impulses });
        }
        solved
    }

    #[inline]
    fn find(&mut self, problem: FrictionProblem<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let n = problem.contacts();
        if n != self.len {
            self.start_from((0..n).map(|_| ContactState::Open));
        }
        self.counters.solves += 1;
        let states = &mut self.states[..n];
        if problem.is_solved_by_zero()? {
            impulses.fill(0.0);
            states.fill(ContactState::Open);
            return Ok(SolveStats::default());
        }
        let attempted = if std::mem::replace(&mut self.same_matrix, true) {
            self.active.attempt_again(problem, states, impulses)
        } else {
            self.active.attempt(problem, states, impulses)
        };
        let (residual, stats) = match attempted {
            Ok(stats) => (stats.residual, stats),
            Err(_) => (f64::INFINITY, SolveStats::default()),
        };
        if residual <= self.tolerance {
            return Ok(self.accept(SolveStats { residual, ..stats }));
        }
        self.fall_back(problem, impulses, residual)
    }

    fn accept(&mut self, stats: SolveStats) -> SolveStats {
        self.counters.pivots += u64::from(stats.pivots);
        self.counters.factorisations += u64::from(stats.factorisations);
        self.counters.worst_residual = self.counters.worst_residual.max(stats.residual);
        stats
    }

    #[cold]
    fn fall_back(
        &mut self,
        problem: FrictionProblem<'_>,
        impulses: &mut [f64],
        mut least: f64,
    ) -> Result<SolveStats, Unsolved> {
        let n = problem.contacts();
        // Far below what is accepted, so that the first solution is not one that only nearly is.
        let wanted = 1e-3 * self.tolerance;
        self.counters.fallbacks += 1;
        for method in 0..3 {
            let states = &mut self.states[..n];
            let attempted = match method {
                0 => self.enumeration.attempt(problem, wanted, states, impulses),
                1 => self.lemke.attempt(problem, states, impulses),
                _ => ContactSweeps.attempt(problem, wanted, states, impulses),
            };
            let residual = problem.natural_residual(impulses);
            least = least.min(residual);
            if let (Ok(stats), true) = (attempted, residual <= self.tolerance) {
                return Ok(self.accept(SolveStats { fallback: true, residual, ..stats }));
            }
        }
        self.counters.failures += 1;
        // Whatever was tried last is no good start.
        self.states[..n].fill(ContactState::Open);
        Err(Unsolved::NotFound { residual: least })
    }
}
