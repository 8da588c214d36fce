//! The crane as one system of ordinary differential equations, by the trapezoidal rule.

use crate::models::{Crane, Cylinder, HydraulicCylinder};
use nalgebra::{LU, SMatrix, SVector, U6};
use rimbench_core::cosim::{StopFlag, Trajectory};
use rimbench_core::error::{Cause, Failure};
use rimbench_core::mechanics::{MechanicalModel, ReferenceSteps};

/// `θ₁, θ₂, θ̇₁, θ̇₂, p₁, p₂`.
type State = SVector<f64, 6>;

/// Sizes by which a change of the state is judged; the pressures are about 1e6 Pa.
const SCALE: [f64; 6] = [1.0, 1.0, 1.0, 1.0, 1e6, 1e6];

/// Relative size of the last Newton increment.
const TOLERANCE: f64 = 1e-14;

/// More Newton iterations than this in a step make the next one take a fresh Jacobian.
const QUICK: usize = 4;

/// Then the iteration has failed.
const MOST: usize = 60;

/// What both the co-simulation and the reference are made from.
#[derive(Clone)]
pub(super) struct Parts {
    pub(super) crane: Crane,
    pub(super) cylinder: HydraulicCylinder,
    pub(super) size: Cylinder,
}

impl Parts {
    /// Integrates the whole crane, and writes a row wherever one is due.
    ///
    /// ```text
    /// x⁺ = x + ½ h (f(t, x) + f(t + h, x⁺))       x = (θ₁, θ₂, θ̇₁, θ̇₂, p₁, p₂)
    /// ```
    /// Second order and free of numerical damping. The published reference is the same rule with the same step, in
    /// redundant coordinates with the constraints on level of position; Newton with a Jacobian kept as long as it
    /// serves.
    ///
    /// # Errors
    /// [`Cause::NonFinite`](rimbench_core::error::Cause::NonFinite) where the iteration does not converge;
    /// [`Cause::Stopped`].
    pub(super) fn solve(
        &mut self,
        steps: ReferenceSteps,
        stop: StopFlag<'_>,
        trajectory: &mut Trajectory,
    ) -> Result<(), Failure> {
        let h = steps.h;
        let mut x = self.start();
        self.write(0.0, &x, trajectory.push_row());
        let mut rate = self.rate(0.0, &x);
        let mut jacobian = self.newton_matrix(0.0, &x, h);
        for step in 1..=steps.steps {
            stop.check()?;
            let t = step as f64 * h;
            let mut next = x + h * rate;
            let mut iterations = 0;
            let next_rate = loop {
                let next_rate = self.rate(t, &next);
                let residual = next - x - 0.5 * h * (rate + next_rate);
                let change = jacobian
                    .solve(&residual)
                    .ok_or_else(|| Failure::from(Cause::Singular { matrix: "Newton matrix" }))?;
                next -= change;
                iterations += 1;
                if iterations > MOST || next.iter().any(|value| !value.is_finite()) {
                    return Err(Failure::non_finite("state of the crane"));
                }
                if change.iter().zip(SCALE).all(|(change, scale)| change.abs() <= TOLERANCE * scale) {
                    break self.rate(t, &next);
                }
                if iterations % (2 * QUICK) == 0 {
                    jacobian = self.newton_matrix(t, &next, h);
                }
            };
            (x, rate) = (next, next_rate);
            if iterations > QUICK {
                jacobian = self.newton_matrix(t, &x, h);
            }
            if steps.shows(step) {
                self.write(t, &x, trajectory.push_row());
            }
        }
        Ok(())
    }

    fn start(&self) -> State {
        let (q, v) = self.crane.initial_state();
        let p = self.cylinder.pressures();
        State::from([q[0], q[1], v[0], v[1], p[0], p[1]])
    }

    /// Length, velocity and force of the actuator; prepares the crane.
    fn actuator(&mut self, x: &State) -> [f64; 3] {
        self.crane.prepare(&[x[0], x[1]], &[x[2], x[3]]);
        let (length, lever, _) = self.crane.actuator();
        let velocity = lever * x[2];
        [length, velocity, self.size.force([x[4], x[5]], velocity)]
    }

    fn rate(&mut self, t: f64, x: &State) -> State {
        let [length, velocity, force] = self.actuator(x);
        let a = self.crane.acceleration([x[2], x[3]], force);
        let p = self.cylinder.pressure_rates([x[4], x[5]], length, velocity, self.cylinder.spool_at(t));
        State::from([x[2], x[3], a[0], a[1], p[0], p[1]])
    }

    /// `I − ½ h ∂f/∂x` by central differences, factored.
    fn newton_matrix(&mut self, t: f64, x: &State, h: f64) -> LU<f64, U6, U6> {
        let mut matrix = SMatrix::<f64, 6, 6>::identity();
        for (column, scale) in SCALE.into_iter().enumerate() {
            let step = 1e-6 * scale;
            let mut moved = *x;
            moved[column] += step;
            let ahead = self.rate(t, &moved);
            moved[column] -= 2.0 * step;
            let slope = (ahead - self.rate(t, &moved)) / (2.0 * step);
            matrix.column_mut(column).axpy(-0.5 * h, &slope, 1.0);
        }
        matrix.lu()
    }

    fn write(&mut self, t: f64, x: &State, row: &mut [f64]) {
        let [length, velocity, force] = self.actuator(x);
        row.copy_from_slice(&[t, length, velocity, force, x[4], x[5], self.cylinder.spool_at(t), x[0], x[1]]);
    }
}
