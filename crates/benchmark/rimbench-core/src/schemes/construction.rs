//! The parts of a scheme: everything it will need, so that it makes its buffers once.

use super::contact_detection::ContactDetection;
use super::model_options::ModelOptions;
use crate::cosim::{LineForces, OutputRates, PerSide, Ports};
use crate::error::{Cause, Error, Failure, Result};
use crate::interface_model::ReducedInterfaceModel;

/// The parts of a scheme.
#[derive(Debug, Clone, Copy)]
pub struct Construction<'a> {
    /// The coupling variables.
    pub ports: PerSide<&'a Ports>,
    /// The reduced interface model of the mechanics, if the scheme needs one.
    pub model: Option<ModelConstruction<'a>>,
    /// Value of the scheme's gain; 1 where it has none.
    pub gain: f64,
}

/// A reduced interface model that is to come.
#[derive(Debug, Clone, Copy)]
pub struct ModelConstruction<'a> {
    /// One with nothing in it: its size and its contact law.
    pub empty: &'a ReducedInterfaceModel,
    /// Options.
    pub options: &'a ModelOptions,
    /// How contacts are detected: what was asked for, or the scheme's default; none where the scheme detects none.
    pub detection: Option<ContactDetection>,
}

impl<'a> Construction<'a> {
    /// Returns the dimension of a force–displacement interface: forces that the actuator puts out.
    pub fn interface(&self) -> usize {
        self.ports.actuator.outputs.len()
    }

    /// Returns the interface model to come, for a scheme whose entry asks for one.
    ///
    /// # Errors
    /// [`Error::Incompatible`] where its entry does not.
    pub fn model(&self) -> Result<ModelConstruction<'a>> {
        let missing = "the scheme uses an interface model that its entry does not ask for: add the need";
        self.model.ok_or_else(|| Error::Incompatible(missing.to_owned()))
    }
}

/// Returns the model of a sample, for a scheme that is sent one at every communication point.
pub(super) fn sent(model: Option<&ReducedInterfaceModel>) -> Result<&ReducedInterfaceModel, Failure> {
    model.ok_or_else(|| Failure::from(Cause::NotOffered { what: "no interface model was sent".into() }))
}

/// Returns the directional derivatives of a sample, for a scheme that is sent them at every communication point.
pub(super) fn sent_rates(rates: Option<&OutputRates>) -> Result<&OutputRates, Failure> {
    rates.ok_or_else(|| Failure::from(Cause::NotOffered { what: "no output rates were sent".into() }))
}

/// Returns what the lines of a sample do, for a scheme that is sent it at every communication point.
pub(super) fn sent_lines(lines: Option<&LineForces>) -> Result<&LineForces, Failure> {
    lines.ok_or_else(|| Failure::from(Cause::NotOffered { what: "no line forces were sent".into() }))
}
