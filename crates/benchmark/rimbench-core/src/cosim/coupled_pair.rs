//! Both sides and what is between them, and how they exchange.

mod advance;
mod late;

use super::communication_grid::MacroStep;
use super::communication_point::CommunicationPoint;
use super::coupling_scheme::{CouplingScheme, Sample};
use super::exchange_data::{NO_FORECAST, NO_OIL_LINES, NO_OUTPUT_RATES};
use super::interface_work::InterfaceWork;
use super::model_defect::{DefectMeter, ModelDefect};
use super::outcome::Outcome;
use super::pair_state::PairState;
use super::run_control::StopFlag;
use super::setup::{Bounds, Setup};
use super::side::{PerSide, Side};
use super::step_size_control::{BondResiduals, ErrorEstimate, ErrorMeter, MacroInterval};
use super::subsystem::Sides;
use super::work::Work;
use crate::error::{Cause, Failure};

/// A run between two calls of its loop.
pub(crate) struct CoupledPair<'a> {
    pub(crate) setup: &'a Setup,
    pub(crate) sides: Sides<'a>,
    pub(crate) scheme: &'a mut dyn CouplingScheme,
    pub(crate) state: &'a mut PairState,
    pub(crate) stop: StopFlag<'a>,
}

/// Notes the first coupling variable beyond its bound; ends the run at one that is not finite.
pub(crate) fn watch_bounds(
    sides: &Sides<'_>,
    y: &PerSide<Vec<f64>>,
    (bounds, at_s): (&Bounds, f64),
    diverged: &mut Option<Outcome>,
) -> Result<(), Failure> {
    for side in Side::BOTH {
        for (index, &value) in y[side].iter().enumerate() {
            let quantity = || sides[side].ports().outputs[index].name.clone();
            if !value.is_finite() {
                return Err(Cause::NonFinite { quantity: quantity() }.into());
            }
            let beyond = bounds[side].get(index).is_some_and(|&limit| value.abs() > limit);
            if beyond && diverged.is_none() {
                *diverged = Some(Outcome::Diverged { at_s, quantity: quantity(), value });
            }
        }
    }
    Ok(())
}

impl CoupledPair<'_> {
    /// Lends the pair.
    pub(crate) fn lend(&mut self) -> CoupledPair<'_> {
        CoupledPair {
            setup: self.setup,
            sides: self.sides.lend(),
            scheme: &mut *self.scheme,
            state: &mut *self.state,
            stop: self.stop,
        }
    }

    /// Exchanges at a communication point: outputs of both sides, then each sample to the scheme.
    pub(crate) fn exchange(&mut self, step: MacroStep) -> Result<(), Failure> {
        self.state.time = step.start;
        self.evaluate_outputs()?;
        if step.index == 0 {
            self.state.received.copy_from_slice(&self.state.y.actuator);
        }
        let PairState { y, time, diverged, .. } = &mut *self.state;
        watch_bounds(&self.sides, y, (&self.setup.bounds, *time), diverged)?;
        if self.state.late.is_some() {
            return self.exchange_late(step);
        }
        self.fill_attachments(step)?;
        let PairState { y, exchange, model, .. } = &mut *self.state;
        let sample = Sample {
            model: model.as_mut().map(|model| model.arrive(step.index)),
            mechanics_steps: self.setup.own_mechanics_steps(step),
            ..Sample::of_outputs(step, &y.mechanics, self.setup.actuator_micro_step(step))
        };
        self.scheme.receive(Side::Mechanics, &sample)?;
        let rates = exchange.output_rates.as_ref();
        let line_forces = exchange.line_forces.as_ref();
        self.scheme.receive(Side::Actuator, &Sample { y: &y.actuator, model: None, rates, line_forces, ..sample })?;
        self.state.counters.exchanges += 1;
        Ok(())
    }

    /// Outputs of both sides. The side without direct feedthrough speaks first, so that the other can answer with fresh
    /// input.
    pub(crate) fn evaluate_outputs(&mut self) -> Result<(), Failure> {
        let first = self.state.without_feedthrough;
        let (u_first, u_second) = self.state.u.split_mut(first);
        let (y_first, y_second) = self.state.y.split_mut(first);
        self.sides[first].outputs(u_first, y_first)?;
        u_second.copy_from_slice(y_first);
        self.sides[first.other()].outputs(u_second, y_second)?;
        u_first.copy_from_slice(y_second);
        Ok(())
    }

    /// Asks the sides for what the scheme needs besides outputs; a side that offers it must have it at every
    /// communication point.
    fn fill_attachments(&mut self, step: MacroStep) -> Result<(), Failure> {
        let PairState { exchange, u, model, .. } = &mut *self.state;
        if let Some(model) = model {
            model.fill(self.setup, step, &mut *self.sides.mechanics)?;
        }
        if let Some(rates) = &mut exchange.output_rates
            && !self.sides.actuator.capabilities().output_rates(step.start, &u.actuator, rates)?
        {
            return Err(Cause::NotOffered { what: NO_OUTPUT_RATES.into() }.into());
        }
        if let Some(forces) = &mut exchange.line_forces {
            let lines = self.sides.actuator.capabilities().oil_lines();
            let lines = lines.ok_or(Cause::NotOffered { what: NO_OIL_LINES.into() })?;
            lines.exchange(step, self.setup.actuator_steps(step), &u.actuator, forces);
        }
        Ok(())
    }

    /// Sends the outputs of one side at the end of the macro step to the scheme before the other side steps.
    pub(crate) fn send_fresh_sample(
        &mut self,
        from: Side,
        MacroInterval { step, end }: MacroInterval,
    ) -> Result<(), Failure> {
        self.state.counters.exchanges += 1;
        if self.state.late.is_some() && from == Side::Mechanics {
            return self.send_fresh_sample_late(MacroInterval { step, end });
        }
        let sample =
            Sample { time: end, ..Sample::of_outputs(step, &self.state.y[from], self.setup.actuator_micro_step(step)) };
        self.scheme.receive(from, &sample)
    }

    /// Shows the communication point at which `step` starts; `effective_mass` is what the scheme says of the macro step
    /// before.
    pub(crate) fn show(
        &mut self,
        step: MacroStep,
        effective_mass: Option<f64>,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) {
        let mechanics_step = self.setup.mechanics_step(step);
        let interface_residual = self.interface_work().residual_j();
        observe(CommunicationPoint {
            time: self.state.time,
            y: self.state.y.as_ref().map(Vec::as_slice),
            received: &self.state.received,
            effective_mass,
            audit: self.state.model.as_ref().and_then(|model| model.audit.as_ref()?.so_far()),
            mechanics_step,
            interface_lambda: None,
            interface_residual,
            inside: self.state.inside.as_mut(),
            sides: self.sides.lend(),
        });
    }

    /// Returns all work of this pair.
    pub(crate) fn work(&mut self) -> Work {
        let scheme = self.scheme.report().counters;
        let mut sides = PerSide::from_fn(|side| self.sides[side].counters());
        if let Some(trials) = &self.state.trials {
            sides.mechanics.add(&trials.work);
        }
        Work { cosim: self.state.counters, sides, scheme }
    }

    pub(crate) fn interface_work(&mut self) -> InterfaceWork {
        let received_j = self.sides.mechanics.capabilities().interface_work();
        InterfaceWork { sent_j: self.state.work_sent.sent(), received_j }
    }

    /// Estimates the error of a macro step at its `end` (s) by a meter.
    #[inline]
    pub(crate) fn estimate(&mut self, meter: &mut ErrorMeter, end: f64) -> Result<ErrorEstimate, Failure> {
        match meter {
            ErrorMeter::Work => Ok(ErrorEstimate::Work),
            ErrorMeter::Powers => self.bond_residuals().map(ErrorEstimate::Powers),
            ErrorMeter::Defect(meter) => self.model_defect(meter, end).map(ErrorEstimate::Defect),
        }
    }

    /// By how much what each side says crosses a row of the interface differs: its outputs at the end of a macro step,
    /// with the inputs that it had.
    fn bond_residuals(&mut self) -> Result<BondResiduals, Failure> {
        let PairState { own, u, work_sent, .. } = &mut *self.state;
        self.sides.actuator.outputs(&u.actuator, &mut own.actuator)?;
        self.sides.mechanics.outputs(&u.mechanics, &mut own.mechanics)?;
        let sent = work_sent.powers(&own.actuator, &u.actuator);
        Ok(BondResiduals::of(
            sent.zip(work_sent.powers(&u.mechanics, &own.mechanics)).map(|(sent, received)| sent - received),
        ))
    }

    /// By how much the motion that the actuator was given by the scheme's model is wrong at the `end` (s) of a macro
    /// step.
    #[cold]
    fn model_defect(&mut self, meter: &mut DefectMeter, end: f64) -> Result<ModelDefect, Failure> {
        let PairState { own, u, y, .. } = &mut *self.state;
        let forecast = self.scheme.forecast().ok_or(Cause::NotOffered { what: NO_FORECAST.into() })?;
        self.sides.mechanics.outputs(&u.mechanics, &mut own.mechanics)?;
        self.sides.actuator.outputs(&u.actuator, &mut own.actuator)?;
        if !self.sides.actuator.capabilities().output_rates(end, &u.actuator, meter.rates())? {
            return Err(Cause::NotOffered { what: NO_OUTPUT_RATES.into() }.into());
        }
        meter.note_forces(&y.actuator);
        meter.note_forces(&own.actuator);
        Ok(meter.measure(forecast, &own.mechanics))
    }
}
