//! Fewer contacts inside a reduced interface model: which take part in a macro step, and what is said about the error.
//!
//! At each communication point one complementarity problem over the whole macro step T, with the actuator's force λ_k held,
//! predicts what the contacts will do:
//!
//! ```text
//! 0 ≤ w_u + T (a_u + H_ui λ_k) + H_uu P + gap term ⟂ P ≥ 0
//! ```
//! **near** leaves out contacts that carry no impulse then and stay open: `P_j = 0` and `g_j > T (|w_j| + |w_j⁺|) + 1 mm`. Without them
//! nothing changes unless one of them closes all the same; the mechanics, which keeps all, then does it one macro step later.
//!
//! **coupled** leaves out, besides, contacts S that press but hardly move the interface. Their predicted forces `P_j/T` stay as loads, so
//! only the *change* of the interface force meets a model without them. With `y = H_AA⁻¹ H_Ai` over the pressing contacts A, the
//! mobility of the interface then is too large by
//!
//! ```text
//! 0 ≤ Ĥ_ii(A∖S) − Ĥ_ii(A) = y_Sᵀ [(H_AA⁻¹)_SS]⁻¹ y_S ≤ y_Sᵀ H_SS y_S ≤ τ H_ii
//! ```
//! because `(H_AA⁻¹)_SS` is the inverse of a Schur complement of `H_SS`. S is filled from the least `y_j² H_jj` on for as long as the last
//! inequality holds. In a micro step the interface velocity is off by at most `δ τ H_ii |λ − λ_k|` for as long as A and the forces of
//! S stay as predicted; what happens where they do not is measured, not bounded.

use super::contact_choice::ContactChoice;
use crate::complementarity::{Checked, ComplementaritySolver, Lcp, SolverCounters, SolverEntry};
use crate::error::Failure;
use crate::interface_model::{ReducedInterfaceModel, gap_velocity};
use crate::linear_algebra::Cholesky;

/// Room left to a contact that is to stay open in the prediction, which knows neither how normals turn nor how the force changes.
/// Not a detection of contacts: a larger one costs time only. Ours, m.
const CLEARANCE: f64 = 1e-3;

/// The choice of contacts with its buffers.
#[derive(Clone)]
pub(super) struct ContactSelection {
    choice: ContactChoice,
    solver: Checked,
    matrix: Vec<f64>,
    q: Vec<f64>,
    impulses: Vec<f64>,
    /// `H_AA` with the identity in place of contacts that do not press.
    factor: Cholesky,
    /// `y`, one column after the other.
    y: Vec<f64>,
    /// Largest `y_j² H_jj / H_ii` over the interface rows.
    share: Vec<f64>,
    order: Vec<usize>,
    left_out: Vec<usize>,
    /// Bound of the error of each mobility so far, and with one more contact left out, 1/kg.
    mobility_error: Vec<f64>,
    next_error: Vec<f64>,
}

impl ContactSelection {
    pub(super) fn new(contacts: usize, interface: usize, choice: ContactChoice, solver: &SolverEntry) -> Self {
        let n = if choice == ContactChoice::All { 0 } else { contacts };
        ContactSelection {
            choice,
            solver: solver.checked(n),
            matrix: vec![0.0; n * n],
            q: vec![0.0; n],
            impulses: vec![0.0; n],
            factor: Cholesky::new(if matches!(choice, ContactChoice::Coupled { .. }) { n } else { 0 }),
            y: vec![0.0; n * interface],
            share: vec![0.0; n],
            order: Vec::with_capacity(n),
            left_out: Vec::with_capacity(n),
            mobility_error: vec![0.0; interface],
            next_error: vec![0.0; interface],
        }
    }

    pub(super) fn counters(&self) -> SolverCounters {
        self.solver.counters()
    }

    /// Removes from `set` the contacts that need not take part in the macro step `length` (s) with the actuator's force `lambda`, and
    /// adds to the free accelerations of `model` what the removed ones go on carrying. `tracked`: open contacts may close.
    pub(super) fn select(
        &mut self,
        set: &mut Vec<usize>,
        model: &mut ReducedInterfaceModel,
        lambda: &[f64],
        length: f64,
        tracked: bool,
    ) -> Result<(), Failure> {
        if self.choice == ContactChoice::All || set.is_empty() {
            return Ok(());
        }
        self.predict(set, model, lambda, length, tracked)?;
        self.left_out.clear();
        if let ContactChoice::Coupled { tolerance } = self.choice {
            self.weakly_coupled(set, model, tolerance);
            self.hold_forces(set, model, length);
        }
        let (impulses, left_out) = (&self.impulses, &self.left_out);
        let n = set.len();
        let mut slot = 0;
        set.retain(|&contact| {
            let own = slot;
            slot += 1;
            if impulses[own] > 0.0 {
                return !left_out.contains(&own);
            }
            // Velocity at the end of the macro step, from the problem just solved.
            let term = if tracked { gap_term(model, contact, length) } else { 0.0 };
            let row = &self.matrix[own * n..(own + 1) * n];
            let w = self.q[own] - term + row.iter().zip(&impulses[..n]).map(|(h, p)| h * p).sum::<f64>();
            model.gap[contact] <= length * (model.w[contact].abs() + w.abs()) + CLEARANCE
        });
        Ok(())
    }

    fn predict(
        &mut self,
        set: &[usize],
        model: &ReducedInterfaceModel,
        lambda: &[f64],
        length: f64,
        tracked: bool,
    ) -> Result<(), Failure> {
        let (n, n_u) = (set.len(), model.contacts());
        for (slot, &contact) in set.iter().enumerate() {
            for (entry, &other) in self.matrix[slot * n..(slot + 1) * n].iter_mut().zip(set) {
                *entry = model.entry(contact, other);
            }
            let pushed: f64 = lambda.iter().enumerate().map(|(i, force)| model.entry(contact, n_u + i) * force).sum();
            let term = if tracked { gap_term(model, contact, length) } else { 0.0 };
            self.q[slot] = model.w[contact] + length * (model.a[contact] + pushed) + term;
        }
        let lcp = Lcp::new(&self.matrix[..n * n], &self.q[..n]);
        self.solver.solve(lcp, &mut self.impulses[..n])?;
        Ok(())
    }

    /// Fills `left_out` with the slots of contacts that press but hardly move the interface.
    fn weakly_coupled(&mut self, set: &[usize], model: &ReducedInterfaceModel, tolerance: f64) {
        let (n, n_u, n_i) = (set.len(), model.contacts(), model.interface());
        let capacity = self.share.len();
        let presses = |slot: usize, impulses: &[f64]| slot < n && impulses[slot] > 0.0;
        for row in 0..capacity {
            for column in 0..capacity {
                let both = presses(row, &self.impulses) && presses(column, &self.impulses);
                self.factor.l[row * capacity + column] =
                    if both { self.matrix[row * n + column] } else { f64::from(u8::from(row == column)) };
            }
        }
        // Dependent contacts that press: nobody can say what each of them does, so all stay.
        if self.factor.factor("H_AA").is_err() {
            return;
        }
        self.order.clear();
        self.order.extend((0..n).filter(|&slot| self.impulses[slot] > 0.0));
        self.share[..n].fill(0.0);
        for i in 0..n_i {
            let y = &mut self.y[i * capacity..(i + 1) * capacity];
            y.fill(0.0);
            for &slot in &self.order {
                y[slot] = model.entry(set[slot], n_u + i);
            }
            self.factor.solve(y);
            for &slot in &self.order {
                let own = y[slot] * y[slot] * self.matrix[slot * n + slot] / model.entry(n_u + i, n_u + i);
                self.share[slot] = self.share[slot].max(own);
            }
        }
        let share = &self.share;
        self.order.sort_unstable_by(|&a, &b| share[a].total_cmp(&share[b]).then(a.cmp(&b)));
        self.mobility_error.fill(0.0);
        for position in 0..self.order.len() {
            let slot = self.order[position];
            let row = &self.matrix[slot * n..(slot + 1) * n];
            let mut within = true;
            for i in 0..n_i {
                let y = &self.y[i * capacity..(i + 1) * capacity];
                let cross: f64 = self.left_out.iter().map(|&other| row[other] * y[other]).sum();
                let error = self.mobility_error[i] + y[slot] * (row[slot] * y[slot] + 2.0 * cross);
                within &= error <= tolerance * model.entry(n_u + i, n_u + i);
                self.next_error[i] = error;
            }
            if !within {
                return;
            }
            self.mobility_error.copy_from_slice(&self.next_error);
            self.left_out.push(slot);
        }
    }

    /// Lets the contacts left out go on pressing as predicted.
    fn hold_forces(&self, set: &[usize], model: &mut ReducedInterfaceModel, length: f64) {
        let rows = model.contacts() + model.interface();
        for &slot in &self.left_out {
            let force = self.impulses[slot] / length;
            for row in 0..rows {
                model.a[row] += model.entry(row, set[slot]) * force;
            }
        }
    }
}

fn gap_term(model: &ReducedInterfaceModel, contact: usize, length: f64) -> f64 {
    gap_velocity(model.gap[contact], length, length, model.stabilisation)
}
