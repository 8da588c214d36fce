//! A mechanics that takes its steps together with the actuator, both cut at common events, or under the profile of its force.

use super::output_history::ForceProfile;
use super::output_rates::OutputRates;
use crate::error::Failure;

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

/// Steps that a mechanics of the second order offers besides those under a force that is held.
pub trait JointSteps {
    /// Advances both sides from `time` by `h` (s): each piece is taken by both, with the force that belongs to its own motion.
    ///
    /// # Errors
    /// A [`Failure`] of either side, or [`Cause::NotConverged`](crate::error::Cause::NotConverged) where force and motion do not
    /// agree.
    fn step_together(
        &mut self,
        actuator: &mut dyn JointActuator,
        time: f64,
        h: f64,
        sent: &mut Sent<'_>,
    ) -> Result<(), Failure>;

    /// Advances the mechanics alone by `h` (s): each piece is taken under the mean force over that piece.
    ///
    /// # Errors
    /// A [`Failure`] of the mechanics.
    fn step_under(&mut self, profile: ForceProfile<'_>, h: f64) -> Result<(), Failure>;
}
