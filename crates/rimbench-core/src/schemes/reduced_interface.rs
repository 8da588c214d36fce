//! The actuator moves together with a reduced interface model of the mechanics: what all RIM schemes share.
//!
//! At each communication point the model `H, a, w, g` arrives and is frozen (or extrapolated). In each micro step δ the
//! actuator's own force λ drives the model, and the model answers with the interface velocity and position:
//!
//! ```text
//! w_u⁺ = w_u + δ a_u + H_uu P_u + δ H_ui λ        w_i⁺ = w_i + δ a_i + H_iu P_u + δ H_ii λ        s⁺ = s + δ w_i⁺
//! ```
//! The schemes differ in one decision only, [`Contacts`]: what `P_u` is.

use super::active_contacts::ActiveContacts;
use super::contact_choice::ContactChoice;
use super::contact_selection::ContactSelection;
use super::entry::SchemeOptions;
use super::moving_model::MovingModel;
use super::packed_model::PackedModel;
use crate::complementarity::{Checked, ComplementaritySolver, Lcp, SolverCounters};
use crate::cosim::{CouplingScheme, Diagnostics, MicroStep, Ports, Sample, Side};
use crate::error::Failure;
use crate::interface_model::{Condensation, GapRates, ReducedInterfaceModel, condense};

/// How contacts enter the model within the macro step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Contacts {
    /// Contacts closed at `t_k` are bilateral: `w_c⁺ = 0`, eliminated beforehand.
    Bilateral,
    /// Those of them that carry impulse at `t_k` are bilateral, the others are left out.
    BilateralActive,
    /// Contacts closed at `t_k` may open: `0 ≤ w_u⁺ ⟂ P_u ≥ 0`.
    Unilateral,
    /// All contacts are there with their gaps: `0 ≤ w_u⁺ + g/δ ⟂ P_u ≥ 0`, `g⁺ = g + δ w_u⁺`.
    UnilateralWithGaps,
}

/// A coupling scheme made from a reduced interface model.
#[derive(Clone)]
pub(super) struct ReducedInterface {
    contacts: Contacts,
    options: SchemeOptions,
    model: MovingModel,
    /// Contacts in the model, and those of the communication point before.
    set: Vec<usize>,
    previous_set: Vec<usize>,
    closed: Vec<usize>,
    condensation: Condensation,
    diagnosis: Condensation,
    solver: Checked,
    active: ActiveContacts,
    selection: ContactSelection,
    /// The model as a micro step uses it.
    packed: PackedModel,
    /// True until the matrix of `packed` has been given to the solver.
    packed_anew: bool,
    gap_rates: GapRates,
    /// Right-hand side and impulses of the complementarity problem.
    b_u: Vec<f64>,
    p_u: Vec<f64>,
    /// State of the model between communication points: `[w_u; w_i]` with the contacts in the order of `set` (none
    /// where they are bilateral), gaps, interface position.
    w: Vec<f64>,
    /// `w⁺` without contact impulses.
    w_free: Vec<f64>,
    gap: Vec<f64>,
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
            model: MovingModel::new(interface, options.motion),
            set: Vec::new(),
            previous_set: Vec::new(),
            closed: Vec::new(),
            condensation: Condensation::new(0, interface),
            diagnosis: Condensation::new(0, interface),
            solver: options.solver.checked(0),
            active: ActiveContacts::new(0, interface, options.solver),
            selection: ContactSelection::new(0, interface, options.contacts, options.solver),
            packed: PackedModel::new(0, interface),
            packed_anew: true,
            gap_rates: GapRates::default(),
            b_u: Vec::new(),
            p_u: Vec::new(),
            w: vec![0.0; interface],
            w_free: vec![0.0; interface],
            gap: Vec::new(),
            position: vec![0.0; interface],
            force: vec![0.0; interface],
            micro_step: f64::NAN,
        })
    }

    /// Makes all buffers for the size of the first model received; the only place that allocates.
    fn resize(&mut self, model: &ReducedInterfaceModel) {
        let (n_u, n_i) = (model.contacts(), model.interface());
        self.model.resize(model);
        for list in [&mut self.set, &mut self.previous_set, &mut self.closed] {
            *list = Vec::with_capacity(n_u);
        }
        self.condensation = Condensation::new(n_u, n_i);
        self.diagnosis = Condensation::new(n_u, n_i);
        self.solver = self.options.solver.checked(n_u);
        self.active = ActiveContacts::new(n_u, n_i, self.options.solver);
        self.selection = ContactSelection::new(n_u, n_i, self.options.contacts, self.options.solver);
        self.packed = PackedModel::new(n_u, n_i);
        for buffer in [&mut self.b_u, &mut self.p_u, &mut self.gap] {
            *buffer = vec![0.0; n_u];
        }
        for buffer in [&mut self.w, &mut self.w_free] {
            *buffer = vec![0.0; n_u + n_i];
        }
    }

    fn receive_model(&mut self, sample: &Sample<'_>, model: &ReducedInterfaceModel) {
        if !self.model.fits(model) {
            self.resize(model);
        }
        std::mem::swap(&mut self.set, &mut self.previous_set);
        match self.contacts {
            Contacts::UnilateralWithGaps => {
                self.set.clear();
                self.set.extend(0..model.contacts());
            }
            Contacts::Bilateral | Contacts::BilateralActive | Contacts::Unilateral => {
                model.closed_contacts(&mut self.set)
            }
        }
        self.model.receive(sample.time, model);
        self.micro_step = sample.actuator_micro_step;
        // Which contacts carry impulse depends on the force, which arrives next.
        if !self.waits_for_force() {
            self.begin();
        }
    }

    /// Whether the set of contacts depends on the actuator's force.
    fn waits_for_force(&self) -> bool {
        match self.contacts {
            Contacts::Bilateral => false,
            Contacts::BilateralActive => true,
            Contacts::Unilateral | Contacts::UnilateralWithGaps => self.options.contacts != ContactChoice::All,
        }
    }

    /// Sets the model to its start at the communication point, once the set of contacts is known.
    fn begin(&mut self) {
        if self.set != self.previous_set {
            self.model.freeze();
        }
        self.prepare();
        let model = &self.model.received;
        self.gap_rates = GapRates::new(self.micro_step, model.mechanics_step, model.stabilisation);
        let n = self.packed.contacts();
        for (slot, &contact) in self.set[..n].iter().enumerate() {
            self.w[slot] = model.w[contact];
            self.gap[slot] = model.gap[contact];
        }
        let w_i = match self.contacts {
            Contacts::Bilateral | Contacts::BilateralActive => &self.condensation.w[..],
            Contacts::Unilateral | Contacts::UnilateralWithGaps => &model.w[model.contacts()..],
        };
        self.w[n..n + w_i.len()].copy_from_slice(w_i);
        self.position.copy_from_slice(&model.position);
    }

    /// Derives from the model as it stands what a micro step needs.
    fn prepare(&mut self) {
        self.packed_anew = true;
        match self.contacts {
            Contacts::Bilateral | Contacts::BilateralActive => {
                condense(&self.model.current, &self.set, self.options.redundancy, &mut self.condensation);
                self.packed.pack_condensed(&self.condensation, self.micro_step);
            }
            Contacts::Unilateral | Contacts::UnilateralWithGaps => {
                self.packed.pack(&self.model.current, &self.set, self.micro_step);
            }
        }
    }

    /// Fills `w_free` with the velocities without contact impulses, and solves for `p_u`.
    #[inline]
    fn solve_contacts(&mut self, lambda: &[f64]) -> Result<(), Failure> {
        let n = self.packed.contacts();
        let rows = n + lambda.len();
        self.packed.free_velocity(&self.w[..rows], lambda, &mut self.w_free[..rows]);
        match self.contacts {
            Contacts::Bilateral | Contacts::BilateralActive => return Ok(()),
            Contacts::Unilateral => self.b_u[..n].copy_from_slice(&self.w_free[..n]),
            Contacts::UnilateralWithGaps => {
                for (b, (w, gap)) in self.b_u[..n].iter_mut().zip(self.w_free.iter().zip(&self.gap)) {
                    *b = w + self.gap_rates.velocity(*gap);
                }
            }
        }
        if self.model.received.restitution > 0.0 {
            self.bounce(n);
        }
        let lcp = Lcp { m: self.packed.h_uu(), q: &self.b_u[..n] };
        let anew = std::mem::replace(&mut self.packed_anew, false);
        let p_u = &mut self.p_u[..n];
        if anew { self.solver.solve(lcp, p_u) } else { self.solver.attempt_again(lcp, p_u) }.map(|_| ())
    }

    /// Replaces the gap law by the impact law `w⁺ + e w⁻ ≥ 0` where a contact closes within the micro step.
    fn bounce(&mut self, n: usize) {
        let tracked = self.contacts == Contacts::UnilateralWithGaps;
        for slot in 0..n {
            let (w, gap) = (self.w[slot], if tracked { self.gap[slot] } else { 0.0 });
            if w < 0.0 && gap + self.micro_step * w <= 0.0 {
                self.b_u[slot] = self.w_free[slot] + self.model.received.restitution * w;
            }
        }
    }

    /// Leaves out of `set` what does not take part in a macro step of `length` (s).
    fn choose_contacts(&mut self, length: f64) -> Result<(), Failure> {
        if self.contacts == Contacts::BilateralActive {
            return self.active.keep(&mut self.set, &self.model.received, &self.force);
        }
        let tracked = self.contacts == Contacts::UnilateralWithGaps;
        let MovingModel { received, current, .. } = &mut self.model;
        self.selection.select(&mut self.set, received, &self.force, length, tracked)?;
        current.a.copy_from_slice(&received.a);
        Ok(())
    }

    /// Effective mass with the contacts that carry impulse in the first micro step.
    fn active_effective_mass(&mut self) -> Result<f64, Failure> {
        let force = std::mem::take(&mut self.force);
        let solved = self.solve_contacts(&force);
        self.force = force;
        solved?;
        self.closed.clear();
        self.closed.extend(self.set.iter().zip(&self.p_u).filter(|(_, p)| **p > 0.0).map(|(&contact, _)| contact));
        condense(&self.model.received, &self.closed, self.options.redundancy, &mut self.diagnosis);
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
            (Side::Actuator, _) => {
                self.force.copy_from_slice(sample.y);
                if self.waits_for_force() {
                    self.choose_contacts(sample.step.length)?;
                    self.begin();
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Mechanics {
            u.copy_from_slice(&self.force);
            return Ok(());
        }
        debug_assert_eq!(at.length, self.packed.length());
        if self.model.move_to(at.since_exchange + 0.5 * at.length) {
            self.prepare();
        }
        self.solve_contacts(own)?;
        let (n, n_i) = (self.packed.contacts(), own.len());
        std::mem::swap(&mut self.w, &mut self.w_free);
        let w = &mut self.w[..n + n_i];
        self.packed.add_impulses(&self.p_u[..n], w);
        let (w_u, w_i) = w.split_at(n);
        for (gap, w) in self.gap.iter_mut().zip(w_u) {
            *gap += at.length * w;
        }
        let (u_position, u_velocity) = u.split_at_mut(n_i);
        for (i, w) in w_i.iter().enumerate() {
            self.position[i] += at.length * w;
            u_position[i] = self.position[i];
            u_velocity[i] = *w;
        }
        Ok(())
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }

    fn diagnostics(&mut self) -> Diagnostics {
        let effective_mass = match self.contacts {
            Contacts::Bilateral | Contacts::BilateralActive => self.condensation.effective_mass,
            // A problem that cannot be solved here fails the micro step that follows, with its reason.
            Contacts::Unilateral | Contacts::UnilateralWithGaps => self.active_effective_mass().unwrap_or(f64::NAN),
        };
        Diagnostics { effective_mass: Some(effective_mass) }
    }

    fn counters(&self) -> SolverCounters {
        let mut counters = self.solver.counters();
        counters.add(&self.active.counters());
        counters.add(&self.selection.counters());
        counters
    }
}
