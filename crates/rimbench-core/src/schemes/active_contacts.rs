//! Which of the closed contacts carry impulse at a communication point.

use super::coulomb_contacts::CoulombContacts;
use super::discretised_model::DiscretisedModel;
use crate::complementarity::{Checked, ComplementaritySolver, Lcp, SolverCounters, SolverEntry};
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;

/// Solves the contacts that are closed at `t_k` once, over one step `h` of the mechanics with the actuator's force held.
///
/// ```text
/// w_c⁺ = w_c + h a_c + h H_ci λ + H_cc P_c      0 ≤ w_c⁺ ⟂ P_c ≥ 0      active = {α : P_α > 0}
/// ```
/// With the law of the mechanics' step, `w_c⁺ + max(g, 0)/h + γ min(g, 0)/h` stands for `w_c⁺`.
#[derive(Clone)]
pub(super) struct ActiveContacts {
    solver: Checked,
    discretised: DiscretisedModel,
    w: Vec<f64>,
    w_free: Vec<f64>,
    impulses: Vec<f64>,
    friction: Option<Box<CoulombContacts>>,
}

impl ActiveContacts {
    /// Makes room for models with up to `contacts` contacts and `interface` interface rows.
    pub(super) fn new(contacts: usize, interface: usize, solver: &SolverEntry) -> Self {
        ActiveContacts {
            friction: None,
            solver: solver.checked(contacts),
            discretised: DiscretisedModel::new(contacts, interface),
            w: vec![0.0; contacts + interface],
            w_free: vec![0.0; contacts + interface],
            impulses: vec![0.0; contacts],
        }
    }

    /// The same for models like this one, with friction if it has that.
    pub(super) fn of(model: &ReducedInterfaceModel, solver: &SolverEntry) -> Self {
        let friction = CoulombContacts::of(model, solver);
        ActiveContacts { friction, ..Self::new(model.interface_start(), model.interface(), solver) }
    }

    /// Reduces `closed` to the contacts that carry impulse under the force `lambda` (N), as [`keep`](Self::keep) does, and writes to the model what
    /// they do.
    ///
    /// # Errors
    /// Those of the solver.
    pub(super) fn keep_with_friction(
        &mut self,
        closed: &mut Vec<usize>,
        model: &mut ReducedInterfaceModel,
        lambda: &[f64],
        law: bool,
    ) -> Result<(), Failure> {
        let (Some(friction), m) = (&mut self.friction, closed.len()) else { return Ok(()) };
        friction.take(closed, model);
        let n = friction.stacked_rows().len();
        let rows = n + lambda.len();
        self.discretised.discretise(model, friction.stacked_rows(), model.mechanics_step);
        for (w, &row) in self.w.iter_mut().zip(friction.stacked_rows()) {
            *w = model.w[row];
        }
        self.w[n..rows].copy_from_slice(&model.w[model.interface_start()..]);
        self.discretised.free_velocity(&self.w[..rows], lambda, &mut self.w_free[..rows]);
        if law {
            for (w, &contact) in self.w_free[..m].iter_mut().zip(&*closed) {
                *w += model.step_gap_velocity(contact);
            }
        }
        friction.solve(&self.discretised, true, &self.w_free[..n], &mut self.impulses[..n])?;
        let standstill = friction.tolerance() * self.w_free[..n].iter().fold(0.0, |max: f64, b| max.max(b.abs()));
        self.discretised.add_impulses(&self.impulses[..n], &mut self.w_free[..rows]);
        friction.note_states(closed, model, &self.w_free[m..n], standstill);
        let mut carries = self.impulses.iter().map(|impulse| *impulse > 0.0);
        closed.retain(|_| carries.next().unwrap_or(false));
        Ok(())
    }

    /// Reduces `closed` to the contacts that carry impulse under the force `lambda` (N), with the law of the mechanics' step or
    /// without.
    ///
    /// # Errors
    /// Those of the complementarity solver.
    pub(super) fn keep(
        &mut self,
        closed: &mut Vec<usize>,
        model: &ReducedInterfaceModel,
        lambda: &[f64],
        law: bool,
    ) -> Result<(), Failure> {
        let (n, rows) = (closed.len(), closed.len() + lambda.len());
        self.discretised.discretise(model, closed, model.mechanics_step);
        for (slot, &contact) in closed.iter().enumerate() {
            self.w[slot] = model.w[contact];
        }
        self.w[n..rows].copy_from_slice(&model.w[model.interface_start()..]);
        self.discretised.free_velocity(&self.w[..rows], lambda, &mut self.w_free[..rows]);
        if law {
            if let Some(spring) = model.spring {
                self.discretised.regularise(spring.diagonal(model.mechanics_step, model.mechanics_step));
            }
            for (w, &contact) in self.w_free[..n].iter_mut().zip(&*closed) {
                *w += model.step_gap_velocity(contact);
            }
        }
        let lcp = Lcp::new(self.discretised.h_uu(), &self.w_free[..n]);
        self.solver.solve(lcp, &mut self.impulses[..n])?;
        let mut carries = self.impulses.iter().map(|impulse| *impulse > 0.0);
        closed.retain(|_| carries.next().unwrap_or(false));
        Ok(())
    }

    pub(super) fn counters(&self) -> SolverCounters {
        let mut counters = self.solver.counters();
        if let Some(friction) = &self.friction {
            counters.add(&friction.counters());
        }
        counters
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::ContactState;

    #[test]
    fn a_contact_is_active_when_it_is_pressed_and_not_when_it_is_pulled() {
        // A mass of 2 kg on the floor (w_u = w_i) that falls with 1 m/s² or less: 4 N up lift it, 1 N does not.
        let mut model = ReducedInterfaceModel::zeros(2, 1);
        let row = [0.5, 0.0, 0.5];
        model.h.copy_from_slice(&[row, [0.0, 1.0, 0.0], row].concat());
        model.a.copy_from_slice(&[-1.0, 5.0, -1.0]);
        model.mechanics_step = 0.1;
        let mut active = ActiveContacts::new(2, 1, &SolverEntry::active_set());
        for (force, left) in [(1.0, &[0][..]), (4.0, &[]), (-4.0, &[0])] {
            let mut closed = vec![0, 1];
            active.keep(&mut closed, &model, &[force], false).unwrap();
            assert_eq!(closed, left, "{force} N");
        }
        // What is not closed is not asked.
        let mut closed = vec![1];
        active.keep(&mut closed, &model, &[0.0], false).unwrap();
        assert!(closed.is_empty());
        assert_eq!(active.counters().solves, 4);
    }

    #[test]
    fn with_the_law_of_the_step_an_open_contact_is_active_only_if_it_closes_in_that_step() {
        // 2 kg that fall with 1 m/s² from rest: 10 mm/s and less after 10 ms and less, that is up to 100 µm.
        let mut model = ReducedInterfaceModel::zeros(1, 1);
        model.h.fill(0.5);
        model.a.fill(-1.0);
        model.mechanics_step = 0.01;
        let mut active = ActiveContacts::new(1, 1, &SolverEntry::active_set());
        for (gap, left) in [(9e-5, &[0][..]), (1.1e-4, &[])] {
            model.gap[0] = gap;
            let mut closed = vec![0];
            active.keep(&mut closed, &model, &[0.0], true).unwrap();
            assert_eq!(closed, left, "{gap} m");
        }
    }

    /// A level block of 1 kg on two corners, pushed with less than both hold and more than one: their tangential rows are the same, and the
    /// solver loads one of them up to its border. Neither has slid.
    #[test]
    fn a_contact_at_the_border_of_its_cone_that_does_not_move_must_stick() {
        let mut model = ReducedInterfaceModel::zeros_with_friction(&[0.4, 0.4], 1);
        let rows = [[0.0, 1.0, -0.5], [0.0, 1.0, 0.5], [1.0, 0.0, 0.2], [1.0, 0.0, 0.2], [1.0, 0.0, 0.0]];
        let inverse_mass = [1.0, 1.0, 1.0 / 0.3];
        for (i, a) in rows.iter().enumerate() {
            for (j, b) in rows.iter().enumerate() {
                model.h[5 * i + j] = (0..3).map(|k| a[k] * inverse_mass[k] * b[k]).sum();
            }
            model.a[i] = -a[1];
        }
        model.mechanics_step = 0.1;
        let mut active = ActiveContacts::of(&model, &SolverEntry::active_set());
        let mut closed = vec![0, 1];
        active.keep_with_friction(&mut closed, &mut model, &[0.3], false).unwrap();
        let solved = active.friction.as_ref().map(|friction| friction.states().to_vec()).unwrap();
        assert!(solved.iter().any(|state| state.friction() != 0.0), "one is at its border: {solved:?}");
        assert_eq!(model.states, [ContactState::Stick; 2]);
    }
}
