//! The active set of a contact problem with friction: states instead of members.

use super::{ContactState, FrictionProblem, StateSystem};
use crate::complementarity::{SolveStats, Unsolved};
use crate::known_size;
use crate::problem::{Cone, Coulomb};

/// Changes of states after which the method gives up: a simulation needs none or one, and on redundant contacts a cold
/// start can cycle.
const MOST_CHANGES: u32 = 12;
/// A violation below this part of `‖b‖_∞` is rounding; the accepted residual is 1e-9.
const NEGLIGIBLE: f64 = 1e-11;

/// Solves the equations of the states at hand, and changes the state of the contact that violates its own most, until
/// none does.
///
/// ```text
/// open     −w_n > 0          → stick                 slip±   ∓w_t > 0   → stick
/// closed   −H_nn P_n > 0     → open                  stick   H_tt (|P_t| − μ max(P_n, 0)) > 0   → slip against P_t
/// ```
/// `P = 0` where that is a solution. With the states of the last problem of a simulation the first solve is almost
/// always the last. No guarantee: what it proposes is checked, and there are other methods.
/// # Source
/// Ours; states as in Glocker's *Set-Valued Force Laws* (2001).
#[derive(Debug, Clone)]
pub struct ActiveStates {
    system: StateSystem,
    /// Whether the present matrix has been factorised.
    seen: bool,
    w: Vec<f64>,
}

impl ActiveStates {
    /// Makes room for this many contacts.
    pub fn new(contacts: usize) -> Self {
        ActiveStates { system: StateSystem::new(contacts), seen: false, w: vec![0.0; 2 * contacts] }
    }

    /// Goes on from `states`; writes a proposal to `impulses`, and its states. The stats have its natural residual.
    /// `same_matrix` tells that matrix and coefficients are those of the problem before: in its states nothing is
    /// factorised.
    ///
    /// # Errors
    /// [`Unsolved::NotFound`] without a proposal, [`Unsolved::NonFinite`] if `b` is not finite.
    pub fn attempt(
        &mut self,
        problem: FrictionProblem<'_>,
        same_matrix: bool,
        states: &mut [ContactState],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        self.seen &= same_matrix;
        if problem.is_solved_by_zero()? {
            impulses.fill(0.0);
            states.fill(ContactState::Open);
            return Ok(SolveStats::default());
        }
        let n = problem.contacts();
        if self.w.len() < 2 * n {
            *self = ActiveStates::new(n);
        }
        let [scale, largest] = Coulomb::<1>::scale_and_largest(problem.b);
        // No less than the rounding of rows that would not close.
        let negligible = NEGLIGIBLE * scale.max(0.01 * largest);
        let mut factorisations = 0;
        let seen = std::mem::replace(&mut self.seen, true);
        for changes in 0..=MOST_CHANGES {
            if !(seen && self.system.is_of(states)) {
                factorise_states(&mut self.system, problem, states);
                factorisations += 1;
            }
            self.system.impulses(problem.b, impulses);
            problem.velocities(impulses, &mut self.w);
            let worst = worst_violation(problem, impulses, &self.w);
            let next = if worst <= negligible && slides_as_said(states, &self.w, negligible) {
                None
            } else {
                most_violated(problem, states, impulses, &self.w, negligible)
            };
            match next {
                Some((contact, state)) => states[contact] = state,
                None => {
                    let residual = worst / scale.max(f64::MIN_POSITIVE);
                    return Ok(SolveStats { pivots: changes, factorisations, residual, ..SolveStats::default() });
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
    impulses: &mut [f64],
) {
    factorise_states(system, problem, states);
    system.impulses(problem.b, impulses);
}

#[inline(always)]
fn factorise_states(system: &mut StateSystem, problem: FrictionProblem<'_>, states: &[ContactState]) {
    system.factorise(problem.cone.friction, states, |row| problem.delassus.row(row));
}

/// The largest violation at impulses and velocities; the compiler knows the sizes of few contacts.
#[inline]
fn worst_violation(problem: FrictionProblem<'_>, impulses: &[f64], w: &[f64]) -> f64 {
    #[inline(always)]
    fn of(n: usize, FrictionProblem { delassus, b, cone }: FrictionProblem<'_>, impulses: &[f64], w: &[f64]) -> f64 {
        let (w, friction) = (&w[..2 * n], &cone.friction[..n]);
        FrictionProblem::<1>::with_friction(&delassus.h[..4 * n * n], &b[..2 * n], friction)
            .violation(&impulses[..2 * n], |row| w[row])
    }
    known_size!(
        problem.contacts(),
        N if N <= 4 => of(N, problem, impulses, w),
        n => of(n, problem, impulses, w),
    )
}

/// Whether contacts that slide do so in the direction of their state: of one that hardly presses no residual tells.
#[inline]
fn slides_as_said(states: &[ContactState], w: &[f64], negligible: f64) -> bool {
    let w_t = &w[states.len()..];
    states.iter().zip(w_t).all(|(state, w_t)| state.friction() * w_t <= negligible)
}

/// The contact that violates its state most, and the state it would rather have.
#[cold]
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
        let (p_n, p_t, mu) = (impulses[contact], impulses[n + contact], problem.cone.friction[contact]);
        let (w_n, w_t) = (w[contact], w[n + contact]);
        // Without friction there is nothing to stick with.
        let closed = if mu > 0.0 { ContactState::Stick } else { ContactState::SlipPositive };
        let own = match state {
            ContactState::Open => (-w_n, closed),
            ContactState::Stick => {
                let against = if p_t > 0.0 { ContactState::SlipNegative } else { ContactState::SlipPositive };
                ((p_t.abs() - mu * p_n.max(0.0)) * problem.delassus.row(n + contact)[n + contact], against)
            }
            // Without friction one slip is as good as the other.
            _ if mu == 0.0 => (0.0, state),
            ContactState::SlipPositive => (-w_t, ContactState::Stick),
            ContactState::SlipNegative => (w_t, ContactState::Stick),
        };
        // A closed contact can violate its state in two ways; a pull that is rounding must not hide that it slides the
        // wrong way.
        let pull = (-p_n * problem.delassus.row(contact)[contact], ContactState::Open);
        for (violation, rather) in [own, pull] {
            if violation > worst {
                (worst, change) = (violation, Some((contact, rather)));
            }
        }
    }
    change
}
