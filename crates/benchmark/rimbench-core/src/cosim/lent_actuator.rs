//! An actuator lent to a joint step.

use super::contact_mechanics::JointActuator;
use super::exchange_data::NO_OUTPUT_RATES;
use super::output_rates::OutputRates;
use super::subsystem::Subsystem;
use crate::error::{Cause, Failure};

/// A subsystem as a joint step sees it.
pub(crate) struct LentActuator<'a>(pub(crate) &'a mut dyn Subsystem);

impl JointActuator for LentActuator<'_> {
    fn outputs_and_rates(&mut self, t: f64, u: &[f64], y: &mut [f64], rates: &mut OutputRates) -> Result<(), Failure> {
        self.0.outputs(u, y)?;
        if self.0.capabilities().output_rates(t, u, rates)? {
            return Ok(());
        }
        Err(Cause::NotOffered { what: NO_OUTPUT_RATES.into() }.into())
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.0.step(t, u, h)
    }
}
