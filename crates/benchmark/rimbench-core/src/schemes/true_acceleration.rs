//! `true-acceleration`: the mechanics sends the acceleration it has; the motion follows from it.
//!
//! An extrapolation guesses the acceleration from two velocities, and is wrong after every impact. The mechanics knows
//! it: the actuator is moved by it, and the force that goes with that motion is worked out from the actuator's own
//! rates.
//!
//! ```text
//! a_k = a_i + H_ii λ_k + H_iR Λ                     at t_k, fresh force, resting contacts (see `interface_acceleration`)
//! w̃ = w_k + τ a_k      s̃ = s_k + τ w_k + ½ τ² a_k   λ̃ = λ_k + τ (r + D u̇) + ½ τ² (R u̇ + D ü)
//! ```
//! With the actuator first it runs on the predicted motion and its own force goes back: the constitutive equation of
//! the coupling element at predicted states; λ̃ is its linearisation, for Jacobi. With the mechanics first it receives
//! λ̃, and the actuator the cubic through position and velocity at both ends. A backward difference of the velocity
//! instead of `a_k` is `first-order-hold` for the velocity, under another name. **Needs** an interface model (a
//! mechanics that sends accelerations would do) and output rates. **Order** 2 in H. **Known weakness**: contacts that
//! open or close within H; at an impact the acceleration is the one after it; λ acts back on w only in the next macro
//! step. **Source**: after the idea of "Explicit Co-simulation Approach with Improved Numerical Stability", IUTAM
//! Bookseries 35 (2019): coupling variables predicted by way of the accelerations of the coupling bodies. Formula not
//! read, derived here; nothing is said about the authors' method.

use super::construction::{Construction, sent, sent_rates};
use super::entry::SchemeEntry;
use super::input_polynomial::{InputPolynomial, hermite};
use super::interface_acceleration::InterfaceAcceleration;
use super::requirement::Requirement;
use super::taylor_force::taylor_force;
use crate::cosim::{CouplingScheme, Cubic, MicroStep, OutputRates, Sample, SchemeReport, Side};
use crate::error::{Failure, Result};

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 2,
        needs: vec![Requirement::ForceDisplacement, Requirement::InterfaceModel, Requirement::OutputRates],
        ..SchemeEntry::new(
            "true-acceleration",
            "Hold the acceleration that the mechanics has, integrate it to velocity and position",
            |construction| Ok(Box::new(TrueAcceleration::new(construction)?)),
        )
    }
}

#[derive(Clone)]
struct TrueAcceleration {
    mechanics: InterfaceAcceleration,
    position: Vec<f64>,
    velocity: Vec<f64>,
    motion: InputPolynomial,
    force: InputPolynomial,
}

impl TrueAcceleration {
    fn new(construction: &Construction<'_>) -> Result<Self> {
        let m = construction.interface();
        Ok(TrueAcceleration {
            mechanics: InterfaceAcceleration::new(construction.model()?),
            position: vec![0.0; m],
            velocity: vec![0.0; m],
            motion: InputPolynomial::new(2 * m, 3),
            force: InputPolynomial::new(m, 2),
        })
    }

    /// The mechanics' sample of a communication point.
    fn begin(&mut self, sample: &Sample<'_>) -> Result<(), Failure> {
        let m = self.position.len();
        self.mechanics.receive(sent(sample.model)?);
        self.position.copy_from_slice(&sample.y[..m]);
        self.velocity.copy_from_slice(&sample.y[m..]);
        Ok(())
    }

    fn predict(&mut self, lambda: &[f64], rates: &OutputRates) -> Result<(), Failure> {
        self.mechanics.find(lambda)?;
        let m = self.position.len();
        for (i, &a) in self.mechanics.acceleration.iter().enumerate() {
            self.motion.rows[i] = [self.position[i], self.velocity[i], 0.5 * a, 0.0];
            self.motion.rows[m + i] = [self.velocity[i], a, 0.0, 0.0];
        }
        taylor_force(lambda, rates, [&self.velocity, &self.mechanics.acceleration], &mut self.force.rows);
        Ok(())
    }
}

impl CouplingScheme for TrueAcceleration {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        match from {
            Side::Mechanics if sample.model.is_some() => self.begin(sample),
            // Sent ahead: the mechanics went first.
            Side::Mechanics => {
                interpolate(&self.position, &self.velocity, sample, &mut self.motion);
                Ok(())
            }
            Side::Actuator => {
                let rates = sent_rates(sample.rates)?;
                self.predict(sample.y, rates)
            }
        }
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        self.to(to).mean(at, u);
        Ok(())
    }

    fn input_polynomials(&self, to: Side, at: MicroStep, polynomials: &mut [Cubic]) -> bool {
        self.to(to).within(at, polynomials)
    }

    fn report(&mut self) -> SchemeReport {
        self.mechanics.report()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

impl TrueAcceleration {
    #[inline]
    fn to(&self, side: Side) -> &InputPolynomial {
        match side {
            Side::Mechanics => &self.force,
            Side::Actuator => &self.motion,
        }
    }
}

/// Lets a motion go from position and velocity at the start of the macro step to those of a sample at its end.
pub(super) fn interpolate(position: &[f64], velocity: &[f64], end: &Sample<'_>, motion: &mut InputPolynomial) {
    let m = position.len();
    for i in 0..m {
        let (from, to) = ([position[i], velocity[i]], [end.y[i], end.y[m + i]]);
        let [s, w] = hermite(from, to, end.step.length);
        (motion.rows[i], motion.rows[m + i]) = (s, w);
    }
}
