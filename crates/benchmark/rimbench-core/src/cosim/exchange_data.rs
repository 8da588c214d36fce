//! Data exchanged at a communication point in addition to outputs, for schemes that need it.

use super::output_rates::OutputRates;
use super::ports::Ports;
use super::subsystem::Sides;
use super::transmission_lines::LineForces;
use crate::error::{Cause, Failure};
use crate::interface_model::ReducedInterfaceModel;

/// Room for data exchanged in addition to outputs, filled at every communication point. Nothing by default.
#[derive(Debug, Clone, Default)]
pub struct ExchangeData {
    /// The mechanics reduced to its interface.
    pub interface_model: Option<ReducedInterfaceModel>,
    /// How the actuator's outputs move.
    pub output_rates: Option<OutputRates>,
    /// The action of lines in the place of the actuator's oil on the mechanics.
    pub line_forces: Option<LineForces>,
    /// Whether steps of the mechanics are tried while the actuator steps.
    pub trials: bool,
}

/// Why a scheme with an interface model cannot be run, or cannot go on.
pub(crate) const NO_INTERFACE_MODEL: &str = "the mechanics offers no reduced interface model";
/// Why one that takes the rates of forces cannot.
pub(crate) const NO_OUTPUT_RATES: &str = "the actuator offers no directional derivatives of its outputs";
/// Why one with lines in the place of oil cannot.
pub(crate) const NO_OIL_LINES: &str = "the actuator has no volumes of oil that lines could replace";
/// Why a force cannot be returned to pieces of a step.
pub(crate) const NO_PIECES: &str = "the mechanics does not split its steps at events";
/// Why macro steps cannot be set by the defect of the scheme's model.
pub(crate) const NO_FORECAST: &str = "the scheme moves no model of the mechanics together with the actuator";

impl ExchangeData {
    /// Makes room for what a scheme needs of two subsystems.
    ///
    /// # Errors
    /// [`Cause::NotOffered`] if the mechanics has no interface model.
    pub fn new(sides: Sides<'_>, interface_model: bool, output_rates: bool) -> Result<ExchangeData, Failure> {
        let Ports { inputs, outputs, .. } = sides.actuator.ports();
        let rates = OutputRates::zeros(outputs.len(), inputs.len());
        let model = match interface_model.then(|| sides.mechanics.capabilities().empty_interface_model()) {
            Some(None) => return Err(Cause::NotOffered { what: NO_INTERFACE_MODEL.into() }.into()),
            Some(model) => model,
            None => None,
        };
        let output_rates = output_rates.then_some(rates);
        Ok(ExchangeData { interface_model: model, output_rates, ..ExchangeData::default() })
    }
}
