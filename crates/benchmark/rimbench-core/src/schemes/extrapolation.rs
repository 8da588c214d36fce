//! Polynomial extrapolation through the last communication points, shared by the holds of order 0, 1 and 2.

use super::input_polynomial::InputPolynomial;
use crate::cosim::{CouplingScheme, Cubic, MicroStep, PerSide, Ports, Sample, Side};
use crate::error::Failure;

/// Extrapolates the inputs of both sides with a polynomial of fixed degree.
///
/// ```text
/// u(t) = Σ_j y(t_{k−j}) L_j(t),   j = 0 … n,   L_j the Lagrange polynomials of t_k, …, t_{k−n}
/// ```
/// A subsystem that integrates polynomials is given this one; others the mean over each micro step. With the mechanics
/// first its sample at t_{k+1} is the newest node of its polynomial, which then interpolates. The points need not be
/// equidistant (phase, last step). Until n+1 samples have arrived the degree is what they allow.
#[derive(Clone)]
pub(super) struct Extrapolation {
    degree: usize,
    /// The samples that each side sends.
    sent: PerSide<(History, InputPolynomial)>,
}

impl Extrapolation {
    pub(super) fn boxed(degree: usize, ports: PerSide<&Ports>) -> Box<dyn CouplingScheme> {
        let sent = ports.map(|ports| {
            let width = ports.outputs.len();
            (History::new(width, degree + 1), InputPolynomial::new(width, degree))
        });
        Box::new(Extrapolation { degree, sent })
    }
}

impl CouplingScheme for Extrapolation {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let (history, polynomials) = &mut self.sent[from];
        history.push(sample.time, sample.y);
        history.polynomials(self.degree, sample.step.start, &mut polynomials.rows);
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        self.sent[to.other()].1.mean(at, u);
        Ok(())
    }

    fn input_polynomials(&self, to: Side, at: MicroStep, polynomials: &mut [Cubic]) -> bool {
        self.sent[to.other()].1.within(at, polynomials)
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

/// The last samples, newest first, in buffers of fixed size.
#[derive(Clone)]
struct History {
    width: usize,
    times: [f64; MOST],
    values: Vec<f64>,
    capacity: usize,
    count: usize,
}

/// Most samples that are kept.
const MOST: usize = 3;

impl History {
    fn new(width: usize, capacity: usize) -> Self {
        debug_assert!((1..=MOST).contains(&capacity));
        History { width, times: [0.0; MOST], values: vec![0.0; width * capacity], capacity, count: 0 }
    }

    /// Takes a sample; one at the time of the newest replaces it.
    fn push(&mut self, time: f64, y: &[f64]) {
        if self.count == 0 || time != self.times[0] {
            self.times.copy_within(0..MOST - 1, 1);
            if self.capacity > 1 {
                self.values.copy_within(0..self.width * (self.capacity - 1), self.width);
            }
            self.count = (self.count + 1).min(self.capacity);
        }
        self.times[0] = time;
        self.values[..self.width].copy_from_slice(y);
    }

    /// Sample `j`; 0 is the newest.
    fn sample(&self, j: usize) -> &[f64] {
        &self.values[j * self.width..(j + 1) * self.width]
    }

    /// Writes the polynomials of `degree` (0 to 2) through the newest samples, in the time since `origin` (s).
    ///
    /// ```text
    /// y₀ + d₁ (t − t₀) + d₂ (t − t₀)(t − t₁)        d: divided differences
    /// ```
    fn polynomials(&self, degree: usize, origin: f64, rows: &mut [Cubic]) {
        let points = self.count.min(degree + 1);
        let at = |j: usize| self.times[j] - origin;
        for (i, row) in rows.iter_mut().enumerate() {
            *row = [self.sample(0)[i], 0.0, 0.0, 0.0];
            if points < 2 {
                continue;
            }
            let slope = |j: usize| (self.sample(j)[i] - self.sample(j + 1)[i]) / (at(j) - at(j + 1));
            let d1 = slope(0);
            let d2 = if points > 2 { (d1 - slope(1)) / (at(0) - at(2)) } else { 0.0 };
            *row = [row[0] - d1 * at(0) + d2 * at(0) * at(1), d1 - d2 * (at(0) + at(1)), d2, 0.0];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(history: &History, degree: usize, t: f64) -> f64 {
        let mut rows = [[0.0; 4]];
        history.polynomials(degree, 0.25, &mut rows);
        let [c0, c1, c2, _] = rows[0];
        let tau = t - 0.25;
        c0 + tau * (c1 + tau * c2)
    }

    #[test]
    fn polynomials_up_to_the_degree_are_reproduced_on_uneven_points() {
        for degree in 0..3 {
            let f = |t: f64| (0..=degree).map(|power| (power as f64 + 1.0) * t.powi(power)).sum::<f64>();
            let mut history = History::new(1, degree as usize + 1);
            for t in [0.0, 0.3, 1.0, 1.1] {
                history.push(t, &[f(t)]);
            }
            approx::assert_relative_eq!(value(&history, degree as usize, 1.7), f(1.7), epsilon = 1e-12);
        }
    }

    #[test]
    fn start_up_uses_what_is_there_and_a_repeated_time_replaces() {
        let mut history = History::new(1, 3);
        history.push(0.0, &[1.0]);
        assert_eq!(value(&history, 2, 5.0), 1.0);
        history.push(1.0, &[2.0]);
        history.push(1.0, &[3.0]);
        assert_eq!(value(&history, 2, 2.0), 5.0);
    }
}
