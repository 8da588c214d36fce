//! Micro steps of the second order: the force in the middle of the step depends on the mean motion, for which both are
//! solved.

use super::ReducedInterface;
use crate::cosim::{MicroStep, Side};
use crate::error::Failure;

impl ReducedInterface {
    /// Writes the input of one row at the end of a micro step of the second order.
    pub(in super::super) fn row_at_end(&self, to: Side, row: usize, u: &mut [f64]) {
        if to == Side::Actuator && self.feedthrough.is_on() {
            let rows = self.state.position.len();
            (u[row], u[rows + row]) = (self.state.position[row], self.state.w_plus[self.discretised.contacts() + row]);
        }
    }

    /// Writes the mean position and velocity of a micro step under the force `own`, taken in its middle with the inputs
    /// `u` of its start.
    ///
    /// ```text
    /// w̄ = ½ (w_i + w_i⁺)        s̄ = s + ½δ w̄        s⁺ = s + δ w̄
    /// ```
    /// # Errors
    /// As the contact solver reports.
    #[inline(never)]
    pub(super) fn input_of_second_order(&mut self, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        let (n, n_i) = (self.discretised.contacts(), own.len());
        let mut force = std::mem::take(&mut self.feedthrough.start_force);
        force.copy_from_slice(own);
        self.feedthrough.force_at_start(u, &self.state.position, &self.state.w_plus[n..n + n_i], &mut force);
        let stepped = self.step(&force, at);
        self.feedthrough.start_force = force;
        stepped?;
        let (u_position, u_velocity) = u.split_at_mut(n_i);
        for (i, (w, w_plus)) in self.state.w[n..n + n_i].iter().zip(&self.state.w_plus[n..]).enumerate() {
            let mean = 0.5 * (w_plus + w);
            u_position[i] = self.state.position[i] + 0.5 * at.length * mean;
            u_velocity[i] = mean;
            self.state.position[i] += at.length * mean;
        }
        Ok(())
    }
}
