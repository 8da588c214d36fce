//! `c1-extrapolated-interpolation`: extrapolate to the end of the macro step, and get there without a jump or a kink.
//!
//! The line through the last two samples gives value and slope at `t_{k+1}`; a cubic joins them to the value and slope
//! that the input ended with at `t_k`. The input is continuously differentiable over the whole run, where an
//! extrapolation jumps at each communication point.
//!
//! ```text
//! p_k        line through y(t_k) and y(t_{k−1})
//! u(t)       cubic on [t_k, t_{k+1}]:  u = p_{k−1}, u̇ = ṗ_{k−1} at t_k,   u = p_k, u̇ = ṗ_k at t_{k+1}
//! ```
//! as such or its mean over each micro step.
//! **Needs** two samples; holds until it has them. **Order** 2 in H. **Known weakness**: a sample is fully
//! used only at the end of the macro step that it begins, so the input lags more than an extrapolation's, which costs
//! stability; overshoots after a kink like the extrapolation it is made from.
//! **Source**: extrapolated interpolation, Busch 2016 (continuous approximation techniques). The start is ours: with
//! the first two samples the input begins anew, with a jump.

use super::entry::SchemeEntry;
use super::input_polynomial::shifted;
use crate::cosim::{CouplingScheme, Cubic, MicroStep, PerSide, Sample, Side};
use crate::error::Failure;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 2,
        samples: 2,
        ..SchemeEntry::new(
            "c1-extrapolated-interpolation",
            "Extrapolate linearly to the end of the macro step, join by a cubic without jump or kink",
            |construction| {
                let sent = construction.ports.map(|ports| Signal::new(ports.outputs.len()));
                Ok(Box::new(ExtrapolatedInterpolation { sent }))
            },
        )
    }
}

#[derive(Clone)]
struct ExtrapolatedInterpolation {
    /// The samples that each side sends.
    sent: PerSide<Signal>,
}

impl CouplingScheme for ExtrapolatedInterpolation {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        self.sent[from].receive(sample);
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        self.sent[to.other()].evaluate(at, u);
        Ok(())
    }

    fn input_polynomials(&self, to: Side, at: MicroStep, polynomials: &mut [Cubic]) -> bool {
        let signal = &self.sent[to.other()];
        let macro_step = at.length * at.count as f64;
        for (polynomial, Variable { cubic: [c0, c1, c2, c3], .. }) in polynomials.iter_mut().zip(&signal.variables) {
            let [h, h2] = [macro_step, macro_step * macro_step];
            *polynomial = shifted([*c0, c1 / h, c2 / h2, c3 / (h * h2)], at.since_exchange);
        }
        true
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

/// One coupling variable: its last samples, newest first, and where the input ends at `t_{k+1}`.
#[derive(Debug, Clone, Copy, Default)]
struct Variable {
    y: [f64; 2],
    end: f64,
    end_slope: f64,
    start: f64,
    start_slope: f64,
    /// Of the cubic in (t − t_k)/H.
    cubic: [f64; 4],
}

/// The coupling variables that go one way.
#[derive(Clone)]
struct Signal {
    times: [f64; 2],
    count: usize,
    /// Index of the macro step that the cubic is for.
    step: usize,
    variables: Vec<Variable>,
}

impl Signal {
    fn new(width: usize) -> Self {
        Signal { times: [0.0; 2], count: 0, step: 0, variables: vec![Variable::default(); width] }
    }

    fn receive(&mut self, sample: &Sample<'_>) {
        let before = self.count;
        if before == 0 || sample.time != self.times[0] {
            self.times = [sample.time, self.times[0]];
            self.count = (self.count + 1).min(2);
            for variable in &mut self.variables {
                variable.y[1] = variable.y[0];
            }
        }
        // With the mechanics first, a second sample may come for a macro step: it moves the end, not the start.
        let new_step = sample.step.index != self.step;
        self.step = sample.step.index;
        let (length, end) = (sample.step.length, sample.step.start + sample.step.length);
        let [t0, t1] = self.times;
        for (variable, &y) in self.variables.iter_mut().zip(sample.y) {
            variable.y[0] = y;
            if new_step {
                (variable.start, variable.start_slope) = (variable.end, variable.end_slope);
            }
            let [y0, y1] = variable.y;
            let slope = if self.count > 1 { (y0 - y1) / (t0 - t1) } else { 0.0 };
            let value = |t: f64| y0 + slope * (t - t0);
            (variable.end, variable.end_slope) = (value(end), slope);
            // With one more sample the extrapolation has a higher order than that at which the input ended.
            if self.count > before {
                (variable.start, variable.start_slope) = (value(sample.step.start), slope);
            }
            let (rise, m0, m1) =
                (variable.end - variable.start, length * variable.start_slope, length * variable.end_slope);
            variable.cubic = [variable.start, m0, 3.0 * rise - 2.0 * m0 - m1, m0 + m1 - 2.0 * rise];
        }
    }

    #[inline]
    fn evaluate(&self, at: MicroStep, u: &mut [f64]) {
        // The mean over the micro step, of width 1/n in x: the value at the middle and 1/(12 n²) of half the second
        // derivative.
        let (x, bend) = ((at.index as f64 + 0.5) / at.count as f64, 1.0 / (12.0 * (at.count * at.count) as f64));
        for (u, Variable { cubic: [c0, c1, c2, c3], .. }) in u.iter_mut().zip(&self.variables) {
            *u = c0 + x * (c1 + x * (c2 + x * c3)) + bend * (c2 + 3.0 * c3 * x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::MacroStep;

    fn sample(time: f64, y: &[f64], index: usize) -> Sample<'_> {
        let step = MacroStep { index, start: index as f64, length: 1.0 };
        Sample { time, ..Sample::of_outputs(step, y, 1.0) }
    }

    /// Value of the cubic at `x` in [0, 1].
    fn at(signal: &Signal, x: f64) -> f64 {
        let [c0, c1, c2, c3] = signal.variables[0].cubic;
        c0 + x * (c1 + x * (c2 + x * c3))
    }

    #[test]
    fn a_kink_in_the_samples_is_met_as_worked_by_hand() {
        let mut signal = Signal::new(1);
        for k in 0..2 {
            signal.receive(&sample(k as f64, &[0.0], k));
            assert_eq!(signal.variables[0].cubic, [0.0; 4]);
        }
        // Then 2 at t = 2: the line through (1, 0) and (2, 2) ends at 4 with slope 2.
        signal.receive(&sample(2.0, &[2.0], 2));
        // From value 0, slope 0 to value 4, slope 2: u = 10 x² − 6 x³.
        assert_eq!(signal.variables[0].cubic, [0.0, 0.0, 10.0, -6.0]);
        let mut u = [f64::NAN];
        signal.evaluate(MicroStep::new(MacroStep { index: 2, start: 2.0, length: 1.0 }, 0, 1), &mut u);
        approx::assert_relative_eq!(u[0], 10.0 / 3.0 - 1.5, epsilon = 1e-14);
        // The next one starts where this one ended.
        signal.receive(&sample(3.0, &[2.0], 3));
        assert_eq!([at(&signal, 0.0), signal.variables[0].cubic[1], at(&signal, 1.0)], [4.0, 2.0, 2.0]);
    }

    #[test]
    fn a_line_is_reproduced_as_soon_as_there_are_two_samples() {
        let mut signal = Signal::new(1);
        for k in 0..2 {
            signal.receive(&sample(k as f64, &[1.0 + k as f64], k));
        }
        assert_eq!([0.0, 0.25, 1.0].map(|x| at(&signal, x)), [2.0, 2.25, 3.0]);
    }

    #[test]
    fn a_sample_that_comes_ahead_makes_it_an_interpolation() {
        let mut signal = Signal::new(1);
        signal.receive(&sample(0.0, &[1.0], 0));
        signal.receive(&sample(1.0, &[3.0], 0));
        assert_eq!([at(&signal, 0.0), at(&signal, 1.0)], [1.0, 3.0]);
        signal.receive(&sample(1.0, &[3.0], 1));
        signal.receive(&sample(2.0, &[3.0], 1));
        assert_eq!([at(&signal, 0.0), at(&signal, 1.0)], [3.0, 3.0]);
    }
}
