//! The macro loop, written once for every case, scheme and sequence.

use super::communication_grid::{CommunicationGrid, MacroStep, division};
use super::coupling_scheme::{CouplingScheme, Diagnostics, MicroStep, Sample};
use super::energy_account::EnergyAudit;
use super::force_return::{ForceReturn, Sequence, Transmission};
use super::interface_work::{InterfaceWork, WorkMeter};
use super::latency::{Stopwatch, Timing};
use super::outcome::Outcome;
use super::output_rates::OutputRates;
use super::report::{CosimCounters, Report};
use super::subsystem::{Side, Subsystem};
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;

/// Everything that determines a run besides the subsystems and the scheme.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// The communication points.
    pub grid: CommunicationGrid,
    /// Longest micro step of the actuator side, s; the one used divides the macro step.
    pub micro_step: f64,
    /// The mechanics' own steps per macro step n_m; 0 stands for as many as the actuator side takes.
    pub mechanics_steps: usize,
    /// Who goes first.
    pub sequence: Sequence,
    /// What the mechanics receives.
    pub force_return: ForceReturn,
    /// Outputs with direct feedthrough are evaluated with the input used last, not with the fresh one.
    pub stale_feedthrough: bool,
    /// Beyond these the run counts as diverged.
    pub bounds: Bounds,
    /// What to do with the clock.
    pub timing: Timing,
}

/// Largest admissible magnitude of each coupling variable, by side; `+inf` where there is none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bounds {
    /// For the outputs of the mechanics.
    pub mechanics: Vec<f64>,
    /// For the outputs of the actuator.
    pub actuator: Vec<f64>,
}

/// What an observer sees at a communication point.
pub struct CommunicationPoint<'a> {
    /// `t_k`, s.
    pub time: f64,
    /// Outputs of the mechanics.
    pub y_mechanics: &'a [f64],
    /// Outputs of the actuator: its own, at this instant.
    pub y_actuator: &'a [f64],
    /// What the mechanics received over the macro step that ends here (at `t_0`: what it would be held at).
    pub received: &'a [f64],
    /// The scheme's own picture.
    pub diagnostics: Diagnostics,
    /// The mechanics' own step in the macro step that starts here, s.
    pub mechanics_step: f64,
    /// The mechanics.
    pub mechanics: &'a mut dyn Subsystem,
    /// The actuator.
    pub actuator: &'a mut dyn Subsystem,
}

/// Runs two subsystems coupled by a scheme, and calls `observe` at each communication point.
///
/// The ports must fit (see [`check_coupling`](super::check_coupling)) and the force return must suit the sequence (see
/// [`ForceReturn::check`]). Nothing is allocated once the first macro step has begun.
pub fn cosimulate(
    setup: &Setup,
    mechanics: &mut dyn Subsystem,
    actuator: &mut dyn Subsystem,
    scheme: &mut dyn CouplingScheme,
    observe: &mut dyn FnMut(CommunicationPoint<'_>),
) -> Report {
    let mut run = Run::new(setup, mechanics, actuator, scheme);
    let result = run.macro_steps(observe);
    let outcome = match (run.diverged.take(), result) {
        (Some(diverged), _) => diverged,
        (None, Err(failure)) => Outcome::from_failure(failure, run.time),
        (None, Ok(End::Overdue)) => Outcome::Timeout { at_s: run.time },
        (None, Ok(End::Reached)) => Outcome::Completed,
    };
    let work = run.interface_work();
    let (mechanics, actuator) = (run.mechanics.energy_account(), run.actuator.energy_account());
    Report {
        outcome,
        ended_at_s: run.time,
        counters: run.counters,
        work,
        audit: EnergyAudit { mechanics, actuator, work },
        interface_residual: run.interface_residual,
        latencies_s: run.stopwatch.latencies,
    }
}

/// How the loop ended, where nothing failed.
enum End {
    Reached,
    Overdue,
}

struct Run<'a> {
    setup: &'a Setup,
    mechanics: &'a mut dyn Subsystem,
    actuator: &'a mut dyn Subsystem,
    scheme: &'a mut dyn CouplingScheme,
    model: Option<ReducedInterfaceModel>,
    rates: Option<OutputRates>,
    mechanics_feedthrough: bool,
    y_mechanics: Vec<f64>,
    y_actuator: Vec<f64>,
    u_mechanics: Vec<f64>,
    u_actuator: Vec<f64>,
    own: Vec<f64>,
    received: Vec<f64>,
    transmission: Transmission,
    work_sent: WorkMeter,
    interface_residual: Vec<[f64; 2]>,
    stopwatch: Stopwatch,
    time: f64,
    counters: CosimCounters,
    diverged: Option<Outcome>,
}

impl<'a> Run<'a> {
    fn new(
        setup: &'a Setup,
        mechanics: &'a mut dyn Subsystem,
        actuator: &'a mut dyn Subsystem,
        scheme: &'a mut dyn CouplingScheme,
    ) -> Self {
        let (to_actuator, to_mechanics) = (mechanics.ports().outputs.len(), actuator.ports().outputs.len());
        Run {
            model: if scheme.wants_interface_model() { mechanics.empty_interface_model() } else { None },
            rates: scheme.wants_output_rates().then(|| OutputRates::zeros(to_mechanics, to_actuator)),
            mechanics_feedthrough: mechanics.ports().direct_feedthrough,
            y_mechanics: vec![0.0; to_actuator],
            y_actuator: vec![0.0; to_mechanics],
            u_mechanics: vec![0.0; to_mechanics],
            u_actuator: vec![0.0; to_actuator],
            own: vec![0.0; to_actuator.max(to_mechanics)],
            received: vec![0.0; to_mechanics],
            transmission: Transmission::new(to_mechanics, division(setup.grid.macro_step(), setup.micro_step)),
            work_sent: WorkMeter::new(actuator.ports()),
            interface_residual: Vec::with_capacity(setup.grid.macro_steps() + 1),
            stopwatch: Stopwatch::new(setup.timing, setup.grid.macro_steps()),
            time: 0.0,
            counters: CosimCounters::default(),
            diverged: None,
            setup,
            mechanics,
            actuator,
            scheme,
        }
    }

    /// The algorithm: exchange, then let both sides cover the macro step.
    fn macro_steps(&mut self, observe: &mut dyn FnMut(CommunicationPoint<'_>)) -> Result<End, Failure> {
        let grid = self.setup.grid;
        let mut last = grid.step(0);
        for k in 0..grid.macro_steps() {
            if self.stopwatch.expired() {
                return Ok(End::Overdue);
            }
            let step = grid.step(k);
            self.stopwatch.begin();
            self.exchange(step, observe)?;
            match self.setup.sequence {
                Sequence::Jacobi | Sequence::GaussSeidel { first: Side::Actuator } => {
                    self.advance_actuator(step)?;
                    self.advance_mechanics(step)?;
                }
                Sequence::GaussSeidel { first: Side::Mechanics } => {
                    self.advance_mechanics(step)?;
                    self.send_ahead(step)?;
                    self.advance_actuator(step)?;
                }
            }
            self.stopwatch.end();
            self.counters.macro_steps += 1;
            last = step;
        }
        self.exchange(MacroStep { index: grid.macro_steps(), start: grid.duration(), ..last }, observe)?;
        Ok(End::Reached)
    }

    /// A communication point: outputs of both sides, then each sample to the scheme.
    fn exchange(&mut self, step: MacroStep, observe: &mut dyn FnMut(CommunicationPoint<'_>)) -> Result<(), Failure> {
        self.time = step.start;
        // The side without direct feedthrough speaks first, so that the other can answer with fresh input.
        if self.mechanics_feedthrough {
            self.actuator.outputs(&self.u_actuator, &mut self.y_actuator);
            if !self.setup.stale_feedthrough || step.index == 0 {
                self.u_mechanics.copy_from_slice(&self.y_actuator);
            }
            self.mechanics.outputs(&self.u_mechanics, &mut self.y_mechanics);
        } else {
            self.mechanics.outputs(&self.u_mechanics, &mut self.y_mechanics);
            if !self.setup.stale_feedthrough || step.index == 0 {
                self.u_actuator.copy_from_slice(&self.y_mechanics);
            }
            self.actuator.outputs(&self.u_actuator, &mut self.y_actuator);
        }
        self.u_mechanics.copy_from_slice(&self.y_actuator);
        self.u_actuator.copy_from_slice(&self.y_mechanics);
        if step.index == 0 {
            self.received.copy_from_slice(&self.y_actuator);
        }
        self.watch_bounds()?;

        let mechanics_step = step.length / self.mechanics_steps(step) as f64;
        if let Some(model) = &mut self.model {
            self.mechanics.interface_model(mechanics_step, model)?;
        }
        let actuator_micro_step = step.length / division(step.length, self.setup.micro_step) as f64;
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
        if let Some(residual) = self.interface_work().residual_j() {
            self.interface_residual.push([self.time, residual]);
        }
        self.stopwatch.pause();
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
        self.stopwatch.resume();
        Ok(())
    }

    fn advance_actuator(&mut self, step: MacroStep) -> Result<(), Failure> {
        let count = division(step.length, self.setup.micro_step);
        let own = &mut self.own[..self.y_actuator.len()];
        let averaged = matches!(self.setup.force_return, ForceReturn::Mean | ForceReturn::Profile);
        self.transmission.clear();
        for j in 0..count {
            let at = MicroStep::new(step, j, count);
            self.actuator.outputs(&self.u_actuator, own);
            self.work_sent.add_half_step(at.length, own, &self.u_actuator);
            self.scheme.input(Side::Actuator, at, own, &mut self.u_actuator)?;
            self.work_sent.add_half_step(at.length, own, &self.u_actuator);
            self.actuator.step(at.start, &self.u_actuator, at.length)?;
            if averaged {
                self.transmission.push(own);
            }
        }
        // The value at the end of the step, for the force return `end`.
        self.actuator.outputs(&self.u_actuator, own);
        Ok(())
    }

    fn advance_mechanics(&mut self, step: MacroStep) -> Result<(), Failure> {
        let count = self.mechanics_steps(step);
        self.received.fill(0.0);
        for i in 0..count {
            let at = MicroStep::new(step, i, count);
            match self.setup.force_return {
                ForceReturn::Held => {
                    let own = &mut self.own[..self.y_mechanics.len()];
                    self.mechanics.outputs(&self.u_mechanics, own);
                    self.scheme.input(Side::Mechanics, at, own, &mut self.u_mechanics)?;
                }
                ForceReturn::End => self.u_mechanics.copy_from_slice(&self.own[..self.y_actuator.len()]),
                ForceReturn::Mean => self.transmission.mean_over(0, 1, &mut self.u_mechanics),
                ForceReturn::Profile => self.transmission.mean_over(i, count, &mut self.u_mechanics),
            }
            self.mechanics.step(at.start, &self.u_mechanics, at.length)?;
            for (received, u) in self.received.iter_mut().zip(&self.u_mechanics) {
                *received += u / count as f64;
            }
        }
        Ok(())
    }

    /// Gauss–Seidel with the mechanics first: its outputs at `t_{k+1}` reach the scheme before the actuator steps.
    fn send_ahead(&mut self, step: MacroStep) -> Result<(), Failure> {
        self.mechanics.outputs(&self.u_mechanics, &mut self.y_mechanics);
        let actuator_micro_step = step.length / division(step.length, self.setup.micro_step) as f64;
        let time = self.setup.grid.time(step.index + 1);
        self.counters.exchanges += 1;
        let sample = Sample { time, y: &self.y_mechanics, model: None, rates: None, step, actuator_micro_step };
        self.scheme.receive(Side::Mechanics, &sample)
    }

    fn interface_work(&self) -> InterfaceWork {
        InterfaceWork { sent_j: self.work_sent.sent(), received_j: self.mechanics.interface_work() }
    }

    fn mechanics_steps(&self, step: MacroStep) -> usize {
        match self.setup.mechanics_steps {
            0 => division(step.length, self.setup.micro_step),
            count => count,
        }
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
