//! The state of the macro loop.

use super::communication_grid::division;
use super::exchange_data::ExchangeData;
use super::integrators::ActuatorIntegrator;
use super::late_samples::LateSamples;
use super::mass_learner::MassLearner;
use super::model_audit::ModelAudit;
use super::model_defect::DefectMeter;
use super::outcome::Outcome;
use super::output_history::OutputHistory;
use super::output_rates::OutputRates;
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
    pub(crate) history: OutputHistory,
    pub(crate) work_sent: WorkMeter,
    /// By how much the scheme's model is wrong, where that sets the macro steps.
    pub(crate) defect: Option<DefectMeter>,
    pub(crate) time: f64,
    pub(crate) counters: CosimCounters,
    /// Where steps of the mechanics are tried.
    pub(crate) trials: Option<Box<TrialRoom>>,
    pub(crate) diverged: Option<Outcome>,
    /// The micro steps of the actuator, where it is recorded.
    pub(crate) inside: Option<Trajectory>,
    /// The account of the scheme's interface model, where it is kept.
    pub(crate) audit: Option<Box<ModelAudit>>,
    /// Samples on their way, where they may be late.
    pub(crate) late: Option<Box<LateSamples>>,
    /// Whether other bonds are told of its forces.
    pub(crate) is_told_of: bool,
    /// Whether the interface model of the next communication point is in the exchange already.
    pub(crate) has_model: bool,
    /// What the actuator learns of the mass, where it does.
    pub(crate) learner: Option<Box<MassLearner>>,
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
        let by_defect = setup.step_rule.is_some_and(|rule| rule.control.by_defect());
        let midpoint = setup.actuator_integrator == ActuatorIntegrator::Midpoint;
        let late = setup
            .delivery
            .as_ref()
            .map(|delivery| Box::new(LateSamples::new(delivery, setup, ports, exchange.interface_model.as_ref())));
        let learner = setup.mass_learning.zip(exchange.interface_model.as_ref());
        let learner = learner.map(|(rule, empty)| Box::new(MassLearner::new(rule, empty)));
        PairState {
            without_feedthrough: if ports.mechanics.direct_feedthrough { Side::Actuator } else { Side::Mechanics },
            takes_polynomial,
            trials: exchange.trials.then(Box::default),
            exchange,
            rates: midpoint.then(|| OutputRates::zeros(to_mechanics, ports.actuator.inputs.len())),
            y: PerSide::from_fn(zeros),
            u: PerSide::from_fn(|side| zeros(side.other())),
            own: PerSide::from_fn(zeros),
            end: vec![0.0; to_mechanics],
            received: vec![0.0; to_mechanics],
            history: OutputHistory::new(to_mechanics, micro_steps),
            work_sent: WorkMeter::new(ports.actuator),
            defect: by_defect.then(|| DefectMeter::new(ports.actuator)),
            time: 0.0,
            counters: CosimCounters::default(),
            diverged: None,
            inside: None,
            audit: None,
            late,
            is_told_of: false,
            has_model: false,
            learner,
        }
    }
}
