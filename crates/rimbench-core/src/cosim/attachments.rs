//! What goes with the samples of a communication point besides outputs, for schemes that need it.

use super::output_rates::OutputRates;
use super::ports::Ports;
use super::subsystem::Sides;
use crate::error::{Cause, Failure};
use crate::interface_model::ReducedInterfaceModel;

/// Room for what is exchanged besides outputs, filled anew at every communication point. Nothing by default.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Attachments {
    /// The mechanics reduced to its interface.
    pub interface_model: Option<ReducedInterfaceModel>,
    /// How the actuator's outputs move.
    pub output_rates: Option<OutputRates>,
}

/// Why a scheme with an interface model cannot be run, or cannot go on.
pub(crate) const NO_INTERFACE_MODEL: &str = "the mechanics offers no reduced interface model";
/// Likewise.
pub(crate) const NO_OUTPUT_RATES: &str = "the actuator offers no directional derivatives of its outputs";

impl Attachments {
    /// Makes room for what a scheme needs of two subsystems.
    ///
    /// # Errors
    /// [`Cause::NotOffered`] if the mechanics has no interface model.
    pub fn new(sides: Sides<'_>, interface_model: bool, output_rates: bool) -> Result<Attachments, Failure> {
        let Ports { inputs, outputs, .. } = sides.actuator.ports();
        let rates = OutputRates::zeros(outputs.len(), inputs.len());
        let model = match interface_model.then(|| sides.mechanics.abilities().empty_interface_model()) {
            Some(None) => return Err(Cause::NotOffered { what: NO_INTERFACE_MODEL }.into()),
            Some(model) => model,
            None => None,
        };
        Ok(Attachments { interface_model: model, output_rates: output_rates.then_some(rates) })
    }
}
