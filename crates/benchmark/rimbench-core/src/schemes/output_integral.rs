//! The integral of what a side puts out over a macro step, from what is seen at its micro steps.

use crate::cosim::OutputRates;

/// Integrals of all outputs of one side, trapezoidal in its state, exact in its input.
///
/// The output of a side with direct feedthrough at the start of a micro step still has the input of the micro step
/// before, half a micro step late: an error of first order in δ, which would pass for an error of the coupling. Where
/// `D` is known it is taken out:
///
/// ```text
/// z_j = y_j − D ū_{j−1}        ∫ y dt over micro step j = ½ δ (z_j + z_{j+1}) + δ D ū_j
/// ```
/// `ū_j` is the mean input of micro step j; at a communication point the fresh one. Without `D`: the trapezoidal rule
/// on `y`.
#[derive(Debug, Clone)]
pub(super) struct OutputIntegral {
    inputs: usize,
    /// Time of what was seen last, s; NaN before the first.
    seen_at: f64,
    /// z of then.
    seen: Vec<f64>,
    /// Since the communication point.
    pub(super) value: Vec<f64>,
    /// D, row-major.
    feedthrough: Vec<f64>,
}

impl OutputIntegral {
    /// Makes room for a side with so many outputs and inputs.
    pub(super) fn new(outputs: usize, inputs: usize) -> Self {
        OutputIntegral {
            inputs,
            seen_at: f64::NAN,
            seen: vec![0.0; outputs],
            value: vec![0.0; outputs],
            feedthrough: vec![0.0; outputs * inputs],
        }
    }

    /// Goes on to `time` (s), where the side puts out `y` with input `u`.
    #[inline]
    pub(super) fn see(&mut self, time: f64, y: &[f64], u: &[f64]) {
        let elapsed = time - self.seen_at;
        for (i, y) in y.iter().enumerate() {
            let z = y - self.answer(i, u);
            if elapsed > 0.0 {
                self.value[i] += 0.5 * elapsed * (self.seen[i] + z);
            }
            self.seen[i] = z;
        }
        self.seen_at = time;
    }

    /// Begins a micro step of `length` (s), with mean input `u`.
    #[inline]
    pub(super) fn give(&mut self, length: f64, u: &[f64]) {
        for i in 0..self.value.len() {
            self.value[i] += length * self.answer(i, u);
        }
    }

    /// Begins anew at a communication point where the side puts out `y` with input `u`; `rates` if it says how outputs
    /// move.
    pub(super) fn restart(&mut self, time: f64, y: &[f64], u: &[f64], rates: Option<&OutputRates>) {
        if let Some(rates) = rates {
            self.feedthrough.copy_from_slice(&rates.feedthrough);
        }
        self.seen_at = f64::NAN;
        self.see(time, y, u);
        self.value.fill(0.0);
    }

    /// `D u`, one row.
    #[inline]
    fn answer(&self, row: usize, u: &[f64]) -> f64 {
        self.feedthrough[row * self.inputs..(row + 1) * self.inputs].iter().zip(u).map(|(d, u)| d * u).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A damper of 2 N·s/m whose velocity is 3 t: y = −6 t, seen half a micro step late.
    #[test]
    fn direct_feedthrough_is_no_late_signal_where_it_is_known() {
        let integral = |known: bool| {
            let mut integral = OutputIntegral::new(1, 1);
            let rates = OutputRates { rate: vec![0.0], feedthrough: vec![-2.0], rate_gain: vec![0.0] };
            integral.restart(0.0, &[0.0], &[0.0], known.then_some(&rates));
            let mut late = 0.0;
            for j in 0..4 {
                let t = 0.25 * f64::from(j);
                integral.see(t, &[-2.0 * late], &[late]);
                let mean = 3.0 * (t + 0.125);
                integral.give(0.25, &[mean]);
                late = mean;
            }
            integral.see(1.0, &[-6.0], &[3.0]);
            integral.value[0]
        };
        approx::assert_relative_eq!(integral(true), -3.0, epsilon = 1e-14);
        assert!((integral(false) + 3.0).abs() > 0.1);
    }
}
