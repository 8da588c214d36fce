//! The state of the macro loop.

use super::communication_grid::division;
use super::exchange_data::ExchangeData;
use super::force_return::ForceReturn;
use super::integrators::ActuatorIntegrator;
use super::late_samples::LateSamples;
use super::outcome::Outcome;
use super::output_history::OutputHistory;
use super::output_rates::OutputRates;
use super::sent_model::SentModel;
use super::setup::Setup;
use super::side::{PerSide, Side};
use super::subsystem::Sides;
use super::trajectory::Trajectory;
use super::trial_steps::TrialRoom;
use super::work::CosimCounters;
use super::work_meter::WorkMeter;

/// Inputs, outputs, and what is counted along the way. A copy of it with copies of sides and scheme is a copy of the
/// run.
#[derive(Debug, Clone)]
pub(crate) struct PairState {
    /// The side that does not depend on the other at the instant itself.
    pub(crate) without_feedthrough: Side,
    /// Whether a side integrates polynomials and is told the polynomials of its inputs.
    pub(crate) takes_polynomial: PerSide<bool>,
    /// The mechanics' interface model, where the scheme takes one.
    pub(crate) model: Option<Box<SentModel>>,
    /// What else is exchanged.
    pub(crate) exchange: ExchangeData,
    pub(crate) y: PerSide<Vec<f64>>,
    pub(crate) u: PerSide<Vec<f64>>,
    /// How the actuator's outputs move, where its micro steps are of the second order.
    pub(crate) rates: Option<OutputRates>,
    /// Outputs at the start of a micro step.
    pub(crate) own: PerSide<Vec<f64>>,
    /// The actuator's outputs at the end of the macro step, for the force return `end`.
    pub(crate) end: Vec<f64>,
    pub(crate) received: Vec<f64>,
    /// The actuator's outputs by micro step, where the force return, late samples or other bonds take them.
    pub(crate) history: OutputHistory,
    pub(crate) keeps_history: bool,
    pub(crate) work_sent: WorkMeter,
    pub(crate) time: f64,
    pub(crate) counters: CosimCounters,
    /// Where steps of the mechanics are tried.
    pub(crate) trials: Option<Box<TrialRoom>>,
    pub(crate) diverged: Option<Outcome>,
    /// The micro steps of the actuator, where it is recorded.
    pub(crate) inside: Option<Trajectory>,
    /// Samples on their way, where they may be late.
    pub(crate) late: Option<Box<LateSamples>>,
}

impl PairState {
    pub(crate) fn new(setup: &Setup, sides: Sides<'_>, mut exchange: ExchangeData) -> Self {
        let micro_steps = division(setup.grid.macro_step(), setup.micro_step);
        if let (Some(forces), Some(lines)) = (&mut exchange.line_forces, sides.actuator.capabilities().oil_lines()) {
            forces.reserve(micro_steps);
            lines.lay(micro_steps, forces.smoothing());
        }
        let takes_polynomial = PerSide {
            mechanics: sides.mechanics.capabilities().input_polynomials().is_some(),
            actuator: sides.actuator.capabilities().input_polynomials().is_some(),
        };
        let ports = sides.ports();
        let zeros = |side: Side| vec![0.0; ports[side].outputs.len()];
        let to_mechanics = ports.actuator.outputs.len();
        let midpoint = setup.actuator_integrator == ActuatorIntegrator::Midpoint;
        let late = setup
            .delivery
            .as_ref()
            .map(|delivery| Box::new(LateSamples::new(delivery, setup, ports, exchange.interface_model.as_ref())));
        let averages = matches!(setup.force_return, ForceReturn::Mean | ForceReturn::Profile | ForceReturn::Pieces);
        PairState {
            without_feedthrough: if ports.mechanics.direct_feedthrough { Side::Actuator } else { Side::Mechanics },
            takes_polynomial,
            trials: exchange.trials.then(Box::default),
            model: exchange.interface_model.take().map(|empty| Box::new(SentModel::new(setup, empty))),
            exchange,
            rates: midpoint.then(|| OutputRates::zeros(to_mechanics, ports.actuator.inputs.len())),
            y: PerSide::from_fn(zeros),
            u: PerSide::from_fn(|side| zeros(side.other())),
            own: PerSide::from_fn(zeros),
            end: vec![0.0; to_mechanics],
            received: vec![0.0; to_mechanics],
            history: OutputHistory::new(to_mechanics, micro_steps),
            keeps_history: averages || late.is_some(),
            work_sent: WorkMeter::new(ports.actuator),
            time: 0.0,
            counters: CosimCounters::default(),
            diverged: None,
            inside: None,
            late,
        }
    }
}
