//! All combinations of states, one after the other.

use super::active_states::solve_states;
use super::{ContactState, FrictionProblem, StateSystem};
use crate::complementarity::{SolveStats, Unsolved};

/// Contacts up to which all combinations are tried: 4⁵ are 1024.
pub const ENUMERATION_LIMIT: usize = 5;

/// One of the solutions of a problem.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionSolution {
    /// State of each contact.
    pub states: Vec<ContactState>,
    /// `[P_n; P_t]`, N·s.
    pub impulses: Vec<f64>,
}

/// Tries every combination of states: finds a solution whenever there is one.
///
/// Open before stick before slip, the first contact fastest: of several solutions the first within the tolerance is
/// taken, always that one.
#[derive(Debug, Clone)]
pub struct Enumeration {
    system: StateSystem,
    trial: Vec<f64>,
    states: Vec<ContactState>,
}

impl Enumeration {
    /// Makes room for this many contacts, or as many as it takes on.
    pub fn new(contacts: usize) -> Self {
        let n = contacts.min(ENUMERATION_LIMIT);
        Enumeration { system: StateSystem::new(n), trial: vec![0.0; 2 * n], states: vec![ContactState::Open; n] }
    }

    /// Writes the impulses and states of the first combination with a natural residual up to `tolerance`, or of the
    /// best.
    ///
    /// # Errors
    /// [`Unsolved::TooLarge`] above [`ENUMERATION_LIMIT`].
    pub fn attempt(
        &mut self,
        problem: FrictionProblem<'_>,
        tolerance: f64,
        states: &mut [ContactState],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let mut best = f64::INFINITY;
        let mut tried = 0;
        self.visit(problem, |combination, trial, residual| {
            tried += 1;
            if residual < best {
                best = residual;
                impulses.copy_from_slice(trial);
                states.copy_from_slice(combination);
            }
            residual <= tolerance
        })?;
        Ok(SolveStats { pivots: tried, factorisations: tried, ..SolveStats::default() })
    }

    /// Lists all solutions with a natural residual up to `tolerance`, with their states.
    ///
    /// # Errors
    /// [`Unsolved::TooLarge`] above [`ENUMERATION_LIMIT`].
    pub fn solutions(
        &mut self,
        problem: FrictionProblem<'_>,
        tolerance: f64,
    ) -> Result<Vec<FrictionSolution>, Unsolved> {
        let mut found = Vec::new();
        self.visit(problem, |combination, trial, residual| {
            if residual <= tolerance {
                found.push(FrictionSolution { states: combination.to_vec(), impulses: trial.to_vec() });
            }
            false
        })?;
        Ok(found)
    }

    /// Shows every combination, its impulses and their residual, until `show` returns that it is enough.
    fn visit(
        &mut self,
        problem: FrictionProblem<'_>,
        mut enough: impl FnMut(&[ContactState], &[f64], f64) -> bool,
    ) -> Result<(), Unsolved> {
        let n = problem.contacts();
        if n > ENUMERATION_LIMIT {
            return Err(Unsolved::TooLarge { size: n });
        }
        if self.states.len() < n {
            *self = Enumeration::new(n);
        }
        let Enumeration { system, trial, states } = self;
        let (states, trial) = (&mut states[..n], &mut trial[..2 * n]);
        for combination in 0..1_usize << (2 * n) {
            for (contact, state) in states.iter_mut().enumerate() {
                *state = ContactState::ALL[combination >> (2 * contact) & 3];
            }
            // Without friction a contact is open or closed.
            let redundant = |(state, mu): (&ContactState, &f64)| {
                *mu == 0.0 && matches!(state, ContactState::Stick | ContactState::SlipNegative)
            };
            if states.iter().zip(problem.cone.friction).any(redundant) {
                continue;
            }
            solve_states(system, problem, states, trial);
            if enough(states, trial, problem.natural_residual(trial)) {
                return Ok(());
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_state_tried_before_the_one_that_holds_counts_as_a_pivot_and_a_factorisation() {
        let h = [1.0, 0.0, 0.0, 1.0];
        for (b, holds) in [[1.0, 0.0], [-1.0, 0.2], [-1.0, 2.0], [-1.0, -2.0]].into_iter().zip(ContactState::ALL) {
            let problem = FrictionProblem::with_friction(&h, &b, &[0.5]);
            let mut states = [ContactState::Open];
            let stats = Enumeration::new(1).attempt(problem, 1e-12, &mut states, &mut [0.0; 2]).unwrap();
            let tried = holds.as_number() as u32 + 1;
            assert_eq!((states, stats.pivots, stats.factorisations), ([holds], tried, tried));
        }
    }
}
