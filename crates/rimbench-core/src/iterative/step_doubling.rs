//! Step doubling: each macro step is tried whole and in halves, on copies, before it counts.

use super::copied_pair::CopiedPair;
use super::driver::{IterativeDriver, StepDoubling};
use crate::cosim::{CommunicationPoint, End, Log, MacroInterval, MacroStep, Side, finish, following};
use crate::error::{Cause, Failure};

/// Aim a little below the tolerance.
const SAFETY: f64 = 0.9;
/// Least and greatest ratio of one macro step to the one before.
const CHANGE: [f64; 2] = [0.2, 2.0];

/// Some macro steps in a row, taken on a copy.
struct Cover<'a> {
    /// The pair at the communication point of each step, after the exchange, and the scheme's effective mass in the step.
    points: Vec<(CopiedPair<'a>, Option<f64>)>,
    /// The pair at the end, or where it failed.
    pair: CopiedPair<'a>,
    result: Result<(), Failure>,
}

impl IterativeDriver {
    /// Takes macro steps on a copy. The effective masses of all but a last step that failed are known then.
    fn try_steps<'a>(self, from: &CopiedPair<'a>, intervals: &[MacroInterval]) -> Result<Cover<'a>, Failure> {
        let mut cover = Cover { points: Vec::with_capacity(intervals.len()), pair: from.try_clone()?, result: Ok(()) };
        for &interval in intervals {
            cover.result = cover.pair.lend().exchange(interval.step);
            if cover.result.is_ok() {
                let point = cover.pair.try_clone()?;
                cover.result = self.cover(&mut cover.pair, interval);
                cover.points.push((point, cover.pair.lend().scheme.report().effective_mass));
            }
            if cover.result.is_err() {
                break;
            }
        }
        if cover.result.as_ref().is_err_and(Failure::is_stop) { Err(Cause::Stopped.into()) } else { Ok(cover) }
    }

    /// Runs the algorithm with step doubling. Two steps of H/2 count, and both their communication points are shown; one step
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
        self,
        StepDoubling { rule, order }: StepDoubling,
        pair: &mut CopiedPair<'_>,
        log: &mut Log,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) -> Result<End, Failure> {
        let (grid, exponent) = (pair.setup.grid, -1.0 / f64::from(order + 1));
        let (mut length, mut index, mut start) = (grid.step(0).length, 0, 0.0);
        // The effective mass of the last macro step belongs to the communication point before.
        let mut effective_mass = None;
        while let Some(MacroInterval { step, end }) = following(index, start, length, grid.duration()) {
            if log.stopwatch.expired() {
                return Ok(End::Overdue);
            }
            log.stopwatch.begin();
            let half = 0.5 * step.length;
            let first = MacroStep { length: half, ..step };
            let second = MacroStep { index: index + 1, start: start + half, length: end - (start + half) };
            let in_halves = [MacroInterval { step: first, end: second.start }, MacroInterval { step: second, end }];
            let mut halves = self.try_steps(pair, &in_halves)?;
            let mut whole = self.try_steps(pair, &[MacroInterval { step, end }])?;
            let before = pair.work();
            let failed = whole.result.clone().and(halves.result.clone());
            let error = match failed {
                Ok(()) => whole.pair.distance(&halves.pair)? / rule.tolerance,
                Err(_) => f64::INFINITY,
            };
            let shortest = step.length <= rule.shortest * (1.0 + 1e-9);
            let change = (SAFETY * libm::pow(error, exponent)).clamp(CHANGE[0], CHANGE[1]);
            // What is not a number asks for the smallest step.
            let change = if change.is_nan() { CHANGE[0] } else { change };
            length = (step.length * change).clamp(rule.shortest, grid.macro_step());
            if error <= 1.0 || (shortest && failed.is_ok()) {
                for ((mut point, mass), step) in halves.points.into_iter().zip([first, second]) {
                    log.note(&mut point.lend(), step, effective_mass, observe);
                    effective_mass = mass;
                }
                *pair = halves.pair;
                pair.record_sizes();
                (index, start) = (index + 2, end);
            } else if shortest {
                // It fails in any case: leave the run where it stood, with the point shown and the attempt counted.
                pair.lend().exchange(step)?;
                log.note(&mut pair.lend(), step, effective_mass, observe);
                pair.book_discarded(halves.pair.work().since(&before));
                pair.book_discarded(whole.pair.work().since(&before));
                failed?;
            } else {
                pair.book_discarded(halves.pair.work().since(&before));
            }
            pair.book_discarded(whole.pair.work().since(&before));
            log.stopwatch.end();
        }
        finish(&mut pair.lend(), log, MacroStep { index, start, length }, effective_mass, observe)
    }
}

impl CopiedPair<'_> {
    /// Largest difference of the outputs of two pairs at one time, in units of their sizes.
    fn distance(&self, other: &Self) -> Result<f64, Failure> {
        let (mut own, mut other) = (self.try_clone()?, other.try_clone()?);
        for pair in [&mut own, &mut other] {
            pair.lend().evaluate_outputs()?;
            pair.record_sizes();
        }
        let pairs = Side::BOTH.into_iter().flat_map(|side| {
            let outputs = own.state.y[side].iter().zip(&other.state.y[side]);
            let sizes = own.sizes[side].iter().zip(&other.sizes[side]);
            outputs.zip(sizes).map(|((a, b), (size, other))| (a - b).abs() / size.max(*other))
        });
        // A difference that is not a number must not pass for a small one.
        Ok(pairs.fold(0.0, |worst, value| if value > worst || value.is_nan() { value } else { worst }))
    }
}
