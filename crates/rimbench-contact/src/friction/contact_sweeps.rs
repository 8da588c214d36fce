//! Gauss–Seidel by contact: each contact is solved exactly while the others stand still.

use super::{ContactState, FrictionProblem};
use crate::complementarity::{SolveStats, Unsolved};

/// Sweeps over all contacts after which the method gives up.
const MOST_SWEEPS: u32 = 5000;

/// Non-smooth Gauss–Seidel, contact by contact.
///
/// Converges for most problems with few redundant contacts, linearly; keeps nothing.
/// # Source
/// Jourdan, Alart, Jean, *A Gauss–Seidel like algorithm to solve frictional contact problems* (1998).
#[derive(Debug, Clone, Copy, Default)]
pub struct ContactSweeps;

impl ContactSweeps {
    /// Sweeps from zero until the natural residual is at most `tolerance`.
    ///
    /// # Errors
    /// [`Unsolved::NotFound`] with the residual after the last sweep.
    pub fn attempt(
        self,
        problem: FrictionProblem<'_>,
        tolerance: f64,
        states: &mut [ContactState],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let n = problem.contacts();
        impulses.fill(0.0);
        let mut residual = f64::INFINITY;
        for sweep in 1..=MOST_SWEEPS {
            for contact in 0..n {
                let pair = [contact, n + contact];
                let h = pair.map(|row| pair.map(|column| problem.delassus.row(row)[column]));
                let others = |row: usize, own: [f64; 2]| {
                    let all: f64 = problem.delassus.row(row).iter().zip(&*impulses).map(|(h, p)| h * p).sum();
                    problem.b[row] + all - own[0] * impulses[contact] - own[1] * impulses[n + contact]
                };
                let b = [others(contact, h[0]), others(n + contact, h[1])];
                let (state, p) = one_contact(h, b, problem.cone.friction[contact]);
                states[contact] = state;
                (impulses[contact], impulses[n + contact]) = (p[0], p[1]);
            }
            residual = problem.natural_residual(impulses);
            if residual <= tolerance {
                return Ok(SolveStats { pivots: sweep, ..SolveStats::default() });
            }
        }
        Err(Unsolved::NotFound { residual })
    }
}

/// The exact solution of one contact: the first of open, stick, slip that holds; without friction if none does.
fn one_contact([[a, x], [y, d]]: [[f64; 2]; 2], [b_n, b_t]: [f64; 2], mu: f64) -> (ContactState, [f64; 2]) {
    if b_n >= 0.0 {
        return (ContactState::Open, [0.0; 2]);
    }
    let determinant = a * d - x * y;
    if mu > 0.0 && determinant > 1e-14 * a * d {
        let p = [(x * b_t - d * b_n) / determinant, (y * b_n - a * b_t) / determinant];
        if p[0] >= 0.0 && p[1].abs() <= mu * p[0] {
            return (ContactState::Stick, p);
        }
    }
    for state in [ContactState::SlipPositive, ContactState::SlipNegative] {
        let friction = state.friction() * mu;
        let push = a + friction * x;
        let p_n = -b_n / push;
        let w_t = (y + friction * d) * p_n + b_t;
        if push > 0.0 && state.friction() * w_t <= 0.0 {
            return (state, [p_n, friction * p_n]);
        }
    }
    (ContactState::SlipPositive, [-b_n / a, 0.0])
}
