//! `interface-exponential`: both outputs over the coming macro step predicted as one coupled linear system, exactly;
//! each side is given what the other is predicted to do.
//!
//! ```text
//! Δλ̇ = r + R (Δs, Δw) + D_s (w_k + Δw) + D_w (a_k + Ĥ Δλ)      Δṡ = w_k + Δw      Δẇ = a_k + Ĥ Δλ        zero at t_k
//! actuator gets s_k + Δs(τ), w_k + Δw(τ);   mechanics gets λ_k + Δλ(τ)
//! ```
//! `a_k`, `Ĥ` as in `interface_acceleration`, `r, D, R` the actuator's directional derivatives. The system is stepped
//! from one micro step to the next by its matrix exponential; within a micro step the signal is the cubic that meets
//! values and slopes at both ends. With the actuator first only the motion counts, with the mechanics first only the
//! force. **Needs** an interface model, directional derivatives of the actuator. **Order** 2 in H. **Known weakness**:
//! the actuator's inner states are frozen; one set of contacts per macro step. Differs from `interface-jacobian` in the
//! exponential instead of the trapezoidal rule, in which contacts are closed, and in that profiles are sent.
//! **Source**: after the idea of pre-step stabilisation (Genser, Benedikt 2018: inputs modified before the step, from
//! partial derivatives of the subsystems). Formula not read, derived here; nothing is said about the authors' method.

use super::construction::{Construction, sent, sent_rates};
use super::entry::{Family, SchemeEntry};
use super::exponential_step::ExponentialStep;
use super::input_polynomial::{InputPolynomial, hermite};
use super::interface_acceleration::InterfaceAcceleration;
use super::requirement::Requirement;
use super::true_acceleration::interpolate;
use crate::cosim::{CouplingScheme, Cubic, MicroStep, OutputRates, PerSide, Sample, SchemeReport, Side};
use crate::error::{Failure, Result};

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        family: Family::Model,
        order: 2,
        needs: vec![Requirement::ForceDisplacement, Requirement::InterfaceModel, Requirement::OutputRates],
        ..SchemeEntry::new(
            "interface-exponential",
            "Both outputs predicted as one coupled linear system, exactly, and sent as profiles",
            |construction| Ok(Box::new(InterfaceExponential::new(construction)?)),
        )
    }
}

/// The prediction as one side follows it: its own micro step, and where it stands.
#[derive(Clone)]
struct Follower {
    flow: ExponentialStep,
    /// Start of the micro step that `state` belongs to.
    index: usize,
    state: Vec<f64>,
    rate: Vec<f64>,
    /// Polynomials within the present micro step, in the order Δλ, Δs, Δw.
    rows: Vec<Cubic>,
}

#[derive(Clone)]
struct InterfaceExponential {
    mechanics: InterfaceAcceleration,
    position: Vec<f64>,
    velocity: Vec<f64>,
    force: Vec<f64>,
    /// S of y' = S y + c, row-major over (Δλ, Δs, Δw); and c.
    generator: Vec<f64>,
    constant: Vec<f64>,
    followers: PerSide<Follower>,
    /// The motion between samples of the mechanics, if it went first.
    interpolated: InputPolynomial,
    ahead: bool,
}

impl InterfaceExponential {
    fn new(construction: &Construction<'_>) -> Result<Self> {
        let m = construction.interface();
        let n = 3 * m;
        let follower = || Follower {
            flow: ExponentialStep::new(n),
            index: usize::MAX,
            state: vec![0.0; n],
            rate: vec![0.0; n],
            rows: vec![[0.0; 4]; n],
        };
        Ok(InterfaceExponential {
            mechanics: InterfaceAcceleration::new(construction.model()?),
            position: vec![0.0; m],
            velocity: vec![0.0; m],
            force: vec![0.0; m],
            generator: vec![0.0; n * n],
            constant: vec![0.0; n],
            followers: PerSide { mechanics: follower(), actuator: follower() },
            interpolated: InputPolynomial::new(2 * m, 3),
            ahead: false,
        })
    }

    /// Writes the coupled linear system at the communication point.
    fn assemble(&mut self, rates: &OutputRates) {
        let (m, n) = (self.force.len(), self.constant.len());
        let (mobility, a) = (self.mechanics.mobility(), &self.mechanics.acceleration);
        self.generator.fill(0.0);
        for i in 0..m {
            let d = |j: usize| rates.feedthrough[i * 2 * m + j];
            let gain = |j: usize| rates.rate_gain[i * 2 * m + j];
            let mut constant = rates.rate[i];
            for j in 0..m {
                let pushed: f64 = (0..m).map(|l| d(m + l) * mobility[l * m + j]).sum();
                self.generator[i * n + j] = pushed;
                self.generator[i * n + m + j] = gain(j);
                self.generator[i * n + 2 * m + j] = gain(m + j) + d(j);
                self.generator[(2 * m + i) * n + j] = mobility[i * m + j];
                constant += d(j) * self.velocity[j] + d(m + j) * a[j];
            }
            self.generator[(m + i) * n + 2 * m + i] = 1.0;
            self.constant[i] = constant;
            self.constant[m + i] = self.velocity[i];
            self.constant[2 * m + i] = a[i];
        }
    }

    /// Brings the prediction of one side to a micro step and writes its polynomials.
    fn track(&mut self, side: Side, at: MicroStep) {
        let Follower { flow, index, state, rate, rows } = &mut self.followers[side];
        if at.index == 0 {
            flow.prepare(&self.generator, &self.constant, at.length);
            state.fill(0.0);
            rate.copy_from_slice(&self.constant);
        } else if *index == at.index {
            return;
        }
        *index = at.index;
        for (row, (value, slope)) in rows.iter_mut().zip(state.iter().zip(&*rate)) {
            *row = [*value, *slope, 0.0, 0.0];
        }
        flow.advance(state);
        flow.rate(&self.generator, &self.constant, state, rate);
        for (row, (value, slope)) in rows.iter_mut().zip(state.iter().zip(&*rate)) {
            [*row, _] = hermite([row[0], row[1]], [*value, *slope], at.length);
        }
    }
}

impl CouplingScheme for InterfaceExponential {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let m = self.force.len();
        match from {
            Side::Mechanics if sample.model.is_some() => {
                self.mechanics.receive(sent(sample.model)?);
                self.position.copy_from_slice(&sample.y[..m]);
                self.velocity.copy_from_slice(&sample.y[m..]);
                self.ahead = false;
            }
            Side::Mechanics => {
                interpolate(&self.position, &self.velocity, sample, &mut self.interpolated);
                self.ahead = true;
            }
            Side::Actuator => {
                self.force.copy_from_slice(sample.y);
                let rates = sent_rates(sample.rates)?;
                self.mechanics.find(sample.y)?;
                self.assemble(rates);
            }
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Actuator && self.ahead {
            self.interpolated.mean(at, u);
            return Ok(());
        }
        self.track(to, at);
        let (m, h) = (self.force.len(), at.length);
        let mean = |[c0, c1, c2, c3]: Cubic| c0 + h * (0.5 * c1 + h * (c2 / 3.0 + 0.25 * h * c3));
        let rows = &self.followers[to].rows;
        match to {
            Side::Mechanics => (0..m).for_each(|i| u[i] = self.force[i] + mean(rows[i])),
            Side::Actuator => {
                for i in 0..m {
                    u[i] = self.position[i] + mean(rows[m + i]);
                    u[m + i] = self.velocity[i] + mean(rows[2 * m + i]);
                }
            }
        }
        Ok(())
    }

    fn input_polynomials(&self, to: Side, at: MicroStep, polynomials: &mut [Cubic]) -> bool {
        if to == Side::Actuator && self.ahead {
            return self.interpolated.within(at, polynomials);
        }
        let (m, rows) = (self.force.len(), &self.followers[to].rows);
        let from = |base: f64, [c0, c1, c2, c3]: Cubic| [base + c0, c1, c2, c3];
        match to {
            Side::Mechanics => (0..m).for_each(|i| polynomials[i] = from(self.force[i], rows[i])),
            Side::Actuator => {
                for i in 0..m {
                    polynomials[i] = from(self.position[i], rows[m + i]);
                    polynomials[m + i] = from(self.velocity[i], rows[2 * m + i]);
                }
            }
        }
        true
    }

    fn report(&mut self) -> SchemeReport {
        self.mechanics.report()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}
