//! The solver of contacts with friction that a simulation holds.

use super::{ActiveStates, ContactState, ContactSweeps, CopositiveLemke, Enumeration, FrictionProblem};
use crate::complementarity::{Checked, ProposeImpulses, SolveStats, Unsolved};
use crate::problem::{Coulomb, DenseDelassus};

/// Sweeps over all contacts after which the method gives up.
const MOST_SWEEPS: u32 = 5000;

/// The states of the last problem, and the method that goes on from them.
#[derive(Debug, Clone)]
pub struct WarmStates {
    method: ActiveStates,
    states: Vec<ContactState>,
    /// Of the last problem.
    len: usize,
}

impl WarmStates {
    /// Returns the states of the last problem.
    #[inline]
    pub fn states(&self) -> &[ContactState] {
        &self.states[..self.len]
    }

    /// Sets the states from which the next problem starts.
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
}

impl ProposeImpulses for WarmStates {
    type Delassus<'a> = DenseDelassus<'a>;
    type Cone<'a> = Coulomb<'a>;
    type Fallback = ColdMethods;

    #[inline]
    fn propose(
        &mut self,
        problem: FrictionProblem<'_>,
        same_matrix: bool,
        tolerance: f64,
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let n = problem.contacts();
        if n != self.len {
            self.start_from((0..n).map(|_| ContactState::Open));
        }
        let stats = self.method.attempt(problem, same_matrix, &mut self.states[..n], impulses)?;
        within(stats, tolerance)
    }

    fn fall_back(
        &mut self,
        cold: &mut ColdMethods,
        turn: u32,
        problem: FrictionProblem<'_>,
        tolerance: f64,
        impulses: &mut [f64],
    ) -> Option<Result<SolveStats, Unsolved>> {
        // Far below what is accepted, so that the first solution is not one that only nearly is.
        let (wanted, states) = (1e-3 * tolerance, &mut self.states[..self.len]);
        let attempted = match turn {
            0 => cold.enumeration.attempt(problem, wanted, states, impulses),
            1 => cold.lemke.attempt(problem, states, impulses),
            2 => cold.sweep(problem, wanted, states, impulses),
            _ => return None,
        };
        let residual = problem.natural_residual(impulses);
        Some(match attempted {
            Ok(stats) => within(SolveStats { residual, ..stats }, tolerance),
            Err(_) => Err(Unsolved::NotFound { residual }),
        })
    }

    fn reset(&mut self) {
        self.states.fill(ContactState::Open);
    }
}

/// Only the work of accepted proposals counts: changes of state of one are no measure of another.
#[inline]
fn within(stats: SolveStats, tolerance: f64) -> Result<SolveStats, Unsolved> {
    if stats.residual <= tolerance { Ok(stats) } else { Err(Unsolved::NotFound { residual: stats.residual }) }
}

/// The methods that start from nothing.
#[derive(Debug, Clone)]
pub struct ColdMethods {
    enumeration: Enumeration,
    lemke: CopositiveLemke,
    sweeps: ContactSweeps,
}

impl ColdMethods {
    /// Sweeps from zero.
    fn sweep(
        &mut self,
        problem: FrictionProblem<'_>,
        tolerance: f64,
        states: &mut [ContactState],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        impulses.fill(0.0);
        let (pivots, residual) = self.sweeps.sweep(problem, tolerance, MOST_SWEEPS, impulses);
        ContactState::write_of_impulses(problem, impulses, states);
        within(SolveStats { pivots, residual, ..SolveStats::default() }, tolerance)
    }
}

/// Solves one problem after the other, each from the states of the last; every answer is measured by the natural
/// residual.
///
/// `P = 0` where that is a solution. Else the [`ActiveStates`]; where their answer is not good enough, [`Enumeration`]
/// (up to five contacts), [`CopositiveLemke`] and [`ContactSweeps`] in turn. Free of allocation up to the number of
/// contacts it was made for.
pub type FrictionSolver = Checked<WarmStates>;

impl FrictionSolver {
    /// Makes room for this many contacts; accepts natural residuals up to `tolerance`.
    pub fn new(contacts: usize, tolerance: f64) -> Self {
        let method = ActiveStates::new(contacts);
        let solver = WarmStates { method, states: vec![ContactState::Open; contacts], len: 0 };
        let (enumeration, lemke) = (Enumeration::new(contacts), CopositiveLemke::new(contacts));
        let fallback = ColdMethods { enumeration, lemke, sweeps: ContactSweeps::new(contacts) };
        Checked::wrap(solver, fallback, tolerance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// To stick, the contact would need 1e-4 N·s more than its friction gives.
    #[test]
    fn a_state_that_only_nearly_holds_is_passed_over_for_one_that_does() {
        let problem = FrictionProblem::with_friction(&[1.0, 0.0, 0.0, 1.0], &[-1.0, 0.5 + 1e-4], &[0.5]);
        let mut cold = ColdMethods {
            enumeration: Enumeration::new(1),
            lemke: CopositiveLemke::new(1),
            sweeps: ContactSweeps::new(1),
        };
        let states = vec![ContactState::Open];
        let mut solver = WarmStates { method: ActiveStates::new(1), states, len: 1 };
        let (tolerance, mut impulses) = (1e-3, [0.0; 2]);
        assert!(problem.natural_residual(&[1.0, -0.5 - 1e-4]) < tolerance);
        let found = solver.fall_back(&mut cold, 0, problem, tolerance, &mut impulses);
        assert!(found.is_some_and(|found| found.is_ok()) && solver.states == [ContactState::SlipPositive]);
        assert_eq!(impulses, [1.0, -0.5]);
    }
}
