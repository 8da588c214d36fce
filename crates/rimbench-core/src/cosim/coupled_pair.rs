//! Both sides and what is between them, and how they exchange.

mod advance;

use super::communication_grid::{MacroStep, division};
use super::coupling_scheme::{CouplingScheme, Sample};
use super::force_return::Transmission;
use super::held::Held;
use super::interface_work::{InterfaceWork, WorkMeter};
use super::iteration::Coupling;
use super::macro_loop::{CommunicationPoint, Setup};
use super::outcome::Outcome;
use super::output_rates::OutputRates;
use super::report::CosimCounters;
use super::subsystem::{Ports, Side, Subsystem};
use super::work::Work;
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;

/// A macro step and the time at which it ends, to the bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interval {
    pub(super) step: MacroStep,
    pub(super) end: f64,
}

/// The whole state of a run between two calls of its loop.
pub(super) struct CoupledPair<'a> {
    pub(super) setup: &'a Setup,
    pub(super) mechanics: Held<'a, dyn Subsystem + 'a>,
    pub(super) actuator: Held<'a, dyn Subsystem + 'a>,
    pub(super) scheme: Held<'a, dyn CouplingScheme + 'a>,
    coupling: Coupling,
    model: Option<ReducedInterfaceModel>,
    rates: Option<OutputRates>,
    mechanics_feedthrough: bool,
    pub(super) y_mechanics: Vec<f64>,
    pub(super) y_actuator: Vec<f64>,
    /// Largest magnitude of each output so far, where somebody has noted it.
    pub(super) size_mechanics: Vec<f64>,
    pub(super) size_actuator: Vec<f64>,
    u_mechanics: Vec<f64>,
    u_actuator: Vec<f64>,
    own: Vec<f64>,
    received: Vec<f64>,
    transmission: Transmission,
    work_sent: WorkMeter,
    pub(super) time: f64,
    pub(super) counters: CosimCounters,
    /// Work on copies that were thrown away.
    discarded: Work,
    pub(super) diverged: Option<Outcome>,
}

/// Magnitude below which each output counts as zero.
fn least_sizes(ports: &Ports) -> Vec<f64> {
    ports.outputs.iter().map(|port| port.quantity.negligible()).collect()
}

impl<'a> CoupledPair<'a> {
    pub(super) fn new(
        setup: &'a Setup,
        mechanics: &'a mut dyn Subsystem,
        actuator: &'a mut dyn Subsystem,
        scheme: &'a mut dyn CouplingScheme,
    ) -> Self {
        let (to_actuator, to_mechanics) = (mechanics.ports().outputs.len(), actuator.ports().outputs.len());
        CoupledPair {
            coupling: scheme.coupling(),
            model: if scheme.wants_interface_model() { mechanics.empty_interface_model() } else { None },
            rates: scheme.wants_output_rates().then(|| OutputRates::zeros(to_mechanics, to_actuator)),
            mechanics_feedthrough: mechanics.ports().direct_feedthrough,
            y_mechanics: vec![0.0; to_actuator],
            y_actuator: vec![0.0; to_mechanics],
            size_mechanics: least_sizes(mechanics.ports()),
            size_actuator: least_sizes(actuator.ports()),
            u_mechanics: vec![0.0; to_mechanics],
            u_actuator: vec![0.0; to_actuator],
            own: vec![0.0; to_actuator.max(to_mechanics)],
            received: vec![0.0; to_mechanics],
            transmission: Transmission::new(to_mechanics, division(setup.grid.macro_step(), setup.micro_step)),
            work_sent: WorkMeter::new(actuator.ports()),
            time: 0.0,
            counters: CosimCounters::default(),
            discarded: Work::default(),
            diverged: None,
            setup,
            mechanics: Held::Given(mechanics),
            actuator: Held::Given(actuator),
            scheme: Held::Given(scheme),
        }
    }

    /// A copy in the present state, for steps that may be taken back.
    ///
    /// # Errors
    /// [`Failure::NotCopied`] if a subsystem or the scheme has no copy to give.
    pub(super) fn try_clone(&self) -> Result<Self, Failure> {
        Ok(CoupledPair {
            setup: self.setup,
            mechanics: Held::Copy(self.mechanics.try_clone().ok_or(Failure::NotCopied)?),
            actuator: Held::Copy(self.actuator.try_clone().ok_or(Failure::NotCopied)?),
            scheme: Held::Copy(self.scheme.try_clone().ok_or(Failure::NotCopied)?),
            coupling: self.coupling,
            model: self.model.clone(),
            rates: self.rates.clone(),
            mechanics_feedthrough: self.mechanics_feedthrough,
            y_mechanics: self.y_mechanics.clone(),
            y_actuator: self.y_actuator.clone(),
            size_mechanics: self.size_mechanics.clone(),
            size_actuator: self.size_actuator.clone(),
            u_mechanics: self.u_mechanics.clone(),
            u_actuator: self.u_actuator.clone(),
            own: self.own.clone(),
            received: self.received.clone(),
            transmission: self.transmission.clone(),
            work_sent: self.work_sent.clone(),
            time: self.time,
            counters: self.counters,
            discarded: self.discarded,
            diverged: self.diverged.clone(),
        })
    }

    /// All work so far, that on copies thrown away included.
    pub(super) fn work(&self) -> Work {
        let mut work = Work {
            cosim: self.counters,
            mechanics: self.mechanics.counters(),
            actuator: self.actuator.counters(),
            scheme: self.scheme.counters(),
        };
        work.add(&self.discarded);
        work
    }

    /// Books work that led nowhere.
    pub(super) fn book_discarded(&mut self, work: Work) {
        self.discarded.add(&work.discarded());
    }

    /// A communication point: outputs of both sides, then each sample to the scheme.
    pub(super) fn exchange(&mut self, step: MacroStep) -> Result<(), Failure> {
        self.time = step.start;
        self.evaluate_outputs(self.setup.stale_feedthrough && step.index > 0);
        if step.index == 0 {
            self.received.copy_from_slice(&self.y_actuator);
        }
        self.watch_bounds()?;

        let mechanics_step = self.mechanics_step(step);
        if let Some(model) = &mut self.model {
            self.mechanics.interface_model(mechanics_step, model)?;
        }
        let actuator_micro_step = self.actuator_micro_step(step);
        let (actuator, time, u) = (&self.actuator, self.time, &self.u_actuator);
        let rates = self.rates.as_mut().and_then(|rates| actuator.output_rates(time, u, rates).then_some(&*rates));
        let sample = Sample {
            time: self.time,
            y: &self.y_mechanics,
            model: self.model.as_ref(),
            rates: None,
            step,
            actuator_micro_step,
        };
        self.scheme.receive(Side::Mechanics, &sample)?;
        self.scheme.receive(Side::Actuator, &Sample { y: &self.y_actuator, model: None, rates, ..sample })?;
        self.counters.exchanges += 1;
        Ok(())
    }

    /// Shows the communication point at which `step` starts.
    pub(super) fn show(&mut self, step: MacroStep, observe: &mut dyn FnMut(CommunicationPoint<'_>)) {
        let mechanics_step = self.mechanics_step(step);
        observe(CommunicationPoint {
            time: self.time,
            y_mechanics: &self.y_mechanics,
            y_actuator: &self.y_actuator,
            received: &self.received,
            diagnostics: self.scheme.diagnostics(),
            mechanics_step,
            mechanics: &mut *self.mechanics,
            actuator: &mut *self.actuator,
        });
    }

    /// Outputs of both sides. The side without direct feedthrough speaks first, so that the other can answer with fresh
    /// input, unless its input is to be the last one it had.
    pub(super) fn evaluate_outputs(&mut self, stale: bool) {
        if self.mechanics_feedthrough {
            self.actuator.outputs(&self.u_actuator, &mut self.y_actuator);
            if !stale {
                self.u_mechanics.copy_from_slice(&self.y_actuator);
            }
            self.mechanics.outputs(&self.u_mechanics, &mut self.y_mechanics);
        } else {
            self.mechanics.outputs(&self.u_mechanics, &mut self.y_mechanics);
            if !stale {
                self.u_actuator.copy_from_slice(&self.y_mechanics);
            }
            self.actuator.outputs(&self.u_actuator, &mut self.y_actuator);
        }
        self.u_mechanics.copy_from_slice(&self.y_actuator);
        self.u_actuator.copy_from_slice(&self.y_mechanics);
    }

    /// The outputs of one side at the end of the macro step reach the scheme before the other side steps.
    pub(super) fn send_ahead(&mut self, from: Side, interval: Interval) -> Result<(), Failure> {
        let step = interval.step;
        let y = match from {
            Side::Mechanics => &self.y_mechanics,
            Side::Actuator => &self.y_actuator,
        };
        let actuator_micro_step = self.actuator_micro_step(step);
        self.counters.exchanges += 1;
        let sample = Sample { time: interval.end, y, model: None, rates: None, step, actuator_micro_step };
        self.scheme.receive(from, &sample)
    }

    pub(super) fn interface_work(&self) -> InterfaceWork {
        InterfaceWork { sent_j: self.work_sent.sent(), received_j: self.mechanics.interface_work() }
    }

    /// Notes the first coupling variable beyond its bound; ends the run at one that is not finite.
    fn watch_bounds(&mut self) -> Result<(), Failure> {
        let bounds = &self.setup.bounds;
        let sides = [
            (&self.y_mechanics, self.mechanics.ports(), &bounds.mechanics),
            (&self.y_actuator, self.actuator.ports(), &bounds.actuator),
        ];
        for (y, ports, limits) in sides {
            for (index, &value) in y.iter().enumerate() {
                let quantity = ports.outputs[index].name;
                if !value.is_finite() {
                    return Err(Failure::NonFinite { quantity });
                }
                let beyond = limits.get(index).is_some_and(|&limit| value.abs() > limit);
                if beyond && self.diverged.is_none() {
                    self.diverged = Some(Outcome::Diverged { at_s: self.time, quantity, value });
                }
            }
        }
        Ok(())
    }
}
