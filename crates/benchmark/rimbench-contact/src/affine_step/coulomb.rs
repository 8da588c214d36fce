//! The modes of contacts with friction in the place of an active set.

use super::discretised_model::DiscretisedModel;
use super::{ActiveSetFactor, AffineStep, ForceRegion};
use crate::friction::{ContactState, StateSystem};

/// The equations of contacts in their modes, factorised: `K = E_σ H F_σ`.
///
/// ```text
/// P    = −F_σ K⁻¹ E_σ [ r + δ (a + H_·i λ) ]          region: |P_t| ≤ μ P_n (stick)      ±w_t⁺ ≥ 0 (slip)
/// w⁺   = w + δ (a + H_·i λ) + H P                     and P = 0 must not be a solution, which a solver would prefer
/// ```
#[derive(Clone)]
pub struct ModeFactor(Box<Modes>);

#[derive(Clone)]
struct Modes {
    system: StateSystem,
    states: Vec<ContactState>,
    friction: Vec<f64>,
}

impl ModeFactor {
    /// Reserves `contacts` contacts.
    pub fn new(contacts: usize) -> Self {
        ModeFactor(Box::new(Modes {
            system: StateSystem::new(contacts),
            states: Vec::with_capacity(contacts),
            friction: Vec::with_capacity(contacts),
        }))
    }
}

impl ActiveSetFactor for ModeFactor {
    /// Modes and coefficients μ of the contacts.
    type Active<'a> = (&'a [ContactState], &'a [f64]);
    const ROWS: usize = 2;

    fn factorise(
        &mut self,
        model: &DiscretisedModel,
        (states, friction): Self::Active<'_>,
        active: &mut Vec<usize>,
    ) -> bool {
        let n = model.contacts();
        let modes = &mut *self.0;
        modes.states.clear();
        modes.states.extend_from_slice(states);
        modes.friction.clear();
        modes.friction.extend_from_slice(friction);
        modes.system.factorise(friction, states, |row| &model.h_uu()[row * n..(row + 1) * n]);
        active.extend_from_slice(modes.system.rows());
        true
    }

    fn solve(&mut self, _active: &[usize], x: &mut [f64]) {
        self.0.system.solve(x);
    }

    /// Adds, for a contact that slides, the velocities that its friction gives as well.
    fn add_impulse(&self, model: &DiscretisedModel, row: usize, impulse: f64, w: &mut [f64]) {
        model.add_impulse(row, impulse, w);
        let Modes { states, friction, .. } = &*self.0;
        if let Some(state) = states.get(row)
            && state.friction() != 0.0
        {
            let tangential = state.friction() * friction[row] * impulse;
            model.add_impulse(states.len() + row, tangential, w);
        }
    }

    #[inline(always)]
    fn write_impulses(
        step: &AffineStep<Self>,
        model: &DiscretisedModel,
        lambda: &[f64],
        w_plus: &[f64],
        impulses: &mut [f64],
        tolerance: f64,
    ) -> bool {
        let Modes { states, friction, .. } = &*step.factor.0;
        let n = impulses.len();
        let contacts = n / 2;
        for (row, impulse) in step.active_impulses(lambda, n) {
            if row >= contacts {
                // The normal impulse of the contact is the one before.
                let beyond = impulse.abs() - friction[row - contacts] * impulses[row - contacts];
                if beyond > 0.0 && beyond * model.h_uu()[row * n + row] > tolerance {
                    return false;
                }
            } else {
                let (direction, mu) = (states[row].friction(), friction[row]);
                // Friction points against the sliding velocity.
                let slides = mu == 0.0 || direction * w_plus[contacts + row] <= tolerance;
                if impulse < 0.0 || !slides {
                    return false;
                }
                impulses[contacts + row] = direction * mu * impulse;
            }
            impulses[row] = impulse;
        }
        true
    }

    fn keep_admissible(step: &AffineStep<Self>, w: &[f64], rounding: f64, region: &mut ForceRegion) {
        let Modes { states, friction, .. } = &*step.factor.0;
        let contacts = states.len();
        for (slot, &row) in step.active.iter().enumerate() {
            if row >= contacts {
                // |P_t| ≤ μ P_n; the normal impulse of the contact is the one before.
                let mu = friction[row - contacts];
                for sign in [-1.0, 1.0] {
                    region.keep(|column| mu * step.impulse(slot - 1, column) + sign * step.impulse(slot, column));
                }
                continue;
            }
            region.keep(|column| step.impulse(slot, column));
            // Friction points against the sliding velocity.
            let direction = states[row].friction();
            if direction != 0.0 && friction[row] != 0.0 {
                let slack = |column: usize| if column == 0 { rounding } else { 0.0 };
                region.keep(|column| slack(column) - direction * step.velocity(w, contacts + row, column));
            }
        }
    }
}
