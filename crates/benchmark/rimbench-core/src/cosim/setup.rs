//! Everything that determines a run besides the subsystems and the scheme.

use super::communication_grid::{CommunicationGrid, MacroStep, division};
use super::delivery::Delivery;
use super::force_return::{ForceReturn, Sequence};
use super::integrators::ActuatorIntegrator;
use super::mass_learner::MassLearning;
use super::mechanics_steps::MechanicsSteps;
use super::side::PerSide;
use super::step_rule::StepRule;
use super::trials::TrialSettings;
use crate::interface_model::Belief;
use std::ops::{Deref, DerefMut};

/// How both sides step between communication points, and what they exchange there.
#[derive(Debug, Clone, PartialEq)]
pub struct Exchange {
    /// Longest micro step of the actuator side, s; the one used divides the macro step.
    pub micro_step: f64,
    /// The mechanics' own steps per macro step.
    pub mechanics_steps: MechanicsSteps,
    /// How the actuator steps; the subsystem must have been told as well (see
    /// [`Capabilities::use_second_order`](super::Capabilities::use_second_order)).
    pub actuator_integrator: ActuatorIntegrator,
    /// The order of the sides.
    pub sequence: Sequence,
    /// The force that the mechanics receives.
    pub force_return: ForceReturn,
    /// How samples arrive, if not all of them in time; equal macro steps only.
    pub delivery: Option<Delivery>,
    /// What the scheme believes of the mechanics, if its interface model is wrong.
    pub belief: Option<Belief>,
    /// How the actuator learns the mass that its interface model has wrong, if it does; forces in time only.
    pub mass_learning: Option<MassLearning>,
    /// How a scheme that tries steps of the mechanics uses them.
    pub trials: TrialSettings,
}

impl Exchange {
    /// Exchanges in time: one step of the mechanics per macro step, micro steps of the actuator up to `micro_step` (s)
    /// by its own rule.
    pub fn new(micro_step: f64, sequence: Sequence, force_return: ForceReturn) -> Self {
        Exchange {
            micro_step,
            mechanics_steps: MechanicsSteps::ONE,
            actuator_integrator: ActuatorIntegrator::default(),
            sequence,
            force_return,
            delivery: None,
            belief: None,
            mass_learning: None,
            trials: TrialSettings::default(),
        }
    }
}

impl Deref for Setup {
    type Target = Exchange;

    fn deref(&self) -> &Exchange {
        &self.exchange
    }
}

impl DerefMut for Setup {
    fn deref_mut(&mut self) -> &mut Exchange {
        &mut self.exchange
    }
}

/// Everything that determines a run besides the subsystems and the scheme.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// The communication points.
    pub grid: CommunicationGrid,
    /// How far the error that a run finds of itself may go, if the length of the macro steps is to follow it. The first
    /// macro step of `grid` is then the start, its `H` the longest.
    pub step_rule: Option<StepRule>,
    /// How both sides step and exchange.
    pub exchange: Exchange,
    /// Beyond these the run counts as diverged.
    pub bounds: Bounds,
}

/// Macro steps of a controlled run for which room is made at most: 2.4 MB of what is noted of each.
const MOST_EXPECTED: usize = 100_000;

/// Largest admissible magnitude of each output, by side; `+inf` where there is none. An empty list bounds nothing.
pub type Bounds = PerSide<Vec<f64>>;

impl Setup {
    /// Sets up equal macro steps without bounds: one step of the mechanics in each, micro steps of the actuator up to
    /// `micro_step` (s) by its own rule.
    pub fn new(grid: CommunicationGrid, micro_step: f64, sequence: Sequence, force_return: ForceReturn) -> Self {
        Setup {
            grid,
            step_rule: None,
            exchange: Exchange::new(micro_step, sequence, force_return),
            bounds: Bounds::default(),
        }
    }

    /// Returns the number of macro steps; where a rule sets their length, the most that there can be, as far as room is
    /// made for them beforehand.
    pub fn expected_macro_steps(&self) -> usize {
        let most = self.step_rule.map(|rule| division(self.grid.duration(), rule.shortest).min(MOST_EXPECTED));
        most.unwrap_or(0).max(self.grid.macro_steps())
    }

    /// Counts the micro steps of the actuator side in a macro step.
    pub fn actuator_steps(&self, step: MacroStep) -> usize {
        division(step.length, self.micro_step)
    }

    /// Counts the mechanics' own steps in a macro step.
    pub fn own_mechanics_steps(&self, step: MacroStep) -> usize {
        self.mechanics_steps.within(step.length, self.micro_step)
    }

    /// Returns the mechanics' own step in a macro step, s.
    pub fn mechanics_step(&self, step: MacroStep) -> f64 {
        step.length / self.own_mechanics_steps(step) as f64
    }

    /// Returns the actuator's own step in a macro step, s.
    pub fn actuator_micro_step(&self, step: MacroStep) -> f64 {
        step.length / self.actuator_steps(step) as f64
    }
}
