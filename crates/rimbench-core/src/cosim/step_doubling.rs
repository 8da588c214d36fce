//! Step doubling: each macro step is tried whole and in halves, on copies, before it counts.

use super::communication_grid::MacroStep;
use super::coupled_pair::{CoupledPair, Interval};
use super::macro_loop::{CommunicationPoint, End, Run};
use super::pace::following;
use super::step_control::StepRule;
use crate::error::Failure;

/// Aim a little below the tolerance.
const SAFETY: f64 = 0.9;
/// Least and greatest ratio of one macro step to the one before.
const CHANGE: [f64; 2] = [0.2, 2.0];

/// Some macro steps in a row, taken on a copy.
struct Cover<'a> {
    /// The pair at the communication point of each step, after the exchange.
    points: Vec<CoupledPair<'a>>,
    /// The pair at the end, or where it failed.
    pair: CoupledPair<'a>,
    result: Result<(), Failure>,
}

impl<'a> CoupledPair<'a> {
    fn cover(&self, intervals: &[Interval]) -> Result<Cover<'a>, Failure> {
        let mut cover = Cover { points: Vec::with_capacity(intervals.len()), pair: self.try_clone()?, result: Ok(()) };
        for interval in intervals {
            cover.result = cover.pair.exchange(interval.step);
            if cover.result.is_ok() {
                cover.points.push(cover.pair.try_clone()?);
                cover.result = cover.pair.advance(*interval);
            }
            if cover.result.is_err() {
                break;
            }
        }
        Ok(cover)
    }

    /// Largest difference of the outputs of two pairs at the same time, in units of their sizes.
    fn distance(&self, other: &Self) -> Result<f64, Failure> {
        let (mut own, mut other) = (self.try_clone()?, other.try_clone()?);
        for pair in [&mut own, &mut other] {
            pair.evaluate_outputs(false);
            pair.note_sizes();
        }
        let outputs = |pair: &Self| [&pair.y_mechanics[..], &pair.y_actuator].concat();
        let sizes = |pair: &Self| [&pair.size_mechanics[..], &pair.size_actuator].concat();
        let differences = outputs(&own).into_iter().zip(outputs(&other)).map(|(a, b)| (a - b).abs());
        let largest = sizes(&own).into_iter().zip(sizes(&other)).map(|(a, b)| a.max(b));
        // A difference that is not a number must not pass for a small one.
        Ok(differences
            .zip(largest)
            .map(|(difference, size)| difference / size)
            .fold(0.0, |worst, value| if value > worst || value.is_nan() { value } else { worst }))
    }
}

impl<'a> Run<'a> {
    /// The algorithm with step doubling. Two steps of H/2 count, and both their communication points are shown; one step
    /// of H is only there to be compared with.
    ///
    /// ```text
    /// ε = max |y(H) − y(H/2 + H/2)| / (tolerance · size)        over the outputs of both sides at the end of the step
    /// ε ≤ 1: accepted;  else, or if a step fails: taken back and tried with a smaller H
    /// H ← 0.9 H ε^(−1/(p+1))                                    held within [0.2, 2] H and [shortest, longest]
    /// ```
    /// The size of an output is its largest magnitude so far. The latency of a macro step is that of a try.
    /// # Source
    /// Textbook (Hairer, Nørsett, Wanner I, II.4), without the local extrapolation.
    pub(super) fn doubled_steps(
        &mut self,
        rule: StepRule,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) -> Result<End, Failure> {
        let (grid, exponent) = (self.pair.setup.grid, -1.0 / f64::from(rule.order + 1));
        let (mut length, mut index, mut start) = (grid.step(0).length, 0, 0.0);
        while let Some(Interval { step, end }) = following(index, start, length, grid.duration()) {
            if self.stopwatch.expired() {
                return Ok(End::Overdue);
            }
            self.stopwatch.begin();
            let half = 0.5 * step.length;
            let first = MacroStep { length: half, ..step };
            let second = MacroStep { index: index + 1, start: start + half, length: end - (start + half) };
            let halves =
                self.pair.cover(&[Interval { step: first, end: second.start }, Interval { step: second, end }])?;
            let whole = self.pair.cover(&[Interval { step, end }])?;
            let before = self.pair.work();
            let failed = whole.result.and(halves.result);
            let error = match failed {
                Ok(()) => whole.pair.distance(&halves.pair)? / rule.tolerance,
                Err(_) => f64::INFINITY,
            };
            let shortest = step.length <= rule.shortest * (1.0 + 1e-9);
            let change = (SAFETY * error.powf(exponent)).clamp(CHANGE[0], CHANGE[1]);
            // What is not a number asks for the smallest step.
            let change = if change.is_nan() { CHANGE[0] } else { change };
            length = (step.length * change).clamp(rule.shortest, grid.macro_step());
            if error <= 1.0 || (shortest && failed.is_ok()) {
                for (mut point, step) in halves.points.into_iter().zip([first, second]) {
                    std::mem::swap(&mut self.pair, &mut point);
                    self.note(step, observe);
                }
                self.pair = halves.pair;
                self.pair.note_sizes();
                (index, start) = (index + 2, end);
            } else if shortest {
                // It fails in any case: leave the run where it stood, with the point shown and the attempt counted.
                self.pair.exchange(step)?;
                self.note(step, observe);
                self.pair.book_discarded(halves.pair.work().since(&before));
                self.pair.book_discarded(whole.pair.work().since(&before));
                failed?;
            } else {
                self.pair.book_discarded(halves.pair.work().since(&before));
            }
            self.pair.book_discarded(whole.pair.work().since(&before));
            self.stopwatch.end();
        }
        self.finish(MacroStep { index, start, length }, observe)
    }
}
