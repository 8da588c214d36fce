//! How both sides cover a macro step, and with how many steps of their own.

use super::CoupledPair;
use crate::cosim::communication_grid::{MacroStep, MicroStep};
use crate::cosim::coupling_scheme::CouplingScheme;
use crate::cosim::exchange_data::{NO_OUTPUT_RATES, NO_PIECES};
use crate::cosim::force_return::{ForceReturn, Sequence};
use crate::cosim::interface_work::InterfaceWork;
use crate::cosim::micro_log::{record_micro_step, record_midpoint};
use crate::cosim::output_history::ForceProfile;
use crate::cosim::pair_state::PairState;
use crate::cosim::sent_model::SentModel;
use crate::cosim::side::Side;
use crate::cosim::step_size_control::MacroInterval;
use crate::cosim::subsystem::Subsystem;
use crate::cosim::trial_steps::TrialSteps;
use crate::error::{Cause, Failure};
use std::ops::Range;

impl CoupledPair<'_> {
    /// Lets both sides cover a macro step in their sequence.
    pub(crate) fn advance(&mut self, interval: MacroInterval) -> Result<(), Failure> {
        let step = interval.step;
        match self.setup.sequence {
            Sequence::Jacobi | Sequence::GaussSeidel { first: Side::Actuator } => {
                self.advance_actuator(step)?;
                self.advance_mechanics(step)?;
            }
            Sequence::GaussSeidel { first: Side::Mechanics } => {
                self.advance_mechanics(step)?;
                self.sides.mechanics.outputs(&self.state.u.mechanics, &mut self.state.y.mechanics)?;
                self.send_fresh_sample(Side::Mechanics, interval)?;
                self.advance_actuator(step)?;
            }
        }
        self.state.counters.macro_steps += 1;
        if self.state.model.as_ref().is_some_and(|model| model.audit.is_some()) {
            self.audit(step);
        }
        Ok(())
    }

    /// Closes the account of the scheme's interface model for a macro step.
    #[cold]
    fn audit(&mut self, step: MacroStep) {
        let InterfaceWork { sent_j, received_j } = self.interface_work();
        let PairState { model, history, .. } = &mut *self.state;
        let Some(SentModel { model, audit: Some(audit), in_time, .. }) = model.as_deref_mut() else { return };
        let Some(in_time) = in_time else {
            return audit.finish(model, step, history, &mut *self.scheme, [sent_j, received_j]);
        };
        let sent_in_time = in_time.work_sent.sent();
        audit.finish(model, step, history, &mut *in_time.scheme.0, [sent_in_time, received_j]);
        audit.set_age(sent_in_time.zip(sent_j).map(|(in_time, sent)| in_time - sent));
    }

    /// Lets one side cover a macro step.
    pub(crate) fn advance_side(&mut self, side: Side, step: MacroStep) -> Result<(), Failure> {
        match side {
            Side::Mechanics => self.advance_mechanics(step),
            Side::Actuator => self.advance_actuator(step),
        }
    }

    /// Lets the actuator cover a macro step, micro step by micro step.
    ///
    /// ```text
    /// first order     y   = y(x, u)             with the input of the micro step before
    /// second order    y_m = y(x, u) + ½δ r      outputs in the middle with the inputs of the start; r their rate with inputs held
    ///                 ū   = the scheme's, given y_m and D = ∂y/∂u
    ///                 ȳ   = y_m + D (ū − u)     what acts during the micro step, and is handed to the mechanics
    /// both            x⁺  = the subsystem's own step with the scheme's input
    /// ```
    pub(crate) fn advance_actuator(&mut self, step: MacroStep) -> Result<(), Failure> {
        self.advance_actuator_part(step, 0..self.setup.actuator_steps(step))
    }

    /// Lets the actuator cover the next micro steps, some of those of a macro step.
    pub(crate) fn advance_actuator_part(&mut self, step: MacroStep, part: Range<usize>) -> Result<(), Failure> {
        let ports = (self.state.own.actuator.len(), self.state.u.actuator.len());
        match (self.state.rates.is_some(), ports) {
            // One row, as it mostly is.
            (false, (1, 2)) => self.actuate::<1>(step, part, (1, 2)),
            (false, _) => self.actuate::<1>(step, part, ports),
            (true, _) => self.actuate::<2>(step, part, ports),
        }
    }

    /// [`advance_actuator`](Self::advance_actuator) by a rule of this order, and with so many outputs and inputs, where
    /// the compiler knows them: all are as fast as if written apart.
    #[inline(always)]
    fn actuate<const ORDER: u32>(
        &mut self,
        step: MacroStep,
        part: Range<usize>,
        ports: (usize, usize),
    ) -> Result<(), Failure> {
        let count = self.setup.actuator_steps(step);
        let (actuator, scheme) = (&mut *self.sides.actuator, &mut *self.scheme);
        let mut takes_polynomial = self.state.takes_polynomial.actuator;
        let keeps_history = self.state.keeps_history;
        let PairState { own, u, history, work_sent, end, rates, inside, late, trials, model, .. } = &mut *self.state;
        let covered = (step, self.setup.own_mechanics_steps(step));
        let mut trials =
            trials.as_mut().map(|room| TrialSteps::new(&mut *self.sides.mechanics, covered, room, self.setup.trials));
        let (own, u) = (&mut own.actuator[..ports.0], &mut u.actuator[..ports.1]);
        let mut rates = if ORDER == 2 { rates.as_mut() } else { None };
        if part.start == 0 {
            history.clear();
        }
        let is_last = part.end == count;
        for j in part {
            self.stop.check()?;
            let at = MicroStep::new(step, j, count);
            actuator.outputs(u, own)?;
            match &mut rates {
                None => work_sent.add_half_step(at.length, own, u),
                Some(rates) => {
                    if !actuator.capabilities().output_rates(at.start, u, rates)? {
                        return Err(Cause::NotOffered { what: NO_OUTPUT_RATES.into() }.into());
                    }
                    rates.advance(0.5 * at.length, own);
                    scheme.receive_feedthrough(&rates.feedthrough)?;
                }
            }
            if let Some(trials) = &mut trials {
                scheme.ask(at, own, trials)?;
            }
            scheme.input(Side::Actuator, at, own, u)?;
            match &mut rates {
                None => work_sent.add_half_step(at.length, own, u),
                Some(rates) => {
                    actuator.outputs(u, own)?;
                    rates.advance(0.5 * at.length, own);
                    work_sent.add_step(at.length, own, u);
                }
            }
            if let Some(log) = inside {
                if ORDER == 2 { record_midpoint(log, at, own, u) } else { record_micro_step(log, at, own, u) }
            }
            if takes_polynomial {
                takes_polynomial = send_polynomial(scheme, Side::Actuator, at, actuator);
            }
            if keeps_history || ORDER == 2 {
                history.push(own);
            }
            actuator.step(at.start, u, at.length)?;
            if ORDER == 2 {
                scheme.input_at_end(Side::Actuator, u);
            }
        }
        if !is_last {
            return Ok(());
        }
        if self.setup.force_return == ForceReturn::End {
            actuator.outputs(u, end)?;
        }
        if let Some(model) = model {
            model.follow(step, history, &u[u.len() / 2..])?;
        }
        match late {
            Some(late) => late.keep_history(step.index, history, actuator, u),
            None => Ok(()),
        }
    }

    pub(crate) fn advance_mechanics(&mut self, step: MacroStep) -> Result<(), Failure> {
        let count = self.setup.own_mechanics_steps(step);
        self.state.received.fill(0.0);
        let in_pieces = self.setup.force_return == ForceReturn::Pieces;
        for i in 0..count {
            self.stop.check()?;
            let at = MicroStep::new(step, i, count);
            self.return_force(step, at)?;
            let mechanics = &mut *self.sides.mechanics;
            let PairState { u, history, received, model, .. } = &mut *self.state;
            let u = &mut u.mechanics[..];
            if in_pieces {
                step_in_pieces(mechanics, history.profile(i, count, u), at.length)?;
            } else {
                mechanics.step(at.start, u, at.length)?;
            }
            if let Some(SentModel { model, audit: Some(audit), .. }) = model.as_deref_mut() {
                let contacts = mechanics.capabilities().contact_mechanics();
                audit.add_step(model, at, u, contacts.and_then(|contacts| contacts.contact_impulses()));
            }
            for (received, u) in received.iter_mut().zip(&*u) {
                *received += u / count as f64;
            }
        }
        Ok(())
    }
}

impl CoupledPair<'_> {
    /// Writes what the mechanics receives over a part of `step` as its input.
    #[inline(always)]
    pub(crate) fn return_force(&mut self, step: MacroStep, at: MicroStep) -> Result<(), Failure> {
        let PairState { own, u, history, end, late, takes_polynomial, .. } = &mut *self.state;
        let (own, u, mechanics) = (&mut own.mechanics[..], &mut u.mechanics[..], &mut *self.sides.mechanics);
        match self.setup.force_return {
            ForceReturn::Held => {
                mechanics.outputs(u, own)?;
                self.scheme.input(Side::Mechanics, at, own, u)?;
                if takes_polynomial.mechanics {
                    send_polynomial(&*self.scheme, Side::Mechanics, at, mechanics);
                }
            }
            ForceReturn::End => u.copy_from_slice(end),
            ForceReturn::Mean => history.mean_over(0, 1, u),
            ForceReturn::Profile | ForceReturn::Pieces => history.mean_over(at.index, at.count, u),
        }
        if let (Some(late), false) = (late, self.setup.force_return == ForceReturn::Held) {
            late.deliver_force(step, at.index, at.count, u);
        }
        Ok(())
    }
}

/// Lets the mechanics take a step of `h` (s) in pieces, each under its own mean of the forces.
#[cold]
fn step_in_pieces(mechanics: &mut dyn Subsystem, profile: ForceProfile<'_>, h: f64) -> Result<(), Failure> {
    match mechanics.capabilities().contact_mechanics().filter(|mechanics| mechanics.is_of_second_order()) {
        Some(mechanics) => mechanics.step_under(profile, h),
        None => Err(Cause::NotOffered { what: NO_PIECES.into() }.into()),
    }
}

/// Hands the polynomials of the inputs within a micro step to a subsystem that integrates it; says whether there is
/// one. Inputs that are held in the first micro step of a macro step are held in all of it.
fn send_polynomial(scheme: &dyn CouplingScheme, to: Side, at: MicroStep, subsystem: &mut dyn Subsystem) -> bool {
    subsystem
        .capabilities()
        .input_polynomials()
        .is_some_and(|inputs| inputs.give(|polynomials| scheme.input_polynomials(to, at, polynomials)))
}
