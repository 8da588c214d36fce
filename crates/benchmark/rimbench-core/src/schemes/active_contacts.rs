//! Which of the closed contacts carry impulse at a communication point.

use super::coulomb_contacts::{CoulombContacts, SpaceContacts};
use super::model_contacts::{ContactSolver, Posed, Signorini};
use super::recorded_modes::RecordedModes;
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;
use rimbench_contact::affine_step::DiscretisedModel;
use rimbench_contact::complementarity::SolverCounters;
use rimbench_contact::linear_algebra::largest_entry;
use rimbench_contact::solver_entry::SolverEntry;

/// Solves the contacts that are closed at `t_k` once, over one step `h` of the mechanics with the actuator's force
/// held.
///
/// ```text
/// w_c⁺ = w_c + h a_c + h H_ci λ + H_cc P_c      0 ≤ w_c⁺ ⟂ P_c ≥ 0      active = {α : P_α > 0}
/// ```
/// By the law of the mechanics' step, `w_c⁺ + max(g, 0)/h + γ min(g, 0)/h` stands for `w_c⁺`.
#[derive(Clone)]
pub(super) struct ActiveContacts {
    solver: ActiveSolver,
    problem: Problem,
}

#[derive(Clone)]
enum ActiveSolver {
    Signorini(Box<Signorini>),
    Coulomb(Box<CoulombContacts>),
    Space(Box<SpaceContacts>),
}

/// Eq. 4 over one step of the mechanics.
#[derive(Clone)]
struct Problem {
    discretised: DiscretisedModel,
    w: Vec<f64>,
    /// `b`, then `w⁺`.
    free: Vec<f64>,
    impulses: Vec<f64>,
}

impl Problem {
    /// Poses the problem of the contacts `closed`, solves it, and records their modes where they have friction.
    fn solve<S: ContactSolver>(
        &mut self,
        solver: &mut S,
        (closed, model, lambda, by_law): (&[usize], &ReducedInterfaceModel, &[f64], bool),
        modes: &mut RecordedModes,
    ) -> Result<(), Failure> {
        solver.set_contacts(closed, model);
        let set = solver.rows(closed);
        let (n, rows) = (set.len(), set.len() + lambda.len());
        self.discretised.discretise(model.linear(), set, model.mechanics_step);
        for (w, &row) in self.w.iter_mut().zip(set) {
            *w = model.w[row];
        }
        self.w[n..rows].copy_from_slice(&model.w[model.interface_start()..]);
        self.discretised.free_velocity(&self.w[..rows], lambda, &mut self.free[..rows]);
        if by_law {
            if let Some(spring) = model.spring {
                self.discretised.regularise(closed.len(), spring.diagonal(model.mechanics_step, model.mechanics_step));
            }
            for (b, &contact) in self.free.iter_mut().zip(closed) {
                *b += model.step_gap_velocity(contact);
            }
        }
        let posed = Posed { model: &self.discretised, changed: true, b: &self.free[..n] };
        solver.solve(posed, &mut self.impulses[..n])?;
        if S::ROWS > 1 {
            let rounding = solver.tolerance() * largest_entry(&self.free[..n]);
            self.discretised.add_impulses(&self.impulses[..n], &mut self.free[..rows]);
            solver.record_modes(closed, &self.free[..n], rounding, modes);
        }
        Ok(())
    }
}

impl ActiveContacts {
    /// Reserves models like this one.
    pub(super) fn of(model: &ReducedInterfaceModel, solver: &SolverEntry) -> Self {
        let (rows, interface) = (model.interface_start(), model.interface());
        if let Some(contacts) = SpaceContacts::of(model, solver) {
            return Self::with(ActiveSolver::Space(contacts), rows, interface);
        }
        match CoulombContacts::of(model, solver) {
            Some(contacts) => Self::with(ActiveSolver::Coulomb(contacts), rows, interface),
            None => Self::with(ActiveSolver::Signorini(Box::new(Signorini(solver.checked(rows)))), rows, interface),
        }
    }

    /// Reserves nothing, for a scheme that never asks.
    pub(super) fn none(solver: &SolverEntry) -> Self {
        Self::with(ActiveSolver::Signorini(Box::new(Signorini(solver.checked(0)))), 0, 0)
    }

    fn with(solver: ActiveSolver, rows: usize, interface: usize) -> Self {
        let w = vec![0.0; rows + interface];
        let discretised = DiscretisedModel::new(rows, interface);
        ActiveContacts { solver, problem: Problem { discretised, free: w.clone(), w, impulses: vec![0.0; rows] } }
    }

    /// Reduces `closed` to the contacts that carry impulse under the force `lambda` (N), by the law of the mechanics'
    /// step or without, and records their modes where they have friction.
    ///
    /// # Errors
    /// As the contact solver reports.
    pub(super) fn keep(
        &mut self,
        closed: &mut Vec<usize>,
        model: &ReducedInterfaceModel,
        lambda: &[f64],
        by_law: bool,
        modes: &mut RecordedModes,
    ) -> Result<(), Failure> {
        let ActiveContacts { solver, problem } = self;
        let given = (&**closed, model, lambda, by_law);
        match solver {
            ActiveSolver::Signorini(solver) => problem.solve(&mut **solver, given, modes)?,
            ActiveSolver::Coulomb(solver) => problem.solve(&mut **solver, given, modes)?,
            ActiveSolver::Space(solver) => problem.solve(&mut **solver, given, modes)?,
        }
        let mut carries = self.problem.impulses.iter().map(|impulse| *impulse > 0.0);
        closed.retain(|_| carries.next().unwrap_or(false));
        Ok(())
    }

    /// Returns the velocities (m/s) of the interface after the problem last solved, of contacts with friction.
    pub(super) fn interface_velocity(&self) -> &[f64] {
        &self.problem.free[self.problem.discretised.contacts()..]
    }

    /// Returns the counts of the problems solved.
    pub(super) fn counters(&self) -> SolverCounters {
        match &self.solver {
            ActiveSolver::Signorini(solver) => solver.counters(),
            ActiveSolver::Coulomb(contacts) => contacts.counters(),
            ActiveSolver::Space(contacts) => contacts.counters(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_contact::friction::ContactState;

    #[test]
    fn a_contact_is_active_when_it_is_pressed_and_not_when_it_is_pulled() {
        // A mass of 2 kg on the floor (w_u = w_i) that falls with 1 m/s² or less: 4 N up lift it, 1 N does not.
        let mut model = ReducedInterfaceModel::zeros(2, 1);
        let row = [0.5, 0.0, 0.5];
        model.h.copy_from_slice(&[row, [0.0, 1.0, 0.0], row].concat());
        model.a.copy_from_slice(&[-1.0, 5.0, -1.0]);
        model.mechanics_step = 0.1;
        let mut active = ActiveContacts::of(&model, &SolverEntry::active_set());
        for (force, left) in [(1.0, &[0][..]), (4.0, &[]), (-4.0, &[0])] {
            let mut closed = vec![0, 1];
            active.keep(&mut closed, &model, &[force], false, &mut RecordedModes::of(&model)).unwrap();
            assert_eq!(closed, left, "{force} N");
        }
        // What is not closed is not asked.
        let mut closed = vec![1];
        active.keep(&mut closed, &model, &[0.0], false, &mut RecordedModes::of(&model)).unwrap();
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
        let mut active = ActiveContacts::of(&model, &SolverEntry::active_set());
        for (gap, left) in [(9e-5, &[0][..]), (1.1e-4, &[])] {
            model.gap[0] = gap;
            let mut closed = vec![0];
            active.keep(&mut closed, &model, &[0.0], true, &mut RecordedModes::of(&model)).unwrap();
            assert_eq!(closed, left, "{gap} m");
        }
    }

    /// A level block of 1 kg on two corners, pushed with less than both hold and more than one: their tangential rows
    /// are equal, and the solver loads one of them up to its border. Neither has slid.
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
        let mut modes = RecordedModes::of(&model);
        active.keep(&mut closed, &model, &[0.3], false, &mut modes).unwrap();
        let ActiveSolver::Coulomb(contacts) = &active.solver else { unreachable!("the model has friction") };
        let solved = contacts.solver.solver.states();
        assert!(solved.iter().any(|state| state.friction() != 0.0), "one is at its border: {solved:?}");
        assert_eq!(modes.get().states, [ContactState::Stick; 2]);
    }
}
