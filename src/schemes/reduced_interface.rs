//! The actuator moves together with a reduced interface model of the mechanics: what all RIM schemes share.
//!
//! At each communication point the model `H, a, w, g` arrives and is frozen (or extrapolated). In each micro step δ the
//! actuator's own force λ drives the model, and the model answers with the interface velocity and position:
//!
//! ```text
//! w_u⁺ = w_u + δ a_u + H_uu P_u + δ H_ui λ        w_i⁺ = w_i + δ a_i + H_iu P_u + δ H_ii λ        s⁺ = s + δ w_i⁺
//! ```
//! The schemes differ in one decision only, [`Contacts`]: what `P_u` is.

use super::entry::{ModelMotion, SchemeOptions};
use crate::complementarity::{Checked, ComplementaritySolver, Lcp, SolverCounters};
use crate::cosim::{CouplingScheme, Diagnostics, MicroStep, Ports, Sample, Side};
use crate::error::Failure;
use crate::interface_model::{Condensation, ReducedInterfaceModel, condense, gap_velocity};

/// How contacts enter the model within the macro step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Contacts {
    /// Contacts closed at `t_k` are bilateral: `w_c⁺ = 0`, eliminated beforehand.
    Bilateral,
    /// Contacts closed at `t_k` may open: `0 ≤ w_u⁺ ⟂ P_u ≥ 0`.
    Unilateral,
    /// All contacts are there with their gaps: `0 ≤ w_u⁺ + g/δ ⟂ P_u ≥ 0`, `g⁺ = g + δ w_u⁺`.
    UnilateralWithGaps,
}

/// A coupling scheme made from a reduced interface model.
pub(super) struct ReducedInterface {
    contacts: Contacts,
    options: SchemeOptions,
    /// The model as received, and as it is used in the present micro step.
    received: ReducedInterfaceModel,
    current: ReducedInterfaceModel,
    received_at: f64,
    /// Rates of `H` and `a`; used only where `extrapolating`.
    h_rate: Vec<f64>,
    a_rate: Vec<f64>,
    extrapolating: bool,
    /// Contacts in the model, and those of the communication point before.
    set: Vec<usize>,
    previous_set: Vec<usize>,
    closed: Vec<usize>,
    condensation: Condensation,
    diagnosis: Condensation,
    solver: Checked,
    /// `H_uu` of the set, contiguous; right-hand side; impulses.
    h_uu: Vec<f64>,
    b_u: Vec<f64>,
    p_u: Vec<f64>,
    /// State of the model between communication points; contacts in the order of `set`.
    w_u: Vec<f64>,
    /// `w_u⁺` without contact impulses.
    w_free: Vec<f64>,
    gap: Vec<f64>,
    w_i: Vec<f64>,
    position: Vec<f64>,
    /// The actuator's force at the last communication point.
    force: Vec<f64>,
    micro_step: f64,
}

impl ReducedInterface {
    pub(super) fn boxed(
        contacts: Contacts,
        _mechanics: &Ports,
        actuator: &Ports,
        options: &SchemeOptions,
    ) -> Box<dyn CouplingScheme> {
        let interface = actuator.outputs.len();
        Box::new(ReducedInterface {
            contacts,
            options: *options,
            received: ReducedInterfaceModel::zeros(0, interface),
            current: ReducedInterfaceModel::zeros(0, interface),
            received_at: f64::NAN,
            h_rate: Vec::new(),
            a_rate: Vec::new(),
            extrapolating: false,
            set: Vec::new(),
            previous_set: Vec::new(),
            closed: Vec::new(),
            condensation: Condensation::new(0, interface),
            diagnosis: Condensation::new(0, interface),
            solver: options.solver.checked(0),
            h_uu: Vec::new(),
            b_u: Vec::new(),
            p_u: Vec::new(),
            w_u: Vec::new(),
            w_free: Vec::new(),
            gap: Vec::new(),
            w_i: vec![0.0; interface],
            position: vec![0.0; interface],
            force: vec![0.0; interface],
            micro_step: f64::NAN,
        })
    }

    /// Makes all buffers for the size of the first model received; the only place that allocates.
    fn resize(&mut self, model: &ReducedInterfaceModel) {
        let (n_u, n_i) = (model.contacts(), model.interface());
        self.received = model.clone();
        self.current = model.clone();
        self.h_rate = vec![0.0; model.h.len()];
        self.a_rate = vec![0.0; model.a.len()];
        for list in [&mut self.set, &mut self.previous_set, &mut self.closed] {
            *list = Vec::with_capacity(n_u);
        }
        self.condensation = Condensation::new(n_u, n_i);
        self.diagnosis = Condensation::new(n_u, n_i);
        self.solver = self.options.solver.checked(n_u);
        self.h_uu = vec![0.0; n_u * n_u];
        for buffer in [&mut self.b_u, &mut self.p_u, &mut self.w_u, &mut self.w_free, &mut self.gap] {
            *buffer = vec![0.0; n_u];
        }
    }

    fn receive_model(&mut self, sample: &Sample<'_>, model: &ReducedInterfaceModel) {
        if self.received.contacts() != model.contacts() || self.received_at.is_nan() {
            self.resize(model);
        }
        std::mem::swap(&mut self.set, &mut self.previous_set);
        match self.contacts {
            Contacts::UnilateralWithGaps => {
                self.set.clear();
                self.set.extend(0..model.contacts());
            }
            Contacts::Bilateral | Contacts::Unilateral => model.closed_contacts(&mut self.set),
        }
        self.take_rates(sample.time, model);
        self.received.copy_from(model);
        self.current.copy_from(model);
        self.received_at = sample.time;
        self.micro_step = sample.actuator_micro_step;
        self.prepare();
        let n_u = model.contacts();
        for (slot, &contact) in self.set.iter().enumerate() {
            self.w_u[slot] = model.w[contact];
            self.gap[slot] = model.gap[contact];
        }
        match self.contacts {
            Contacts::Bilateral => self.w_i.copy_from_slice(&self.condensation.w),
            Contacts::Unilateral | Contacts::UnilateralWithGaps => self.w_i.copy_from_slice(&model.w[n_u..]),
        }
        self.position.copy_from_slice(&model.position);
    }

    /// Differences of the last two models, unless the contact set has changed in between.
    fn take_rates(&mut self, time: f64, model: &ReducedInterfaceModel) {
        let elapsed = time - self.received_at;
        model.closed_contacts(&mut self.closed);
        let same_closed = {
            let received = &self.received;
            let was_closed = |contact: usize| received.gap[contact] <= received.contact_margin;
            (0..model.contacts()).all(|contact| was_closed(contact) == self.closed.contains(&contact))
        };
        self.extrapolating = self.options.motion == ModelMotion::Extrapolated
            && elapsed > 0.0
            && same_closed
            && self.set == self.previous_set;
        if self.extrapolating {
            let rates =
                [(&mut self.h_rate, &model.h, &self.received.h), (&mut self.a_rate, &model.a, &self.received.a)];
            for (rate, now, before) in rates {
                for (rate, (now, before)) in rate.iter_mut().zip(now.iter().zip(before)) {
                    *rate = (now - before) / elapsed;
                }
            }
        }
    }

    /// Brings `current` to time `since` after the communication point.
    fn move_model(&mut self, since: f64) {
        let parts = [
            (&mut self.current.h, &self.received.h, &self.h_rate),
            (&mut self.current.a, &self.received.a, &self.a_rate),
        ];
        for (current, received, rate) in parts {
            for (current, (received, rate)) in current.iter_mut().zip(received.iter().zip(rate)) {
                *current = received + since * rate;
            }
        }
        self.prepare();
    }

    /// Derives from `current` what a micro step needs.
    fn prepare(&mut self) {
        if self.contacts == Contacts::Bilateral {
            condense(&self.current, &self.set, self.options.redundancy, &mut self.condensation);
            return;
        }
        let n = self.set.len();
        for (row, &contact) in self.set.iter().enumerate() {
            for (column, &other) in self.set.iter().enumerate() {
                self.h_uu[row * n + column] = self.current.entry(contact, other);
            }
        }
    }

    /// One micro step with the contacts eliminated beforehand.
    #[inline]
    fn bilateral_step(&mut self, delta: f64, lambda: &[f64]) {
        let n_i = self.w_i.len();
        for i in 0..n_i {
            let mut acceleration = self.condensation.a[i];
            for (h, force) in self.condensation.h[i * n_i..(i + 1) * n_i].iter().zip(lambda) {
                acceleration += h * force;
            }
            self.w_i[i] += delta * acceleration;
        }
    }

    /// Fills `b_u` with the contact velocities without contact impulses, and solves for `p_u`.
    #[inline]
    fn solve_contacts(&mut self, delta: f64, lambda: &[f64]) -> Result<(), Failure> {
        let (n, n_u) = (self.set.len(), self.current.contacts());
        for (slot, &contact) in self.set.iter().enumerate() {
            let mut acceleration = self.current.a[contact];
            for (j, force) in lambda.iter().enumerate() {
                acceleration += self.current.entry(contact, n_u + j) * force;
            }
            self.w_free[slot] = self.w_u[slot] + delta * acceleration;
            self.b_u[slot] = self.w_free[slot];
            if self.contacts == Contacts::UnilateralWithGaps {
                let model = &self.current;
                self.b_u[slot] += gap_velocity(self.gap[slot], delta, model.mechanics_step, model.stabilisation);
            }
        }
        let lcp = Lcp { m: &self.h_uu[..n * n], q: &self.b_u[..n] };
        self.solver.solve(lcp, &mut self.p_u[..n]).map(|_| ())
    }

    /// One micro step with a complementarity problem.
    #[inline]
    fn unilateral_step(&mut self, delta: f64, lambda: &[f64]) -> Result<(), Failure> {
        self.solve_contacts(delta, lambda)?;
        let (n, n_u) = (self.set.len(), self.current.contacts());
        for slot in 0..n {
            let from_contacts: f64 =
                self.h_uu[slot * n..(slot + 1) * n].iter().zip(&self.p_u).map(|(h, p)| h * p).sum();
            self.w_u[slot] = self.w_free[slot] + from_contacts;
            self.gap[slot] += delta * self.w_u[slot];
        }
        for (i, w) in self.w_i.iter_mut().enumerate() {
            let row = n_u + i;
            let mut change = delta * self.current.a[row];
            for (j, force) in lambda.iter().enumerate() {
                change += delta * self.current.entry(row, n_u + j) * force;
            }
            for (slot, &contact) in self.set.iter().enumerate() {
                change += self.current.entry(row, contact) * self.p_u[slot];
            }
            *w += change;
        }
        Ok(())
    }

    /// Effective mass with the contacts that carry impulse in the first micro step.
    fn active_effective_mass(&mut self) -> Result<f64, Failure> {
        let force = std::mem::take(&mut self.force);
        let solved = self.solve_contacts(self.micro_step, &force);
        self.force = force;
        solved?;
        self.closed.clear();
        self.closed.extend(self.set.iter().zip(&self.p_u).filter(|(_, p)| **p > 0.0).map(|(&contact, _)| contact));
        condense(&self.received, &self.closed, self.options.redundancy, &mut self.diagnosis);
        Ok(self.diagnosis.effective_mass)
    }
}

impl CouplingScheme for ReducedInterface {
    fn wants_interface_model(&self) -> bool {
        true
    }

    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        match (from, sample.model) {
            (Side::Mechanics, Some(model)) => self.receive_model(sample, model),
            (Side::Mechanics, None) => {}
            (Side::Actuator, _) => self.force.copy_from_slice(sample.y),
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Mechanics {
            u.copy_from_slice(&self.force);
            return Ok(());
        }
        if self.extrapolating {
            self.move_model(at.since_exchange + 0.5 * at.length);
        }
        match self.contacts {
            Contacts::Bilateral => self.bilateral_step(at.length, own),
            Contacts::Unilateral | Contacts::UnilateralWithGaps => self.unilateral_step(at.length, own)?,
        }
        let n_i = self.w_i.len();
        for i in 0..n_i {
            self.position[i] += at.length * self.w_i[i];
            u[i] = self.position[i];
            u[n_i + i] = self.w_i[i];
        }
        Ok(())
    }

    fn diagnostics(&mut self) -> Diagnostics {
        let effective_mass = match self.contacts {
            Contacts::Bilateral => self.condensation.effective_mass,
            // A problem that cannot be solved here fails the micro step that follows, with its reason.
            Contacts::Unilateral | Contacts::UnilateralWithGaps => self.active_effective_mass().unwrap_or(f64::NAN),
        };
        Diagnostics { effective_mass: Some(effective_mass) }
    }

    fn counters(&self) -> SolverCounters {
        self.solver.counters()
    }
}
