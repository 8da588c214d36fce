//! One step of the mechanics, foretold from its reduced interface model.

use crate::complementarity::{Checked, ComplementaritySolver, Lcp, SolverCounters};
use crate::error::Failure;
use crate::interface_model::{GapRates, ImpactRows, ImpactStep, Rebounds, ReducedInterfaceModel};
use crate::linear_algebra::body_dot;

/// Solves the contact problem that the mechanics will solve in its own next step, under interface impulses `h λ + p`.
///
/// ```text
/// b_u = w_u + h a_u + H_ui (h λ + p) + gap term        0 ≤ H_uu P + b_u ⟂ P ≥ 0
/// w⁺  = w_i + h a_i + H_ii (h λ + p) + H_iu P
/// ```
/// This is the semi-implicit step itself, to round-off. Of a step of the second order it is a prediction: that one has `H` and `a` of
/// its middle.
#[derive(Clone)]
pub(super) struct StepPrediction {
    solver: Checked,
    h_uu: Vec<f64>,
    /// `b_u` without interface impulses, of contacts that do not rebound; which do; velocities without contact forces; `b_u`.
    term: Vec<f64>,
    rebounds: Rebounds,
    free: Vec<f64>,
    b_u: Vec<f64>,
    /// Contact impulses of the step solved last, N·s.
    pub(super) impulses: Vec<f64>,
    /// `h λ + p`, N·s.
    interface: Vec<f64>,
}

impl StepPrediction {
    /// Makes room for models of the size of `empty`.
    pub(super) fn new(empty: &ReducedInterfaceModel, solver: Checked) -> Self {
        let (n_u, n_i) = (empty.contacts(), empty.interface());
        StepPrediction {
            solver,
            h_uu: vec![0.0; n_u * n_u],
            term: vec![0.0; n_u],
            rebounds: Rebounds::new(n_u, n_u),
            free: vec![0.0; n_u],
            b_u: vec![0.0; n_u],
            impulses: vec![0.0; n_u],
            interface: vec![0.0; n_i],
        }
    }

    /// Takes a model of a communication point.
    pub(super) fn set_model(&mut self, model: &ReducedInterfaceModel) {
        let (n_u, h) = (model.contacts(), model.mechanics_step);
        for contact in 0..n_u {
            for (other, h) in self.h_uu[contact * n_u..(contact + 1) * n_u].iter_mut().enumerate() {
                *h = model.entry(contact, other);
            }
            self.term[contact] = model.w[contact] + h * model.a[contact] + model.step_gap_velocity(contact);
            if let Some(spring) = model.spring {
                self.h_uu[contact * n_u + contact] += spring.diagonal(h, h);
            }
        }
    }

    /// Writes the interface velocity (m/s) after a step under the forces `lambda` (N) and the impulses `p` (N·s).
    ///
    /// # Errors
    /// Those of the complementarity solver.
    pub(super) fn velocity_after(
        &mut self,
        model: &ReducedInterfaceModel,
        lambda: &[f64],
        p: &[f64],
        w: &mut [f64],
    ) -> Result<(), Failure> {
        let (n_u, h) = (model.contacts(), model.mechanics_step);
        let along = |row: usize, first: usize, impulses: &[f64]| -> f64 {
            impulses.iter().enumerate().map(|(j, impulse)| model.entry(row, first + j) * impulse).sum()
        };
        for (impulse, (force, p)) in self.interface.iter_mut().zip(lambda.iter().zip(p)) {
            *impulse = h * force + p;
        }
        for (contact, (b, term)) in self.b_u.iter_mut().zip(&self.term).enumerate() {
            *b = term + along(contact, n_u, &self.interface);
            self.free[contact] = *b - model.step_gap_velocity(contact);
        }
        self.find_rebounds(model)?;
        for (contact, b) in self.b_u.iter_mut().enumerate().filter(|_| self.rebounds.any()) {
            if self.rebounds.rebounds(contact) {
                *b = self.free[contact] + model.restitution * model.w[contact];
            }
        }
        self.solver.solve(Lcp::new(&self.h_uu, &self.b_u), &mut self.impulses)?;
        for (i, w) in w.iter_mut().enumerate() {
            let row = n_u + i;
            let contacts = along(row, 0, &self.impulses);
            *w = model.w[row] + h * model.a[row] + along(row, n_u, &self.interface) + contacts;
        }
        Ok(())
    }

    /// Finds the contacts that rebound.
    fn find_rebounds(&mut self, model: &ReducedInterfaceModel) -> Result<(), Failure> {
        if model.restitution == 0.0 || model.spring.is_some() {
            return Ok(());
        }
        let (n_u, h) = (model.contacts(), model.mechanics_step);
        let step = ImpactStep {
            restitution: model.restitution,
            along: 0.0,
            rates: GapRates::new(h, h, model.stabilisation),
            advance: h,
            closing_time: h,
            tolerance: self.solver.tolerance(),
        };
        let StepPrediction { solver, h_uu, rebounds, free, .. } = self;
        let rows = ImpactRows { gap: &model.gap, w: &model.w[..n_u], free };
        if rebounds.note_hits(&step, rows, |contact| model.own_approach_of(contact)) {
            rebounds.look_ahead(&step, rows, |b, impulses, velocities| {
                solver.solve(Lcp::new(h_uu, b), impulses)?;
                for (contact, velocity) in velocities.iter_mut().enumerate() {
                    let row = &h_uu[contact * n_u..(contact + 1) * n_u];
                    *velocity = b[contact] + body_dot(row, impulses);
                }
                Ok(())
            })?;
        }
        Ok(())
    }

    /// Work so far.
    pub(super) fn counters(&self) -> SolverCounters {
        self.solver.counters()
    }
}
