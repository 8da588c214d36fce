//! `model-corrected-outputs`: after the macro step one knows what the mechanics should have received; the model says by
//! how much its outputs are off. They are corrected at once, its state with the next input.
//!
//! ```text
//! E_k = ∫ λ dt − ∫ λ̃ dt                       over the last macro step, λ̃ without its repayment
//! dw = Ĥ E_k                                   what w_k lacks; Ĥ with the contacts that carry force closed
//! w̃ = w_k + dw + a_k τ      s̃ = s_k + (w_k + dw) τ + ½ a_k τ²
//! λ̃ = λ^c + τ (r^c + D u̇) + ½ τ² (R u̇ + D ü) + α E_k/H       λ^c = λ_k + D_w dw,  r^c = r + R_w dw
//! ```
//! The impulse put out is that of `output_integral`.
//! **Needs** an interface model, output rates, force return `held`: with the actuator's own force returned there is no
//! error to correct, and the scheme is `true-acceleration`. **Order** 2 in H, with the smallest error of the Jacobi
//! schemes on a linear oscillator. **Known weakness**: after an impact model and error belong to different contacts, so
//! E is forgotten where they change; corrected outputs may violate gaps by H dw. **Source**: after the idea of Haid,
//! Watzenig, Stettinger, Multibody Syst. Dyn. 2022 (model-based corrector for explicit co-simulation). Formula not
//! read, derived here; nothing is said about the authors' method.

use super::construction::{Construction, sent, sent_rates};
use super::entry::{Family, Gain, SchemeEntry};
use super::input_polynomial::InputPolynomial;
use super::interface_acceleration::InterfaceAcceleration;
use super::output_integral::OutputIntegral;
use super::requirement::Requirement;
use super::taylor_force::taylor_force;
use super::true_acceleration::interpolate;
use crate::cosim::{CouplingScheme, Cubic, MicroStep, OutputRates, Sample, SchemeReport, Side};
use crate::error::{Failure, Result};

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        family: Family::Model,
        order: 2,
        samples: 2,
        needs: vec![
            Requirement::ForceDisplacement,
            Requirement::InterfaceModel,
            Requirement::OutputRates,
            Requirement::HeldReturn,
        ],
        gain: Some(Gain {
            about: "α, the share of the missing impulse that is given back".into(),
            default: 1.0,
            range: [0.0, 2.0],
        }),
        ..SchemeEntry::new(
            "model-corrected-outputs",
            "Its model corrects the mechanics' outputs for the impulse that is still missing; the impulse follows",
            |construction| Ok(Box::new(ModelCorrectedOutputs::new(construction)?)),
        )
    }
}

#[derive(Clone)]
struct ModelCorrectedOutputs {
    alpha: f64,
    mechanics: InterfaceAcceleration,
    /// ∫ λ dt since the communication point, and E of the one before.
    impulse: OutputIntegral,
    missing: Vec<f64>,
    /// The fresh input that goes with the actuator's sample.
    fresh: Vec<f64>,
    position: Vec<f64>,
    /// As sent, and corrected.
    velocity: Vec<f64>,
    corrected: Vec<f64>,
    /// λ^c and the rates with r^c.
    lambda: Vec<f64>,
    rates: OutputRates,
    motion: InputPolynomial,
    /// λ̃ without the repayment, for which length, and the repayment.
    force: InputPolynomial,
    length: f64,
    repayment: Vec<f64>,
}

impl ModelCorrectedOutputs {
    fn new(construction: &Construction<'_>) -> Result<Self> {
        let m = construction.interface();
        let zeros = || vec![0.0; m];
        Ok(ModelCorrectedOutputs {
            alpha: construction.gain,
            mechanics: InterfaceAcceleration::new(construction.model()?),
            impulse: OutputIntegral::new(m, 2 * m),
            missing: zeros(),
            fresh: vec![0.0; 2 * m],
            position: zeros(),
            velocity: zeros(),
            corrected: zeros(),
            lambda: zeros(),
            rates: OutputRates::zeros(m, 2 * m),
            motion: InputPolynomial::new(2 * m, 3),
            force: InputPolynomial::new(m, 2),
            length: 0.0,
            repayment: zeros(),
        })
    }

    fn predict(&mut self, lambda: &[f64], rates: &OutputRates, h: f64) -> Result<(), Failure> {
        self.mechanics.find(lambda)?;
        let m = lambda.len();
        let forget = self.mechanics.contacts_changed();
        for i in 0..m {
            let [c0, c1, c2, _] = self.force.rows[i];
            let told = self.length * (c0 + self.length * (0.5 * c1 + self.length * c2 / 3.0));
            self.missing[i] = if forget { 0.0 } else { self.impulse.value[i] - told };
        }
        for i in 0..m {
            let lacks: f64 = (0..m).map(|j| self.mechanics.mobility()[i * m + j] * self.missing[j]).sum();
            self.corrected[i] = self.velocity[i] + lacks;
        }
        self.rates.feedthrough.copy_from_slice(&rates.feedthrough);
        self.rates.rate_gain.copy_from_slice(&rates.rate_gain);
        for i in 0..m {
            let answer = |gain: &[f64]| -> f64 {
                (0..m).map(|j| gain[i * 2 * m + m + j] * (self.corrected[j] - self.velocity[j])).sum()
            };
            self.lambda[i] = lambda[i] + answer(&rates.feedthrough);
            self.rates.rate[i] = rates.rate[i] + answer(&rates.rate_gain);
        }
        let a = &self.mechanics.acceleration;
        taylor_force(&self.lambda, &self.rates, [&self.corrected, a], &mut self.force.rows);
        for (i, &a) in a.iter().enumerate() {
            self.motion.rows[i] = [self.position[i], self.corrected[i], 0.5 * a, 0.0];
            self.motion.rows[m + i] = [self.corrected[i], a, 0.0, 0.0];
            self.repayment[i] = self.alpha * self.missing[i] / h;
        }
        self.length = h;
        Ok(())
    }
}

impl CouplingScheme for ModelCorrectedOutputs {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let m = self.position.len();
        match from {
            Side::Mechanics if sample.model.is_some() => {
                self.mechanics.receive(sent(sample.model)?);
                self.position.copy_from_slice(&sample.y[..m]);
                self.velocity.copy_from_slice(&sample.y[m..]);
                self.fresh.copy_from_slice(sample.y);
                Ok(())
            }
            // Sent ahead: the mechanics went first.
            Side::Mechanics => {
                interpolate(&self.position, &self.corrected, sample, &mut self.motion);
                Ok(())
            }
            Side::Actuator => {
                let rates = sent_rates(sample.rates)?;
                self.impulse.see(sample.time, sample.y, &self.fresh);
                self.predict(sample.y, rates, sample.step.length)?;
                self.impulse.restart(sample.time, sample.y, &self.fresh, Some(rates));
                Ok(())
            }
        }
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        match to {
            Side::Actuator => {
                self.impulse.see(at.start, own, u);
                self.motion.mean(at, u);
                self.impulse.give(at.length, u);
            }
            Side::Mechanics => {
                self.force.mean(at, u);
                u.iter_mut().zip(&self.repayment).for_each(|(u, repayment)| *u += repayment);
            }
        }
        Ok(())
    }

    fn input_polynomials(&self, to: Side, at: MicroStep, polynomials: &mut [Cubic]) -> bool {
        match to {
            Side::Actuator => self.motion.within(at, polynomials),
            Side::Mechanics => {
                let told = self.force.within(at, polynomials);
                polynomials.iter_mut().zip(&self.repayment).for_each(|([c0, ..], repayment)| *c0 += repayment);
                told
            }
        }
    }

    fn report(&mut self) -> SchemeReport {
        self.mechanics.report()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}
