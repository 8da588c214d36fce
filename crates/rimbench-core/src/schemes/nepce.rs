//! `nepce` and `nepce-feedthrough`: hold, and give back in this macro step what the hold got wrong in the last one.
//!
//! The side that receives a held input misses part of the integral of what the other side really did; with force and
//! velocity as coupling variables that integral is impulse and way, and its loss is energy. The next input carries the
//! missing part as a constant: with α = 1 the integrals agree, one macro step late.
//!
//! ```text
//! E_k = ∫ (y(t) − ỹ_{k−1}) dt over [t_{k−1}, t_k]        u(t) = ỹ_k + c_k,   c_k = α E_k / (t_k − t_{k−1}),   ỹ_k = y(t_k)
//! ```
//! The integral of `y` is taken by the trapezoidal rule over everything that the sending side put out: at its own micro
//! steps and at the communication points.
//!
//! `nepce-feedthrough`: an actuator with direct feedthrough `D` answers to the correction `c` of its own input at once, by
//! `D c`. The mechanics is told so at once, not a macro step later: `ỹ_k = y(t_k) + D c_k` for the actuator's outputs, and the
//! error is measured against that.
//! **Needs** two samples (nothing to correct before); `nepce-feedthrough` directional derivatives of the actuator. **Order** 2
//! in H: the mean of the input over a macro step is right to second order, its values only to first. **Known weakness**: after
//! an impact it gives back the error of a motion that is over; jumps at every communication point.
//! **Source**: Benedikt et al. 2013 (NEPCE), Sadjina & Pedersen 2019 (α, direct feedthrough). Ours: `D` from directional
//! derivatives, and that positions are corrected like forces and velocities.

use super::entry::{Gain, SchemeEntry};
use super::line_style::{Dash, LineStyle, Marker};
use super::need::Need;
use crate::cosim::{CouplingScheme, MicroStep, PerSide, Sample, SchemeReport, Side};
use crate::error::Failure;

/// α of the published method.
const ALPHA: f64 = 1.0;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 2,
        samples: 2,
        gain: Some(gain()),
        line: LineStyle::new([0x0E, 0x6E, 0x7C], Dash::Short, Marker::Triangle),
        ..SchemeEntry::new("nepce", "Hold, plus the mean error of the last macro step's hold", |construction| {
            Ok(Box::new(Nepce::new(construction.ports.map(|ports| ports.outputs.len()), construction.gain)))
        })
    }
}

pub(super) fn feedthrough() -> SchemeEntry {
    SchemeEntry {
        needs: vec![Need::OutputRates],
        line: LineStyle::new([0x45, 0xB7, 0xC4], Dash::Dashed, Marker::Triangle),
        name: "nepce-feedthrough".into(),
        about: "Hold, plus the mean error of the last macro step's hold; the actuator's direct feedthrough at once"
            .into(),
        ..entry()
    }
}

fn gain() -> Gain {
    Gain { about: "α, the share of the error that is given back".into(), default: ALPHA, range: [0.0, 2.0] }
}

/// Both schemes: which of them follows from whether the actuator's sample says how its outputs move.
#[derive(Clone)]
struct Nepce {
    /// What each side sends.
    sent: PerSide<Channel>,
}

impl Nepce {
    fn new(outputs: PerSide<usize>, alpha: f64) -> Self {
        Nepce { sent: outputs.map(|count| Channel::new(count, alpha)) }
    }
}

impl CouplingScheme for Nepce {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        self.sent[from].receive(sample);
        if let Some(rates) = sample.rates {
            let (inputs, outputs) = (&self.sent.mechanics.variables, &mut self.sent.actuator.variables);
            for (output, row) in outputs.iter_mut().zip(rates.feedthrough.chunks(inputs.len())) {
                let answer = row.iter().zip(inputs).map(|(d, input)| d * input.correction);
                output.held += answer.sum::<f64>();
            }
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        self.sent[to].see(at.start, own);
        for (u, variable) in u.iter_mut().zip(&self.sent[to.other()].variables) {
            *u = variable.held + variable.correction;
        }
        Ok(())
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport::default()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

/// One coupling variable.
#[derive(Debug, Clone, Copy, Default)]
struct Variable {
    /// What the sender put out last, and the integral since the last communication point.
    seen: f64,
    integral: f64,
    /// ỹ and c.
    held: f64,
    correction: f64,
}

/// The coupling variables that go one way.
#[derive(Clone)]
struct Channel {
    alpha: f64,
    /// Time of what was seen last, of the last communication point, and its index; NaN before the first.
    seen_at: f64,
    exchanged_at: f64,
    step: usize,
    variables: Vec<Variable>,
}

impl Channel {
    fn new(width: usize, alpha: f64) -> Self {
        let variables = vec![Variable::default(); width];
        Channel { alpha, seen_at: f64::NAN, exchanged_at: f64::NAN, step: 0, variables }
    }

    /// Goes on with the integral to `time`, where the sender puts out `y`.
    #[inline]
    fn see(&mut self, time: f64, y: &[f64]) {
        let elapsed = time - self.seen_at;
        for (variable, &y) in self.variables.iter_mut().zip(y) {
            if elapsed > 0.0 {
                variable.integral += 0.5 * elapsed * (variable.seen + y);
            }
            variable.seen = y;
        }
        self.seen_at = time;
    }

    fn receive(&mut self, sample: &Sample<'_>) {
        self.see(sample.time, sample.y);
        if sample.step.index != self.step {
            let elapsed = sample.step.start - self.exchanged_at;
            for variable in &mut self.variables {
                variable.correction = self.alpha * (variable.integral / elapsed - variable.held);
                variable.integral = 0.0;
            }
        }
        if sample.step.index != self.step || self.exchanged_at.is_nan() {
            self.step = sample.step.index;
            self.exchanged_at = sample.step.start;
        }
        for (variable, &y) in self.variables.iter_mut().zip(sample.y) {
            variable.held = y;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::{MacroStep, OutputRates};

    fn step(index: usize) -> MacroStep {
        MacroStep { index, start: index as f64, length: 1.0 }
    }

    fn sample(y: &[f64], index: usize) -> Sample<'_> {
        let time = index as f64;
        Sample { time, y, model: None, rates: None, step: step(index), actuator_micro_step: 1.0 }
    }

    fn nepce() -> Nepce {
        Nepce::new(PerSide { mechanics: 1, actuator: 1 }, 1.0)
    }

    fn input(scheme: &mut Nepce, to: Side, index: usize, own: f64) -> f64 {
        let mut u = [f64::NAN];
        scheme.input(to, MicroStep::new(step(index), 0, 1), &[own], &mut u).unwrap();
        u[0]
    }

    #[test]
    fn a_ramp_is_met_in_the_mean_from_the_second_macro_step_on() {
        // y = 2 t: the hold misses 1 on average over each macro step.
        let mut scheme = nepce();
        for k in 0..4 {
            let y = 2.0 * k as f64;
            scheme.receive(Side::Mechanics, &sample(&[y], k)).unwrap();
            scheme.receive(Side::Actuator, &sample(&[0.0], k)).unwrap();
            let expected = if k == 0 { y } else { y + 1.0 };
            assert_eq!(input(&mut scheme, Side::Actuator, k, 0.0), expected);
        }
    }

    #[test]
    fn what_is_put_out_between_samples_is_seen() {
        // The actuator's output jumps to 4 within the macro step and back: mean over the trapezoids 0–4–0 of height 4 is 2.
        let mut scheme = nepce();
        scheme.receive(Side::Mechanics, &sample(&[0.0], 0)).unwrap();
        scheme.receive(Side::Actuator, &sample(&[0.0], 0)).unwrap();
        for (j, own) in [0.0, 4.0].into_iter().enumerate() {
            let mut u = [f64::NAN];
            scheme.input(Side::Actuator, MicroStep::new(step(0), j, 2), &[own], &mut u).unwrap();
        }
        scheme.receive(Side::Mechanics, &sample(&[0.0], 1)).unwrap();
        scheme.receive(Side::Actuator, &sample(&[0.0], 1)).unwrap();
        assert_eq!(input(&mut scheme, Side::Mechanics, 1, 0.0), 2.0);
    }

    #[test]
    fn direct_feedthrough_is_answered_in_the_same_macro_step() {
        // The actuator is a damper of 3 N·s/m: F = −3 w, and w = 2 t. At t = 1 its input is corrected by 1.
        for (feedthrough, expected) in [(false, -6.0 - 3.0), (true, -6.0 - 3.0 - 3.0)] {
            let mut scheme = nepce();
            let rates = OutputRates { feedthrough: vec![-3.0], ..OutputRates::zeros(1, 1) };
            for k in 0..2 {
                let w = 2.0 * k as f64;
                scheme.receive(Side::Mechanics, &sample(&[w], k)).unwrap();
                let rates = feedthrough.then_some(&rates);
                scheme.receive(Side::Actuator, &Sample { rates, ..sample(&[-3.0 * w], k) }).unwrap();
                // The error of the hold of F over the first macro step, −3, comes on top in both.
                let force = input(&mut scheme, Side::Mechanics, k, w);
                assert_eq!(force, if k == 0 { 0.0 } else { expected });
            }
        }
    }
}
