//! The approximation of the coupling variables between communication points.

use super::communication_grid::MacroStep;
use super::iteration::Coupling;
use super::output_rates::OutputRates;
use super::subsystem::Side;
use crate::complementarity::SolverCounters;
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;

/// What one side sends at a communication point.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    /// When it was taken, s.
    pub time: f64,
    /// The outputs of the sending side.
    pub y: &'a [f64],
    /// The sender reduced to its interface, if the scheme asked for it and the sender has one.
    pub model: Option<&'a ReducedInterfaceModel>,
    /// How the actuator's outputs move, if the scheme asked for it and this is the actuator's sample.
    pub rates: Option<&'a OutputRates>,
    /// The macro step that starts here.
    pub step: MacroStep,
    /// Micro step of the actuator side in that macro step, s.
    pub actuator_micro_step: f64,
}

/// One micro step inside a macro step. All times come from integers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MicroStep {
    /// j, from 0.
    pub index: usize,
    /// Number of micro steps in the macro step.
    pub count: usize,
    /// `δ`, s.
    pub length: f64,
    /// Absolute time at its start, `t_k + jδ`, s.
    pub start: f64,
    /// Time since the communication point at its start, `jδ`, s.
    pub since_exchange: f64,
}

impl MicroStep {
    /// Micro step `index` of `count` in `step`.
    #[inline]
    pub fn new(step: MacroStep, index: usize, count: usize) -> Self {
        let length = step.length / count as f64;
        let since_exchange = index as f64 * length;
        MicroStep { index, count, length, start: step.start + since_exchange, since_exchange }
    }

    /// Absolute time at its middle, s.
    #[inline]
    pub fn middle(&self) -> f64 {
        self.start + 0.5 * self.length
    }
}

/// What a scheme can say about itself at a communication point.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Diagnostics {
    /// Effective mass that the scheme uses at this communication point, kg; `+inf` for a locked interface.
    pub effective_mass: Option<f64>,
}

/// What is the other side doing meanwhile? Answers with an input for each micro step.
///
/// At each communication point the loop calls [`receive`](Self::receive) for the mechanics, then for the actuator; then
/// [`input`](Self::input) once per micro step of each side. In the Gauss–Seidel sequence that starts with the mechanics,
/// the mechanics' new sample arrives before the actuator's micro steps: what was extrapolation becomes interpolation.
pub trait CouplingScheme: Send {
    /// Takes note of what `from` sends at a communication point.
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure>;

    /// Writes to `u` the input of side `to` for one micro step. `own` is what that side puts out at the start of the
    /// micro step; `u` holds the input used last (at the first micro step, the fresh exchange value).
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure>;

    /// True if the scheme wants [`Sample::model`] from the mechanics.
    fn wants_interface_model(&self) -> bool {
        false
    }

    /// True if the scheme wants [`Sample::rates`] from the actuator.
    fn wants_output_rates(&self) -> bool {
        false
    }

    /// How the sides are coupled over a macro step; anything but `Explicit` is not real-time.
    fn coupling(&self) -> Coupling {
        Coupling::Explicit
    }

    /// A copy in the present state, or nothing if the scheme cannot be copied.
    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        None
    }

    /// Reports on the scheme's own picture of the other side.
    fn diagnostics(&mut self) -> Diagnostics {
        Diagnostics::default()
    }

    /// Energy that the scheme itself has taken out of the system since the start, J, if it does such a thing.
    fn dissipated_j(&self) -> Option<f64> {
        None
    }

    /// Complementarity solves inside the scheme.
    fn counters(&self) -> SolverCounters {
        SolverCounters::default()
    }
}
