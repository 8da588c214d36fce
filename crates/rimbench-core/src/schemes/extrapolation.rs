//! Polynomial extrapolation through the last communication points, shared by the holds of order 0, 1 and 2, and the force of
//! `predicted-acceleration`.

use crate::cosim::{CouplingScheme, MicroStep, PerSide, Ports, Sample, SchemeReport, Side};
use crate::error::Failure;

/// Extrapolates the inputs of both sides with a polynomial of fixed degree.
///
/// ```text
/// u(t) = Σ_j y(t_{k−j}) L_j(t),   j = 0 … n,   L_j the Lagrange polynomials of t_k, …, t_{k−n}
/// ```
/// evaluated at the middle of each micro step, so that a held micro step carries the mean of a straight line. The
/// points need not be equidistant (phase, last step). Until n+1 samples have arrived the degree is what they allow.
#[derive(Clone)]
pub(super) struct Extrapolation {
    degree: usize,
    /// What each side sends.
    sent: PerSide<History>,
}

impl Extrapolation {
    pub(super) fn new(degree: usize, ports: PerSide<&Ports>) -> Self {
        Extrapolation { degree, sent: ports.map(|ports| History::new(ports.outputs.len(), degree + 1)) }
    }

    pub(super) fn boxed(degree: usize, ports: PerSide<&Ports>) -> Box<dyn CouplingScheme> {
        Box::new(Self::new(degree, ports))
    }
}

impl CouplingScheme for Extrapolation {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        self.sent[from].push(sample.time, sample.y);
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        self.sent[to.other()].evaluate(self.degree, at.middle(), u);
        Ok(())
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport::default()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

/// The last samples, newest first, in buffers of fixed size.
#[derive(Clone)]
pub(super) struct History {
    width: usize,
    times: [f64; 3],
    values: Vec<f64>,
    capacity: usize,
    count: usize,
}

impl History {
    pub(super) fn new(width: usize, capacity: usize) -> Self {
        debug_assert!(capacity <= 3);
        History { width, times: [0.0; 3], values: vec![0.0; width * capacity], capacity, count: 0 }
    }

    /// Takes a sample; one at the time of the newest replaces it.
    pub(super) fn push(&mut self, time: f64, y: &[f64]) {
        if self.count == 0 || time != self.times[0] {
            self.times.copy_within(0..2, 1);
            self.values.copy_within(0..self.width * (self.capacity - 1), self.width);
            self.count = (self.count + 1).min(self.capacity);
        }
        self.times[0] = time;
        self.values[..self.width].copy_from_slice(y);
    }

    #[inline]
    pub(super) fn evaluate(&self, degree: usize, t: f64, u: &mut [f64]) {
        let points = self.count.min(degree + 1);
        let sample = |j: usize| &self.values[j * self.width..(j + 1) * self.width];
        if points <= 1 {
            u.copy_from_slice(sample(0));
            return;
        }
        u.fill(0.0);
        for j in 0..points {
            let weight: f64 = (0..points)
                .filter(|&i| i != j)
                .map(|i| (t - self.times[i]) / (self.times[j] - self.times[i]))
                .product();
            for (u, y) in u.iter_mut().zip(sample(j)) {
                *u += weight * y;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_up_to_the_degree_are_reproduced_on_uneven_points() {
        for degree in 0..3 {
            let f = |t: f64| (0..=degree).map(|power| (power as f64 + 1.0) * t.powi(power)).sum::<f64>();
            let mut history = History::new(1, degree as usize + 1);
            for t in [0.0, 0.3, 1.0, 1.1] {
                history.push(t, &[f(t)]);
            }
            let mut u = [0.0];
            history.evaluate(degree as usize, 1.7, &mut u);
            approx::assert_relative_eq!(u[0], f(1.7), epsilon = 1e-12);
        }
    }

    #[test]
    fn start_up_uses_what_is_there_and_a_repeated_time_replaces() {
        let mut history = History::new(1, 3);
        let mut u = [0.0];
        history.push(0.0, &[1.0]);
        history.evaluate(2, 5.0, &mut u);
        assert_eq!(u, [1.0]);
        history.push(1.0, &[9.0]);
        history.push(1.0, &[3.0]);
        history.evaluate(2, 2.0, &mut u);
        assert_eq!(u, [5.0]);
    }
}
