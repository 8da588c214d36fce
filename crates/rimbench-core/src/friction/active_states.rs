//! The active set of a contact problem with friction: states instead of members.

use super::{ContactState, FrictionProblem, StateSystem};
use crate::complementarity::{SolveStats, Unsolved};

/// Changes of states after which the method gives up: a simulation needs none or one, and on redundant contacts a cold start can cycle.
const MOST_CHANGES: u32 = 12;
/// A violation below this part of `‖b‖_∞` is rounding; the accepted residual is 1e-9.
const NEGLIGIBLE: f64 = 1e-11;

/// Solves the equations of the states at hand, and changes the state of the contact that violates its own most, until none does.
///
/// ```text
/// open     −w_n > 0          → stick                 slip±   ∓w_t > 0   → stick
/// closed   −H_nn P_n > 0     → open                  stick   H_tt (|P_t| − μ P_n) > 0   → slip against P_t
/// ```
/// With the states of the last problem of a simulation the first solve is almost always the last. No guarantee: what it proposes is checked,
/// and there are other methods.
/// # Source
/// Ours; states as in Glocker's *Set-Valued Force Laws* (2001).
#[derive(Debug, Clone)]
pub struct ActiveStates {
    system: StateSystem,
    x: Vec<f64>,
    w: Vec<f64>,
}

impl ActiveStates {
    /// Makes room for this many contacts.
    pub fn new(contacts: usize) -> Self {
        ActiveStates { system: StateSystem::new(contacts), x: vec![0.0; 2 * contacts], w: vec![0.0; 2 * contacts] }
    }

    /// Goes on from `states`; writes a proposal to `impulses`, and its states.
    ///
    /// # Errors
    /// [`Unsolved::NotFound`] after twelve changes.
    pub fn attempt(
        &mut self,
        problem: FrictionProblem<'_>,
        states: &mut [ContactState],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let n = problem.contacts();
        if self.w.len() < 2 * n {
            *self = ActiveStates::new(n);
        }
        let negligible = NEGLIGIBLE * problem.scale();
        for changes in 0..=MOST_CHANGES {
            solve_states(&mut self.system, problem, states, &mut self.x, impulses);
            problem.velocities(impulses, &mut self.w);
            match most_violated(problem, states, impulses, &self.w, negligible) {
                Some((contact, state)) => states[contact] = state,
                None => {
                    let factorisations = changes + 1;
                    return Ok(SolveStats { pivots: changes, factorisations, ..SolveStats::default() });
                }
            }
        }
        Err(Unsolved::NotFound { residual: f64::INFINITY })
    }
}

/// Writes the impulses of one combination of states.
pub(super) fn solve_states(
    system: &mut StateSystem,
    problem: FrictionProblem<'_>,
    states: &[ContactState],
    x: &mut [f64],
    impulses: &mut [f64],
) {
    system.factorise(problem.friction, states, |row, column| problem.row(row)[column]);
    for (x, &row) in x.iter_mut().zip(system.rows()) {
        *x = -problem.b[row];
    }
    system.solve(x);
    system.impulses(problem.friction, states, x, impulses);
}

/// The contact that violates its state most, and the state it would rather have.
fn most_violated(
    problem: FrictionProblem<'_>,
    states: &[ContactState],
    impulses: &[f64],
    w: &[f64],
    negligible: f64,
) -> Option<(usize, ContactState)> {
    let n = states.len();
    let (mut worst, mut change) = (negligible, None);
    for (contact, &state) in states.iter().enumerate() {
        let (p_n, p_t, mu) = (impulses[contact], impulses[n + contact], problem.friction[contact]);
        let (w_n, w_t) = (w[contact], w[n + contact]);
        let pull = -p_n * problem.row(contact)[contact];
        // Without friction there is nothing to stick with.
        let closed = if mu > 0.0 { ContactState::Stick } else { ContactState::SlipPositive };
        let (violation, rather) = match state {
            ContactState::Open => (-w_n, closed),
            _ if p_n < 0.0 => (pull, ContactState::Open),
            ContactState::Stick => {
                let against = if p_t > 0.0 { ContactState::SlipNegative } else { ContactState::SlipPositive };
                ((p_t.abs() - mu * p_n) * problem.row(n + contact)[n + contact], against)
            }
            _ if mu == 0.0 => continue,
            ContactState::SlipPositive => (-w_t, ContactState::Stick),
            ContactState::SlipNegative => (w_t, ContactState::Stick),
        };
        if violation > worst {
            (worst, change) = (violation, Some((contact, rather)));
        }
    }
    change
}
