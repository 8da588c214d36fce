//! What is put in the place of Coulomb's law: convex problems, solved as linear complementarity problems.
//!
//! ```text
//! relaxed   P_n = z⁺ + z⁻,  P_t = μ (z⁺ − z⁻)        0 ≤ b_n ± μ b_t + (H_n· ± μ H_t·) P ⟂ z± ≥ 0        symmetric
//! box       P_t = y − B                              0 ≤ w_n ⟂ P_n,   0 ≤ w_t + σ ⟂ y,   0 ≤ 2B − y ⟂ σ   monotone
//! held      P_t given                                0 ≤ w_n ⟂ P_n                                        symmetric
//! ```
//! The symmetric ones go to the solver of contacts without friction, the other one to Lemke's method, and where that fails to projected
//! Gauss–Seidel sweeps.

use std::fmt;

use super::{ContactState, FrictionLaw, FrictionProblem};
use crate::complementarity::{
    Checked, ComplementaritySolver, Lcp, LemkeTableau, SolveStats, SolverEntry, TABLEAU_PIVOT, Unsolved,
};
use crate::linear_algebra::Factor;

/// Sweeps of a box between two attempts to solve for what they found free, and how many such rounds there are.
const SWEEPS: u32 = 50;
const ROUNDS: u32 = 100;

/// One of the laws but Coulomb's, with what it remembers of the step before.
#[derive(Clone)]
pub(super) struct OtherLaw {
    law: FrictionLaw,
    tolerance: f64,
    solver: Checked,
    tableau: LemkeTableau<0, 0>,
    /// Matrix, right-hand side and answer of the complementarity problem.
    m: Vec<f64>,
    q: Vec<f64>,
    z: Vec<f64>,
    /// Scale of each row's impulse in the tableau, `1/√H_ii`.
    scale: Vec<f64>,
    /// For the impulses of a box that are at no bound, computed from `H` and `b`: their rows, and what becomes of them.
    members: Vec<usize>,
    factor: Factor,
    right: Vec<f64>,
    afresh: Vec<f64>,
    /// `[F_n; F_t]` of the step before, N.
    forces: Vec<f64>,
    /// Length of the step to come, s.
    step: f64,
}

impl fmt::Debug for OtherLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OtherLaw").field("law", &self.law).finish_non_exhaustive()
    }
}

impl OtherLaw {
    /// Makes room for this many contacts, nothing carried so far; none for Coulomb's law.
    pub(super) fn new(law: FrictionLaw, contacts: usize, tolerance: f64) -> Option<Box<Self>> {
        let size = match law {
            FrictionLaw::Coulomb => return None,
            FrictionLaw::Relaxed => 2 * contacts,
            FrictionLaw::Box => 3 * contacts,
            FrictionLaw::Held => contacts,
        };
        let by_tableau = law == FrictionLaw::Box;
        let rows = if by_tableau { 2 * contacts } else { 0 };
        let entry = SolverEntry { tolerance, ..SolverEntry::active_set() };
        Some(Box::new(OtherLaw {
            law,
            tolerance,
            solver: entry.checked(if by_tableau { 0 } else { size }),
            tableau: LemkeTableau::new(if by_tableau { size } else { 0 }),
            m: vec![0.0; if by_tableau { 0 } else { size * size }],
            q: vec![0.0; size],
            z: vec![0.0; size],
            scale: vec![0.0; rows],
            members: vec![0; rows],
            factor: Factor::new(rows),
            right: vec![0.0; rows],
            afresh: vec![0.0; rows],
            forces: vec![0.0; 2 * contacts],
            step: 0.0,
        }))
    }

    /// Takes the forces `[F_n; F_t]` (N) of the step before.
    pub(super) fn take_forces(&mut self, forces: impl Iterator<Item = f64>) {
        self.forces.clear();
        self.forces.extend(forces);
    }

    /// Says how long the step to come is, s.
    pub(super) fn set_step(&mut self, step: f64) {
        self.step = step;
    }

    /// Writes impulses and states.
    ///
    /// # Errors
    /// Those of the method that is asked, or [`Unsolved::NotFound`] for an answer that is none.
    pub(super) fn solve(
        &mut self,
        problem: FrictionProblem<'_>,
        states: &mut [ContactState],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        if !problem.b.iter().all(|b| b.is_finite()) {
            return Err(Unsolved::NonFinite);
        }
        self.forces.resize(2 * problem.contacts(), 0.0);
        let stats = match self.law {
            FrictionLaw::Relaxed => self.relaxed(problem, impulses)?,
            FrictionLaw::Box => self.boxed(problem, impulses)?,
            FrictionLaw::Coulomb | FrictionLaw::Held => return self.held(problem, states, impulses),
        };
        self.note_states(problem, states, impulses);
        let step = self.step;
        self.forces.iter_mut().zip(&*impulses).for_each(|(force, impulse)| *force = impulse / step);
        Ok(stats)
    }

    fn relaxed(&mut self, problem: FrictionProblem<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let (n, mu) = (problem.contacts(), problem.friction);
        let side = |k: usize| (k % n, if k < n { mu[k] } else { -mu[k - n] });
        let (m, q, z) = (&mut self.m[..4 * n * n], &mut self.q[..2 * n], &mut self.z[..2 * n]);
        for row in 0..2 * n {
            let (contact, along) = side(row);
            q[row] = problem.b[contact] + along * problem.b[n + contact];
            for column in 0..2 * n {
                let (other, along_other) = side(column);
                let of = |row: usize| problem.row(row)[other] + along_other * problem.row(row)[n + other];
                m[row * 2 * n + column] = of(contact) + along * of(n + contact);
            }
        }
        let stats = self.solver.solve(Lcp::new(m, q), z)?;
        for contact in 0..n {
            let (forwards, backwards) = (z[contact], z[n + contact]);
            impulses[contact] = forwards + backwards;
            impulses[n + contact] = mu[contact] * (forwards - backwards);
        }
        Ok(stats)
    }

    fn held(
        &mut self,
        problem: FrictionProblem<'_>,
        states: &mut [ContactState],
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let n = problem.contacts();
        for (impulse, force) in impulses[n..].iter_mut().zip(&self.forces[n..]) {
            *impulse = self.step * force;
        }
        let (m, q, z) = (&mut self.m[..n * n], &mut self.q[..n], &mut self.z[..n]);
        for row in 0..n {
            let (normal, tangential) = problem.row(row).split_at(n);
            m[row * n..(row + 1) * n].copy_from_slice(normal);
            q[row] = problem.b[row] + tangential.iter().zip(&impulses[n..]).map(|(h, p)| h * p).sum::<f64>();
        }
        let stats = self.solver.solve(Lcp::new(m, q), z)?;
        impulses[..n].copy_from_slice(z);
        // What a contact does along its surface is not asked; it is closed or open.
        for (state, p_n) in states.iter_mut().zip(&*z) {
            *state = match *state {
                _ if *p_n <= 0.0 => ContactState::Open,
                ContactState::Open => ContactState::Stick,
                known => known,
            };
        }
        Ok(stats)
    }

    /// Bound of the friction impulse, N·s.
    fn bound(&self, problem: FrictionProblem<'_>, contact: usize) -> f64 {
        problem.friction[contact] * self.forces[contact].max(0.0) * self.step
    }

    fn boxed(&mut self, problem: FrictionProblem<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        let pivots = self.box_by_tableau(problem, impulses).unwrap_or_else(|_| {
            impulses.fill(0.0);
            0
        });
        let residual = self.box_residual(problem, impulses);
        let residual = self.box_afresh(problem, impulses, residual);
        if residual <= self.tolerance {
            return Ok(SolveStats { pivots, factorisations: 1, residual, ..SolveStats::default() });
        }
        self.box_by_sweeps(problem, impulses, residual)
    }

    /// Lemke's method; returns its pivots.
    fn box_by_tableau(&mut self, problem: FrictionProblem<'_>, impulses: &mut [f64]) -> Result<u32, Unsolved> {
        let n = problem.contacts();
        for row in 0..2 * n {
            let h = problem.row(row)[row];
            self.scale[row] = if h > 0.0 { 1.0 / h.sqrt() } else { 1.0 };
        }
        // Right-hand sides `[b_n − H_nt B; b_t − H_tt B; 2B]`, scaled.
        let mut largest = f64::MIN_POSITIVE;
        for row in 0..3 * n {
            self.q[row] = if row < 2 * n {
                let pushed = (0..n).map(|c| problem.row(row)[n + c] * self.bound(problem, c)).sum::<f64>();
                self.scale[row] * (problem.b[row] - pushed)
            } else {
                2.0 * self.bound(problem, row - 2 * n) / self.scale[row - n]
            };
            largest = largest.max(self.q[row].abs());
        }
        let OtherLaw { tableau, scale, q, z, .. } = self;
        tableau.start(3 * n, |row, minus_m| {
            minus_m.fill(0.0);
            let contact = row % n;
            if row < 2 * n {
                for (column, (entry, h)) in minus_m.iter_mut().zip(problem.row(row)).enumerate() {
                    *entry = -scale[row] * h * scale[column];
                }
            }
            match row / n {
                0 => (),
                1 => minus_m[2 * n + contact] = -1.0,
                _ => minus_m[n + contact] = 1.0,
            }
            q[row] / largest
        });
        let pivots = if q[..3 * n].iter().all(|q| *q >= 0.0) { 0 } else { tableau.run()? };
        z[..3 * n].fill(0.0);
        for row in 0..3 * n {
            match tableau.basic(row) {
                Some(variable) if variable < 2 * n => z[variable] = scale[variable] * largest * tableau.rhs(row),
                // At the upper bound, whatever rounding makes of y.
                Some(slip) => z[slip] = f64::INFINITY,
                None => (),
            }
        }
        for contact in 0..n {
            let bound = self.bound(problem, contact);
            let at_upper = self.z[2 * n + contact] > 0.0;
            impulses[contact] = self.z[contact].max(0.0);
            impulses[n + contact] = if at_upper { bound } else { (self.z[n + contact] - bound).clamp(-bound, bound) };
        }
        Ok(pivots)
    }

    /// Solves for the impulses that are at no bound, from `H` and `b`, for a tableau and sweeps leave an error; takes that if it is better.
    ///
    /// Returns the residual.
    fn box_afresh(&mut self, problem: FrictionProblem<'_>, impulses: &mut [f64], residual: f64) -> f64 {
        let rows = impulses.len();
        let n = rows / 2;
        self.factor.clear(rows);
        let mut len = 0;
        for (row, &impulse) in impulses.iter().enumerate() {
            let free = if row < n { impulse > 0.0 } else { impulse.abs() < self.bound(problem, row - n) };
            if !free {
                continue;
            }
            let d = self.factor.border(problem.h, &self.members[..len], row);
            // What depends on the others keeps its impulse.
            if d > TABLEAU_PIVOT * problem.row(row)[row] {
                self.factor.push(d);
                self.members[len] = row;
                len += 1;
            }
        }
        let (members, afresh) = (&self.members[..len], &mut self.afresh[..rows]);
        afresh.copy_from_slice(impulses);
        members.iter().for_each(|&row| afresh[row] = 0.0);
        for (right, &row) in self.right.iter_mut().zip(members) {
            let pushed = problem.row(row).iter().zip(&*afresh).map(|(h, p)| h * p).sum::<f64>();
            *right = -(problem.b[row] + pushed);
        }
        self.factor.solve(&mut self.right[..len]);
        for slot in 0..len {
            let row = self.members[slot];
            self.afresh[row] = self.in_box(problem, row, self.right[slot]);
        }
        let found = self.box_residual(problem, &self.afresh[..rows]);
        if found < residual {
            impulses.copy_from_slice(&self.afresh[..rows]);
        }
        found.min(residual)
    }

    /// Projected Gauss–Seidel from the impulses given; now and then what is free is solved for at once.
    #[cold]
    fn box_by_sweeps(
        &mut self,
        problem: FrictionProblem<'_>,
        impulses: &mut [f64],
        mut least: f64,
    ) -> Result<SolveStats, Unsolved> {
        for round in 1..=ROUNDS {
            for _ in 0..SWEEPS {
                for row in 0..impulses.len() {
                    let h = problem.row(row)[row];
                    if h > 0.0 {
                        let moved = problem.row(row).iter().zip(&*impulses).map(|(h, p)| h * p).sum::<f64>();
                        impulses[row] = self.in_box(problem, row, impulses[row] - (problem.b[row] + moved) / h);
                    }
                }
            }
            let residual = self.box_residual(problem, impulses);
            let residual = self.box_afresh(problem, impulses, residual);
            if residual <= self.tolerance {
                let (pivots, factorisations) = (round * SWEEPS, 1 + round);
                return Ok(SolveStats { pivots, factorisations, residual, fallback: true });
            }
            least = least.min(residual);
        }
        Err(Unsolved::NotFound { residual: least })
    }

    /// An impulse, or the bound that it is beyond.
    fn in_box(&self, problem: FrictionProblem<'_>, row: usize, impulse: f64) -> f64 {
        match row.checked_sub(problem.contacts()) {
            None => impulse.max(0.0),
            Some(contact) => impulse.clamp(-self.bound(problem, contact), self.bound(problem, contact)),
        }
    }

    /// The natural residual of the box, relative to the largest of `‖b‖_∞` and what the bounds push.
    fn box_residual(&self, problem: FrictionProblem<'_>, impulses: &[f64]) -> f64 {
        let n = problem.contacts();
        let (mut worst, mut scale) = (0.0_f64, problem.scale());
        for contact in 0..n {
            let weight = |row: usize| Some(problem.row(row)[row]).filter(|h| *h > 0.0).unwrap_or(1.0);
            let w =
                |row: usize| problem.b[row] + problem.row(row).iter().zip(impulses).map(|(h, p)| h * p).sum::<f64>();
            let (h_nn, h_tt, bound) = (weight(contact), weight(n + contact), self.bound(problem, contact));
            let (p_n, p_t) = (impulses[contact], impulses[n + contact]);
            worst = worst.max((h_nn * p_n).min(w(contact)).abs());
            let wanted = (p_t - w(n + contact) / h_tt).clamp(-bound, bound);
            worst = worst.max(h_tt * (p_t - wanted).abs());
            scale = scale.max(h_tt * bound);
        }
        if worst.is_finite() { worst / scale.max(f64::MIN_POSITIVE) } else { f64::INFINITY }
    }

    /// What the contacts do, from their impulses.
    fn note_states(&self, problem: FrictionProblem<'_>, states: &mut [ContactState], impulses: &[f64]) {
        let n = states.len();
        for (contact, state) in states.iter_mut().enumerate() {
            let (p_n, p_t, mu) = (impulses[contact], impulses[n + contact], problem.friction[contact]);
            // In a box what counts is whether the impulse is at its bound, and the bound is that of an impulse before.
            let pressed = match (self.law, mu > 0.0) {
                (FrictionLaw::Box, true) if p_n > 0.0 => self.bound(problem, contact) / mu,
                _ => p_n,
            };
            *state = if p_n <= 0.0 { ContactState::Open } else { ContactState::of_impulses(pressed, p_t, mu) };
        }
    }
}
