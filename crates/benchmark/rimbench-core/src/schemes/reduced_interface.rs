//! The actuator moves together with a reduced interface model of the mechanics: what all RIM schemes share.
//!
//! At each communication point `t_k` the model `H, a, w, g` arrives; [`MovingModel`] holds or extrapolates it. In each
//! micro step δ the force λ of the actuator at its start drives the model, which answers with interface velocity and
//! position: Eq. 4 over δ, with `b = w + δ a` and `P_u = δ λ_u⁺`.
//!
//! ```text
//! w_u⁺ = w_u + δ a_u + H_uu P_u + δ H_ui λ        w_i⁺ = w_i + δ a_i + H_iu P_u + δ H_ii λ        s⁺ = s + δ w_i⁺
//! ```
//! The schemes differ in one decision only, [`Contacts`]: the condition on `w_u⁺` and `P_u` ([`ModelContacts`] solves
//! it). [`ContactSet`] detects the contacts of the macro step. Micro steps of the second order are in [`second_order`],
//! contacts that act over the mechanics' own step in [`own_step`].

mod construction;
mod contact_set;
mod effective_mass;
mod forecast;
mod gap_law;
mod model_end;
mod own_step;
mod second_order;
mod targets;

pub(super) use contact_set::Contacts;

use self::contact_set::ContactSet;
use self::effective_mass::EffectiveMass;
use self::gap_law::GapTerm;
use self::own_step::OwnStep;
use self::targets::Targets;
use super::construction::sent;
use super::implicit_feedthrough::ImplicitFeedthrough;
use super::model_contacts::{FrozenModel, ModelContacts, ModelState};
use super::moving_model::MovingModel;
use super::recorded_modes::RecordedModes;
use super::slip_rows::SlipRows;
use crate::cosim::{CouplingScheme, Forecast, MacroStep, MicroStep, ModelEnd, Sample, SchemeReport, Side};
use crate::error::Failure;
use crate::interface_model::{Condensation, condense_in_modes};
use rimbench_contact::affine_step::{DiscretisedModel, StepContactLaw};

/// A coupling scheme made from a reduced interface model.
#[derive(Clone)]
pub(super) struct ReducedInterface {
    /// The contacts of the model, detected at the communication point.
    set: ContactSet,
    /// Where contacts in space have one tangential row: the model with it.
    slip_rows: Option<Box<SlipRows>>,
    /// Eq. 4 as received, and as it stands in this micro step.
    model: MovingModel,
    /// Eq. 4 over the step in which contacts act, for those of the set.
    discretised: DiscretisedModel,
    /// Where contacts are bilateral: Eq. 4 with their impulses eliminated.
    condensation: Condensation,
    /// With friction: stick or slip of each contact, as the scheme found it last.
    modes: RecordedModes,
    /// Finds `P_u`.
    contacts: ModelContacts,
    gap_term: GapTerm,
    law: StepContactLaw,
    /// `w, w⁺, g, P_u, s`.
    state: ModelState,
    /// The actuator's force at the last communication point.
    force: Vec<f64>,
    /// Where micro steps are of the second order: the derivative of the force with respect to the motion.
    feedthrough: ImplicitFeedthrough,
    micro_step: f64,
    /// Steps that the mechanics takes in the macro step, with those that it takes inside of each.
    engine_steps: usize,
    /// The step in which contacts act, s.
    contact_step: f64,
    mass: EffectiveMass,
    /// Where contacts act over the mechanics' own step.
    own: Option<Box<OwnStep>>,
    /// Where contacts are rows of an engine that takes several steps.
    targets: Targets,
}

impl ReducedInterface {
    /// Starts the macro step from `w`, `g` and `s` of the received model, once its contacts are detected.
    fn begin(&mut self) -> Result<(), Failure> {
        if self.set.has_changed() {
            // `H` and `a` of two communication points have no rate across a change of contacts.
            self.model.freeze();
        }
        self.contacts.set_contacts(self.set.contacts(), &self.model.received);
        self.discretise()?;
        let model = &self.model.received;
        self.law = self.gap_term.law(model, self.contact_step);
        let (n, state) = (self.discretised.contacts(), &mut self.state);
        for (w, &row) in state.w_plus[..n].iter_mut().zip(self.contacts.rows(self.set.contacts())) {
            *w = model.w[row];
        }
        for (gap, &contact) in state.gap.iter_mut().zip(self.set.contacts()) {
            *gap = if self.gap_term == GapTerm::None { 0.0 } else { model.gap[contact] };
        }
        let bilateral = matches!(self.contacts, ModelContacts::Bilateral);
        let w_i = if bilateral { &self.condensation.w[..] } else { &model.w[model.interface_start()..] };
        state.w_plus[n..n + w_i.len()].copy_from_slice(w_i);
        state.position.copy_from_slice(&model.position);
        self.mass.bilateral = self.condensation.effective_mass;
        self.targets.start(model, self.engine_steps);
        if let Some(own) = &mut self.own {
            own.start_part(&mut self.state, n, 0);
        }
        Ok(())
    }

    /// Discretises Eq. 4 over the step in which contacts act: `δ a`, `δ H_·i`, `H_·u`; the compliance of contacts goes
    /// to the diagonal of `H_uu`.
    fn discretise(&mut self) -> Result<(), Failure> {
        self.contacts.leave_region(&self.law, &mut self.state);
        let bilateral = matches!(self.contacts, ModelContacts::Bilateral);
        if bilateral {
            let (model, modes) = (self.model.current(), self.modes.get());
            condense_in_modes(model, modes, self.set.contacts(), &mut self.condensation);
            let Condensation { a, h, .. } = &self.condensation;
            let symmetric = !model.unsymmetric && !self.condensation.is_unsymmetric();
            self.discretised.discretise_interface(a, h, symmetric, self.contact_step);
        } else {
            let rows = self.contacts.rows(self.set.contacts());
            self.discretised.discretise(self.model.current().linear(), rows, self.contact_step);
        }
        if self.feedthrough.is_on() {
            self.feedthrough.eliminate_from(&mut self.discretised)?;
        }
        if let (false, Some(spring)) = (bilateral, self.model.received.spring) {
            let opening_time = self.gap_term.opening_time(&self.model.received, self.contact_step);
            self.discretised.regularise(self.set.contacts().len(), spring.diagonal(self.contact_step, opening_time));
        }
        Ok(())
    }

    /// Takes one micro step of Eq. 4 under the force `lambda` (N), from `w⁺` of the last one.
    #[inline(always)]
    fn step(&mut self, lambda: &[f64], at: MicroStep) -> Result<(), Failure> {
        if self.targets.is_on() {
            return self.step_with_targets(lambda, at);
        }
        self.step_to_targets(lambda, at)
    }

    #[inline(always)]
    fn step_to_targets(&mut self, lambda: &[f64], at: MicroStep) -> Result<(), Failure> {
        let ReducedInterface { discretised, law, set, model, contacts, state, .. } = self;
        std::mem::swap(&mut state.w, &mut state.w_plus);
        if !contacts.step_in_region(discretised, law, state, lambda, at) {
            let frozen = FrozenModel { discretised, law, set: set.contacts(), received: &model.received };
            contacts.solve(frozen, state, lambda)?;
        }
        if at.index == 0 {
            self.record_first_step();
        }
        Ok(())
    }

    /// Takes the micro step with targets that are taken anew where a step of the engine begins.
    #[inline(never)]
    fn step_with_targets(&mut self, lambda: &[f64], at: MicroStep) -> Result<(), Failure> {
        let (n, part) = (self.discretised.contacts(), |index: usize| index * self.engine_steps / at.count);
        if at.index == 0 || part(at.index) != part(at.index - 1) {
            self.targets.end_step(&mut self.state.w_plus[..n]);
        }
        self.targets.add_more(at.length, &mut self.state.w_plus[..n]);
        self.step_to_targets(lambda, at)?;
        self.targets.add_impulses(at.length, 1.0, &self.state.impulses[..n]);
        Ok(())
    }

    /// Sets the steps of a macro step in which the mechanics takes so many of its own.
    fn set_steps(&mut self, step: MacroStep, micro_step: f64, mechanics_steps: usize) {
        (self.micro_step, self.contact_step) = (micro_step, micro_step);
        self.engine_steps = mechanics_steps * self.model.received.own_steps;
        if let Some(own) = &mut self.own {
            self.contact_step = own.set_steps(step.length, self.engine_steps);
        }
    }

    /// Records which contacts carried impulse in the first micro step, and stick or slip.
    #[inline(never)]
    fn record_first_step(&mut self) {
        let ReducedInterface { discretised, set, modes, contacts, state, mass, .. } = self;
        mass.record(set.contacts(), &state.impulses[..discretised.contacts()]);
        contacts.record_modes(discretised, set.contacts(), &state.w_plus, modes);
    }
}

impl CouplingScheme for ReducedInterface {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        if from == Side::Mechanics {
            let mut model = sent(sample.model)?;
            if let Some(rows) = &mut self.slip_rows {
                rows.write(model);
                model = rows.plane();
            }
            // Impulses are still those of the last micro step of the macro step that ends here.
            // Rows of an engine stand for others now.
            let known = if model.has_targets { 0 } else { self.discretised.contacts() };
            self.mass.record(self.set.contacts(), &self.state.impulses[..known]);
            self.set.detect(model);
            self.modes.start_from(model);
            self.model.receive(sample.time, model);
            self.set_steps(sample.step, sample.actuator_micro_step, sample.mechanics_steps);
            // The contacts that carry impulse depend on the force, which arrives next.
            return if self.set.waits_for_force() { Ok(()) } else { self.begin() };
        }
        self.force.copy_from_slice(sample.y);
        if self.set.waits_for_force() {
            self.set.keep_active(&mut self.model, &self.force, &mut self.modes)?;
            self.begin()?;
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Mechanics {
            u.copy_from_slice(&self.force);
            return Ok(());
        }
        if self.own.is_some() {
            return self.input_over_own_step(at, own, u);
        }
        debug_assert_eq!(at.length, self.discretised.length());
        if self.model.move_to(at) {
            self.discretise()?;
        }
        if self.feedthrough.is_on() {
            return self.input_of_second_order(at, own, u);
        }
        self.step(own, at)?;
        let (n, n_i) = (self.discretised.contacts(), own.len());
        if let ([u_position, u_velocity], [position]) = (&mut *u, &mut *self.state.position) {
            // As below, of one row.
            let w = self.state.w_plus[n];
            *position += at.length * w;
            (*u_position, *u_velocity) = (*position, w);
            return Ok(());
        }
        let (u_position, u_velocity) = u.split_at_mut(n_i);
        for (i, w) in self.state.w_plus[n..n + n_i].iter().enumerate() {
            // s⁺ = s + δ w_i⁺
            let s = self.state.position[i] + at.length * w;
            self.state.position[i] = s;
            (u_position[i], u_velocity[i]) = (s, *w);
        }
        Ok(())
    }

    fn receive_feedthrough(&mut self, feedthrough: &[f64]) -> Result<(), Failure> {
        if self.feedthrough.set(feedthrough, self.micro_step) { self.discretise() } else { Ok(()) }
    }

    fn change_macro_step(&mut self, step: MacroStep, micro_step: f64, mechanics_steps: usize) -> Result<(), Failure> {
        self.model.go_on_from(step.start);
        if self.own.is_none() && self.micro_step == micro_step {
            return Ok(());
        }
        self.end_own_steps()?;
        self.set_steps(step, micro_step, mechanics_steps);
        self.discretise()?;
        self.law = self.gap_term.law(&self.model.received, self.contact_step);
        Ok(())
    }

    fn input_at_end(&self, to: Side, u: &mut [f64]) {
        for row in 0..self.state.position.len() {
            self.row_at_end(to, row, u);
        }
    }

    fn forecast(&self) -> Option<Forecast<'_>> {
        Some(Forecast { position: &self.state.position, next_closing: self.next_closing() })
    }

    fn model_end(&mut self) -> Option<ModelEnd<'_>> {
        self.end_of_macro_step()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }

    fn loaded_mobility(&mut self) -> Option<&[f64]> {
        self.mass.loaded_mobility(&self.model.received, self.modes.get())
    }

    fn report(&mut self) -> SchemeReport {
        let effective_mass = match self.contacts {
            ModelContacts::Bilateral => self.mass.bilateral,
            _ => self.mass.of_strongly_active(&self.model.received, self.modes.get()),
        };
        let mut counters = self.contacts.counters();
        counters.add(&self.set.counters());
        counters.parametric += self.own.as_ref().map_or(0, |own| own.multiples());
        SchemeReport { effective_mass: Some(effective_mass), counters, ..SchemeReport::default() }
    }
}
