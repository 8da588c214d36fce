//! Lemke's method for the contact problem with friction, written as a linear complementarity problem.
//!
//! ```text
//! z = [P_n; β⁺; β⁻; σ],  P_t = β⁺ − β⁻        w_n ⟂ P_n      ±w_t + σ ⟂ β±      μ P_n − β⁺ − β⁻ ⟂ σ
//!
//!     ⎡ H_nn   H_nt  −H_nt   0 ⎤
//! M = ⎢ H_tn   H_tt  −H_tt   1 ⎥         copositive for H positive semidefinite and μ ≥ 0: Lemke ends with a solution,
//!     ⎢−H_tn  −H_tt   H_tt   1 ⎥         if no jam loads itself
//!     ⎣  μ     −1     −1     0 ⎦
//! ```
//! Exact in the plane. `M` is not symmetric, so the final basis is read as states, and their equations are solved
//! afresh. Each contact is scaled by its own `H_nn`, and `b` by its largest entry: a step with right-hand sides of
//! round-off must not end on thresholds.
//!
//! # Source
//! Stewart, Trinkle, *An implicit time-stepping scheme for rigid body dynamics with inelastic collisions and Coulomb
//! friction* (1996); Anitescu, Potra, *Formulating dynamic multi-rigid-body contact problems with friction as solvable
//! LCPs* (1997).

use super::active_states::solve_states;
use super::{ContactState, FrictionProblem, StateSystem};
use crate::complementarity::{LemkeTableau, SolveStats, Unsolved};

/// Lemke's method on the copositive problem. See the module.
#[derive(Debug, Clone)]
pub struct CopositiveLemke {
    tableau: LemkeTableau<0, 0>,
    /// `1/√H_nn` of each contact.
    scale: Vec<f64>,
    /// Which of `[P_n; β⁺; β⁻; σ]` are basic.
    basic: Vec<bool>,
    system: StateSystem,
    afresh: Vec<f64>,
}

impl CopositiveLemke {
    /// Makes room for this many contacts.
    pub fn new(contacts: usize) -> Self {
        CopositiveLemke {
            tableau: LemkeTableau::new(4 * contacts),
            scale: vec![0.0; contacts],
            basic: vec![false; 4 * contacts],
            system: StateSystem::new(contacts),
            afresh: vec![0.0; 2 * contacts],
        }
    }

    /// Writes a proposal to `impulses`, and its states.
    ///
    /// # Errors
    /// [`Unsolved::NotFound`] on a ray.
    pub fn attempt(
        &mut self,
        problem: FrictionProblem<'_>,
        states: &mut [ContactState],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let n = problem.contacts();
        if self.scale.len() < n {
            *self = CopositiveLemke::new(n);
        }
        impulses.fill(0.0);
        states.fill(ContactState::Open);
        if problem.is_solved_by_zero()? {
            return Ok(SolveStats::default());
        }
        let b_max = self.start(problem);
        let pivots = self.tableau.run()?;
        self.read(n, b_max, states, impulses);
        solve_states(&mut self.system, problem, states, &mut self.afresh[..2 * n]);
        if problem.natural_residual(&self.afresh[..2 * n]) < problem.natural_residual(impulses) {
            impulses.copy_from_slice(&self.afresh[..2 * n]);
        } else {
            // A basis that is singular or degenerate: what its variables are worth says what the contacts do.
            ContactState::write_of_impulses(problem, impulses, states);
        }
        Ok(SolveStats { pivots, factorisations: 1, ..SolveStats::default() })
    }

    /// Fills the tableau; returns the factor taken out of `b`.
    fn start(&mut self, problem: FrictionProblem<'_>) -> f64 {
        let n = problem.contacts();
        for (contact, scale) in self.scale[..n].iter_mut().enumerate() {
            let h = problem.delassus.row(contact)[contact];
            *scale = if h > 0.0 { 1.0 / h.sqrt() } else { 1.0 };
        }
        let scale = &self.scale;
        let scaled = |row: usize| scale[row % n] * problem.b[row];
        let b_max = (0..2 * n).fold(f64::MIN_POSITIVE, |max, row| max.max(scaled(row).abs()));
        self.tableau.start(4 * n, |i, minus_m| {
            minus_m.fill(0.0);
            let (block, contact) = (i / n, i % n);
            if block == 3 {
                minus_m[contact] = -problem.cone.friction[contact];
                (minus_m[n + contact], minus_m[2 * n + contact]) = (1.0, 1.0);
                return 0.0;
            }
            // Rows n, t, −t; columns likewise.
            let (row, sign) = if block == 2 { (n + contact, -1.0) } else { (block * n + contact, 1.0) };
            for other in 0..n {
                let entry = |column: usize| -sign * scale[contact] * problem.delassus.row(row)[column] * scale[other];
                minus_m[other] = entry(other);
                minus_m[n + other] = entry(n + other);
                minus_m[2 * n + other] = -entry(n + other);
            }
            if block > 0 {
                minus_m[3 * n + contact] = -1.0;
            }
            sign * scaled(row) / b_max
        });
        b_max
    }

    /// Reads impulses and states from the final basis.
    fn read(&mut self, n: usize, b_max: f64, states: &mut [ContactState], impulses: &mut [f64]) {
        self.basic.fill(false);
        for r in 0..4 * n {
            let Some(variable) = self.tableau.basic(r) else { continue };
            self.basic[variable] = true;
            let value = self.scale[variable % n] * b_max * self.tableau.rhs(r);
            match variable / n {
                0 => impulses[variable] = value,
                1 => impulses[variable] += value,
                2 => impulses[variable - n] -= value,
                _ => {}
            }
        }
        for (contact, state) in states.iter_mut().enumerate() {
            let [pushes, forwards, backwards, slides] = [0, 1, 2, 3].map(|block| self.basic[block * n + contact]);
            *state = match (pushes, slides, forwards, backwards) {
                (false, ..) => ContactState::Open,
                // Its friction pushes forwards, so it slides backwards.
                (_, true, true, _) => ContactState::SlipNegative,
                (_, true, false, _) => ContactState::SlipPositive,
                (_, false, ..) => ContactState::Stick,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contact_is_solved_whatever_the_unit_of_its_mass() {
        for unit in [1e-9, 1.0, 1e9] {
            let h = [unit, 0.0, 0.0, unit];
            for (b, impulses) in [([-1.0, 0.2], [1.0, -0.2]), ([-1.0, 2.0], [1.0, -0.5])] {
                let (mut states, mut p) = ([ContactState::Open], [0.0; 2]);
                let problem = FrictionProblem::with_friction(&h, &b, &[0.5]);
                CopositiveLemke::new(1).attempt(problem, &mut states, &mut p).unwrap();
                for (p, wanted) in p.iter().zip(impulses) {
                    approx::assert_relative_eq!(p * unit, wanted, max_relative = 1e-14);
                }
            }
        }
    }
}
