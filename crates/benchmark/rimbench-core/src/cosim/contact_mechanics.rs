//! What the non-smooth stepper offers besides what any subsystem may: contacts, and steps together with the actuator.

use super::output_history::ForceProfile;
use super::output_rates::OutputRates;
use crate::error::Failure;
use crate::name::Name;

/// Is told length (s), force and mean motion of each piece of a joint step.
pub type Sent<'a> = dyn FnMut(f64, &[f64], &[f64]) + 'a;

/// Requests of a joint step to the actuator.
pub trait JointActuator {
    /// Writes its outputs at time `t` (s) with the motion `u`, and how they move.
    ///
    /// # Errors
    /// A [`Failure`] of the actuator, or that it has no rates.
    fn outputs_and_rates(&mut self, t: f64, u: &[f64], y: &mut [f64], rates: &mut OutputRates) -> Result<(), Failure>;

    /// Advances it from `t` by `h` (s) with the motion `u` of the middle.
    ///
    /// # Errors
    /// A [`Failure`] of the actuator.
    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure>;
}

/// Offers what only [`NonSmoothMechanics`](crate::mechanics::NonSmoothMechanics) has, whatever its model. Without
/// defaults, as it is no trait for others to implement.
pub trait ContactMechanics {
    /// Names the contacts of the interface model, whose gaps are `gap_<contact>_m`.
    fn contact_names(&self) -> &[Name];

    /// Returns its coordinates q, in the units of the model.
    fn coordinates(&self) -> &[f64];

    /// Returns the contact impulses of the last step, N·s, on the contact rows of the interface model; none after steps
    /// of the second order.
    fn contact_impulses(&self) -> Option<&[f64]>;

    /// Keeps every entry of the matrices of its contacts from now on, before the first step: asked for by what cannot
    /// use sparse ones. Where memory does not hold them they stay as they are.
    fn keep_every_entry(&mut self);

    /// Tells whether it steps by a rule of the second order. Only then it takes steps together with the actuator, or
    /// under a profile.
    fn is_of_second_order(&self) -> bool;

    /// Advances both sides from `time` by `h` (s): each piece is taken by both, with the force that belongs to its own
    /// motion.
    ///
    /// # Errors
    /// A [`Failure`] of either side, or [`Cause::NotConverged`](crate::error::Cause::NotConverged) where force and
    /// motion do not agree.
    fn step_together(
        &mut self,
        actuator: &mut dyn JointActuator,
        time: f64,
        h: f64,
        sent: &mut Sent<'_>,
    ) -> Result<(), Failure> {
        while self.step_together_to_event(&mut *actuator, time, h, &mut *sent)?.is_some() {}
        Ok(())
    }

    /// Does the same up to the next event: returns the time (s) of the step that is over where one is met, before it acts
    /// and once more after it, to be called again with the same step until it is over.
    ///
    /// # Errors
    /// Those of [`step_together`](Self::step_together).
    fn step_together_to_event(
        &mut self,
        actuator: &mut dyn JointActuator,
        time: f64,
        h: f64,
        sent: &mut Sent<'_>,
    ) -> Result<Option<f64>, Failure>;

    /// Advances the mechanics alone by `h` (s): each piece is taken under the mean force over that piece.
    ///
    /// # Errors
    /// A [`Failure`] of the mechanics.
    fn step_under(&mut self, profile: ForceProfile<'_>, h: f64) -> Result<(), Failure>;
}
