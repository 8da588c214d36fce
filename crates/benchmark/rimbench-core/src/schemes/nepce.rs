//! `nepce` and `integral-correction-first-order`: extrapolate, and give back in this macro step what the
//! extrapolation got wrong in the last one.
//!
//! The side that receives a held input misses part of the integral of what the other side really did; with force and
//! velocity as coupling variables that integral is impulse and way, and its loss is energy. The next input carries the
//! missing part as a constant: with α = 1 the integrals agree, one macro step late.
//!
//! ```text
//! E_k = ∫ (y(t) − b_{k−1}(t)) dt over [t_{k−1}, t_k]        u(t) = b_k(t) + c_k,   c_k = α E_k / H_k
//! b_k   degree 0: ỹ_k = y(t_k);   degree 1 (`integral-correction-first-order`): the line through y(t_k) and y(t_{k−1})
//! ```
//! The error is that of the base without its correction, so that with α = 1 the integrals of the inputs add up to those
//! of the outputs, one macro step late; it is given back over the length of the macro step to come.
//!
//! The integral of `y` is that of `output_integral`, over everything that the sending side put out.
//!
//! **Needs** two samples (nothing to correct before); on the line three, and of an actuator with direct feedthrough its
//! directional derivatives. **Order** 2 in H, 3 on the line, for α = 1, and one less otherwise: the mean of the input
//! over a macro step is right to that order, its values are not. With the mechanics first its sample at t_{k+1}
//! replaces the base, and only the force is corrected. **Known weakness**: after an impact it gives back the error of a
//! motion that is over; jumps at every communication point; on the line the integral wants many micro steps, as its own
//! error δ²H must stay below H³. **Source**: after Benedikt et al. 2013 (NEPCE), Sadjina & Pedersen 2019; deviations
//! are in `docs/schemes/nepce.md`.

use super::construction::Construction;
use super::entry::{Gain, SchemeEntry};
use super::output_integral::OutputIntegral;
use super::requirement::Requirement;
use crate::cosim::{CouplingScheme, Cubic, MicroStep, PerSide, Sample, Side};
use crate::error::Failure;

/// α of the published method.
const ALPHA: f64 = 1.0;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 2,
        samples: 2,
        gain: Some(gain()),
        ..SchemeEntry::new("nepce", "Hold, plus the mean error of the last macro step's hold", |construction| {
            Ok(Nepce::boxed(construction, 0))
        })
    }
}

pub(super) fn first_order() -> SchemeEntry {
    SchemeEntry {
        order: 3,
        samples: 3,
        needs: vec![Requirement::OutputRatesIfFeedthrough],
        gain: Some(gain()),
        ..SchemeEntry::new(
            "integral-correction-first-order",
            "nepce on a first-order base: linear extrapolation, plus the mean error of the last macro step's",
            |construction| Ok(Nepce::boxed(construction, 1)),
        )
    }
}

fn gain() -> Gain {
    Gain { about: "α, the share of the error that is given back".into(), default: ALPHA, range: [0.0, 2.0] }
}

#[derive(Clone)]
struct Nepce {
    /// The samples that each side sends.
    sent: PerSide<Channel>,
    /// Input that goes with a sample.
    fresh: Vec<f64>,
}

impl Nepce {
    fn new(outputs: PerSide<usize>, degree: usize, alpha: f64) -> Self {
        let PerSide { mechanics, actuator } = outputs;
        let sent = PerSide {
            mechanics: Channel::new(mechanics, actuator, degree, alpha),
            actuator: Channel::new(actuator, mechanics, degree, alpha),
        };
        Nepce { sent, fresh: Vec::with_capacity(mechanics.max(actuator)) }
    }

    fn boxed(construction: &Construction<'_>, degree: usize) -> Box<dyn CouplingScheme> {
        let outputs = construction.ports.map(|ports| ports.outputs.len());
        Box::new(Nepce::new(outputs, degree, construction.gain))
    }
}

impl CouplingScheme for Nepce {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let (own, other) = self.sent.split_mut(from);
        // The input that goes with the sample is the fresh one of the other side, if it has been seen yet.
        self.fresh.clear();
        self.fresh.extend(other.variables.iter().map(|variable| variable.sample));
        own.receive(sample, &self.fresh);
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        self.sent[to].integral.see(at.start, own, u);
        let middle = at.since_exchange + 0.5 * at.length;
        for (u, variable) in u.iter_mut().zip(&self.sent[to.other()].variables) {
            *u = variable.held + middle * variable.slope + variable.correction;
        }
        self.sent[to].integral.give(at.length, u);
        Ok(())
    }

    fn input_polynomials(&self, to: Side, at: MicroStep, polynomials: &mut [Cubic]) -> bool {
        for (row, variable) in polynomials.iter_mut().zip(&self.sent[to.other()].variables) {
            let start = variable.held + at.since_exchange * variable.slope + variable.correction;
            *row = [start, variable.slope, 0.0, 0.0];
        }
        true
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

/// One coupling variable.
#[derive(Debug, Clone, Copy, Default)]
struct Variable {
    /// The sample of the last communication point.
    sample: f64,
    /// Base at t_k, its slope, and c.
    held: f64,
    slope: f64,
    correction: f64,
}

/// The coupling variables that go one way.
#[derive(Clone)]
struct Channel {
    degree: usize,
    alpha: f64,
    /// Of the last communication point, s; NaN before the first.
    exchanged_at: f64,
    integral: OutputIntegral,
    variables: Vec<Variable>,
}

impl Channel {
    fn new(outputs: usize, inputs: usize, degree: usize, alpha: f64) -> Self {
        let variables = vec![Variable::default(); outputs];
        Channel { degree, alpha, exchanged_at: f64::NAN, integral: OutputIntegral::new(outputs, inputs), variables }
    }

    /// Takes a sample; `u` is the fresh input that goes with it.
    fn receive(&mut self, sample: &Sample<'_>, u: &[f64]) {
        if sample.time > sample.step.start {
            return self.receive_ahead(sample);
        }
        let first = self.exchanged_at.is_nan();
        let elapsed = sample.step.start - self.exchanged_at;
        self.integral.see(sample.time, sample.y, u);
        for ((variable, integral), &y) in self.variables.iter_mut().zip(&self.integral.value).zip(sample.y) {
            if !first {
                let base = elapsed * (variable.held + 0.5 * elapsed * variable.slope);
                variable.correction = self.alpha * (integral - base) / sample.step.length;
                variable.slope = if self.degree > 0 { (y - variable.sample) / elapsed } else { 0.0 };
            }
            (variable.sample, variable.held) = (y, y);
        }
        self.integral.restart(sample.time, sample.y, u, sample.rates);
        self.exchanged_at = sample.step.start;
    }

    /// A sample of the end of the macro step makes an interpolation: nothing of it is an error.
    fn receive_ahead(&mut self, sample: &Sample<'_>) {
        let h = sample.step.length;
        for (variable, &y) in self.variables.iter_mut().zip(sample.y) {
            variable.correction = 0.0;
            (variable.held, variable.slope) =
                if self.degree > 0 { (variable.sample, (y - variable.sample) / h) } else { (y, 0.0) };
        }
    }
}
