//! `interface-mass`: the actuator moves a copy of the mechanics' interface mass; everything else that acts on it is
//! held.
//!
//! ```text
//! m_v = 1/(κ H_ii(t₀))        φ_k = m_v a_k − λ_k        m_v ẇ_A = λ(τ) + φ_k
//! w_A⁺ = w_A + δ [a_k + κ H_ii(t₀) (λ − λ_k)]        s_A⁺ = s_A + δ w_A⁺        (s, w)_A = (s, w)_k at t_k
//! ```
//! `H_ii` is that of `t_k` where the model is one from outside and may vary. One number and the true acceleration `a_k`
//! instead of a model: κ = 0 is `true-acceleration`, κ = 1 on a mechanics without contacts and with constant `H_ii` a
//! reduced interface model. The micro step is that of the interface models. With Jacobi the mechanics receives the
//! force by the actuator's rates. **Needs** an interface model, output rates; not for the mechanics first. **Order** 2
//! in H. **Known weakness**: contacts enter through `a_k` only; too light a mass is worse than too heavy a one.
//! **Source**: after the idea of "A co-simulation algorithm for the efficient real-time parallel solution of multibody
//! systems" (Politecnico di Milano 2026): interface mass kept on both sides of the cut. Formula not read, derived here;
//! nothing is said about the authors' method.

use super::construction::{Construction, sent, sent_rates};
use super::entry::{Family, Gain, SchemeEntry};
use super::input_polynomial::InputPolynomial;
use super::interface_acceleration::InterfaceAcceleration;
use super::requirement::Requirement;
use super::taylor_force::taylor_force;
use crate::cosim::{CouplingScheme, Cubic, Forecast, MicroStep, Sample, SchemeReport, Sequence, Side};
use crate::error::{Failure, Result};

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        family: Family::Model,
        order: 2,
        sequence: Sequence::GaussSeidel { first: Side::Actuator },
        needs: vec![
            Requirement::ForceDisplacement,
            Requirement::InterfaceModel,
            Requirement::OutputRates,
            Requirement::NotMechanicsFirst,
        ],
        gain: Some(Gain {
            about: "κ = 1/(m_v H_ii), the inverse of the copied mass".into(),
            default: 1.0,
            range: [0.0, 2.0],
        }),
        ..SchemeEntry::new(
            "interface-mass",
            "The actuator moves a copy of the interface mass, with all other loads on it held",
            |construction| Ok(Box::new(InterfaceMass::new(construction)?)),
        )
    }
}

#[derive(Clone)]
struct InterfaceMass {
    kappa: f64,
    mechanics: InterfaceAcceleration,
    /// κ H_ii, row-major, of t₀, or of the last sample where it varies; NaN before the first one.
    mobility: Vec<f64>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    /// Velocity at the communication point, and no jerk.
    start: Vec<f64>,
    lambda: Vec<f64>,
    force: InputPolynomial,
}

impl InterfaceMass {
    fn new(construction: &Construction<'_>) -> Result<Self> {
        let m = construction.interface();
        Ok(InterfaceMass {
            kappa: construction.gain,
            mechanics: InterfaceAcceleration::new(construction.model()?),
            mobility: vec![f64::NAN; m * m],
            position: vec![0.0; m],
            velocity: vec![0.0; m],
            start: vec![0.0; m],
            lambda: vec![0.0; m],
            force: InputPolynomial::new(m, 2),
        })
    }
}

impl CouplingScheme for InterfaceMass {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let m = self.position.len();
        match from {
            Side::Mechanics => {
                self.mechanics.receive(sent(sample.model)?);
                self.position.copy_from_slice(&sample.y[..m]);
                self.velocity.copy_from_slice(&sample.y[m..]);
                self.start.copy_from_slice(&sample.y[m..]);
                let varies = self.mechanics.inertia_varies();
                for (index, mobility) in self.mobility.iter_mut().enumerate().filter(|(_, h)| varies || h.is_nan()) {
                    *mobility = self.kappa * self.mechanics.free_mobility(index / m, index % m);
                }
            }
            Side::Actuator => {
                let rates = sent_rates(sample.rates)?;
                self.lambda.copy_from_slice(sample.y);
                self.mechanics.find(sample.y)?;
                let moves = [&self.start[..], &self.mechanics.acceleration];
                taylor_force(sample.y, rates, moves, &mut self.force.rows);
            }
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Mechanics {
            self.force.mean(at, u);
            return Ok(());
        }
        let m = self.position.len();
        for i in 0..m {
            let pushed: f64 = (0..m).map(|j| self.mobility[i * m + j] * (own[j] - self.lambda[j])).sum();
            self.velocity[i] += at.length * (self.mechanics.acceleration[i] + pushed);
            self.position[i] += at.length * self.velocity[i];
            (u[i], u[m + i]) = (self.position[i], self.velocity[i]);
        }
        Ok(())
    }

    fn input_polynomials(&self, to: Side, at: MicroStep, polynomials: &mut [Cubic]) -> bool {
        to == Side::Mechanics && self.force.within(at, polynomials)
    }

    fn forecast(&self) -> Option<Forecast<'_>> {
        Some(Forecast { position: &self.position, next_closing: None })
    }

    fn report(&mut self) -> SchemeReport {
        self.mechanics.report()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}
