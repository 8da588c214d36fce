//! The optional capabilities of a subsystem, all in one place.

use super::Subsystem;
use crate::cosim::contact_mechanics::ContactMechanics;
use crate::cosim::energy_account::EnergyAccount;
use crate::cosim::input_polynomials::InputPolynomials;
use crate::cosim::integrators::SecondOrder;
use crate::cosim::output_rates::OutputRates;
use crate::cosim::transmission_lines::TransmissionLines;
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;
use crate::name::Name;

/// Offers what one subsystem may have and another may not. Each default offers nothing, so that an implementation names
/// only what there is.
///
/// A wrapper returns the capabilities of the subsystem inside it as a whole
/// ([`Subsystem::capabilities`]), so that none is lost.
pub trait Capabilities {
    /// Makes an empty interface model of the right size; none if the subsystem has none to offer.
    fn empty_interface_model(&mut self) -> Option<ReducedInterfaceModel> {
        None
    }

    /// Fills `model` with the subsystem reduced to its interface, for its own step `h` (s). False: it has none to offer
    /// now.
    ///
    /// # Errors
    /// [`Cause::Singular`](crate::error::Cause::Singular) if the constraints do not allow the reduction.
    fn interface_model(&mut self, _h: f64, _model: &mut ReducedInterfaceModel) -> Result<bool, Failure> {
        Ok(false)
    }

    /// Writes how the outputs move at time `t` with input `u`. False: no directional derivatives.
    ///
    /// # Errors
    /// A [`Failure`] that ends the run and becomes its outcome.
    fn output_rates(&mut self, _t: f64, _u: &[f64], _rates: &mut OutputRates) -> Result<bool, Failure> {
        Ok(false)
    }

    /// Lends room for the polynomials of the inputs within the next micro step; none: their mean is all that is used.
    fn input_polynomials(&mut self) -> Option<&mut InputPolynomials> {
        None
    }

    /// Lets the subsystem step by a rule of the second order from now on.
    ///
    /// # Errors
    /// Why it cannot.
    fn use_second_order(&mut self, _rule: SecondOrder) -> Result<(), &'static str> {
        Err(FIRST_ORDER_ONLY)
    }

    /// Lends what only a mechanics with contacts has; none: it is another subsystem, or wraps one.
    fn contact_mechanics(&mut self) -> Option<&mut dyn ContactMechanics> {
        None
    }

    /// Lends the volumes of oil that can be replaced by lines; none: it has none.
    fn oil_lines(&mut self) -> Option<&mut dyn TransmissionLines> {
        None
    }

    /// Lends the actuator that has a row, with inputs (positions, velocities) and its forces as outputs; none where there
    /// is no such subsystem for itself.
    fn actuator_of_row(&mut self, _row: usize) -> Option<&mut dyn Subsystem> {
        None
    }

    /// Lists all rows of an actuator that has several, one of them `row`, ascending; none where it has that one alone.
    fn rows_beside(&mut self, _row: usize) -> &[usize] {
        &[]
    }

    /// Names the quantities that can be observed at a communication point, with units.
    fn observables(&mut self) -> &[Name] {
        &[]
    }

    /// Writes the observables of the present state; `h` is the subsystem's own step, s.
    fn observe(&mut self, _h: f64, _row: &mut [f64]) {}

    /// Returns the work received through the interface since the start, J, as the subsystem's own discretisation counts
    /// it.
    fn interface_work(&mut self) -> Option<f64> {
        None
    }

    /// Returns the largest violation of the subsystem's own discrete energy identity in one step, J.
    fn energy_identity_residual(&mut self) -> Option<f64> {
        None
    }

    /// Returns the energy account since the start.
    fn energy_account(&mut self) -> Option<EnergyAccount> {
        None
    }
}

/// Why a subsystem with one integrator cannot use another.
pub const FIRST_ORDER_ONLY: &str = "it has one integrator, its own";

/// Why a subsystem without contacts cannot step from event to event.
pub const NO_CONTACTS: &str = "it has no contacts, and so no events to split at";
