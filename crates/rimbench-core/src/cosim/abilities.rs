//! What a subsystem can do besides stepping, all of it in one place.

use super::energy_account::EnergyAccount;
use super::input_polynomials::InputPolynomials;
use super::integrators::SecondOrder;
use super::joint_steps::JointSteps;
use super::oil_lines::OilLines;
use super::output_rates::OutputRates;
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;
use crate::name::Name;
use crate::not_offered;

/// Everything that a subsystem may offer and another may not. A wrapper hands its subsystem's abilities on as a whole (see
/// [`Subsystem::abilities`](super::Subsystem::abilities)), so that none is lost on the way; therefore no method has a default.
///
/// What is not offered: an empty list, `None`, or `false`; [`not_offered!`](super::not_offered) writes that. [`no_abilities`] offers
/// nothing.
pub trait Abilities {
    /// Makes an empty interface model of the right size; none if the subsystem has none to offer.
    fn empty_interface_model(&mut self) -> Option<ReducedInterfaceModel>;

    /// Fills `model` with the subsystem reduced to its interface, for its own step `h` (s). False: it has none to offer now.
    ///
    /// # Errors
    /// [`Cause::Singular`](crate::error::Cause::Singular) if the constraints do not allow the reduction.
    fn interface_model(&mut self, h: f64, model: &mut ReducedInterfaceModel) -> Result<bool, Failure>;

    /// Writes how the outputs move at time `t` with input `u`. False: no directional derivatives.
    ///
    /// # Errors
    /// A [`Failure`] that ends the run and becomes its outcome.
    fn output_rates(&mut self, t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure>;

    /// Room for the course of the inputs within the next micro step; none: their mean is all that is used.
    fn input_polynomials(&mut self) -> Option<&mut InputPolynomials>;

    /// Lets the subsystem step by a rule of the second order from now on.
    ///
    /// # Errors
    /// Why it cannot.
    fn use_second_order(&mut self, rule: SecondOrder) -> Result<(), &'static str>;

    /// Takes steps together with the actuator, where it steps by a rule of the second order; none: it takes them alone.
    fn joint_steps(&mut self) -> Option<&mut dyn JointSteps>;

    /// Volumes of oil that can be replaced by lines; none: it has none.
    fn oil_lines(&mut self) -> Option<&mut dyn OilLines>;

    /// Names the quantities that can be observed at a communication point, with units.
    fn observables(&mut self) -> &[Name];

    /// Writes the observables of the present state; `h` is the subsystem's own step, s.
    fn observe(&mut self, h: f64, row: &mut [f64]);

    /// Work received through the interface since the start, J, as the subsystem's own discretisation counts it.
    fn interface_work(&mut self) -> Option<f64>;

    /// Largest violation of the subsystem's own discrete energy identity in one step, J.
    fn energy_identity_residual(&mut self) -> Option<f64>;

    /// Energy account since the start.
    fn energy_account(&mut self) -> Option<EnergyAccount>;
}

/// Why a subsystem with one integrator cannot use another.
pub const FIRST_ORDER_ONLY: &str = "it has one integrator, its own";

/// Why a subsystem without contacts cannot step from event to event.
pub const NO_CONTACTS: &str = "it has no contacts, and so no events to split at";

/// Returns the abilities of a subsystem that has none.
pub fn no_abilities() -> &'static mut dyn Abilities {
    // A box of nothing takes no memory, and leaks none.
    Box::leak(Box::new(NoAbilities))
}

struct NoAbilities;

impl Abilities for NoAbilities {
    not_offered!(
        empty_interface_model,
        interface_model,
        output_rates,
        input_polynomials,
        use_second_order,
        joint_steps,
        oil_lines,
        observables,
        observe,
        interface_work,
        energy_identity_residual,
        energy_account,
    );
}
