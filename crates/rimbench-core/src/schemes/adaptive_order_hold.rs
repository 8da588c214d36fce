//! `adaptive-order-hold`: the order of the extrapolation that would have been right last time, per side.
//!
//! ```text
//! e_q = max over rows |P_q(t_k; y_{k−1} … y_{k−1−q}) − y_k| / scale        q = 0, 1, 2, as many as samples allow
//! q* = the least q with e_q ≤ (1 + η) min_q e_q,  η = 0.1                   u = P_q* through y_k … y_{k−q*}
//! start: an order that samples allow but cannot judge yet is taken if the one below it is best
//! jump: min_q e_q > J × the median of its last 8 values  →  only y_k is remembered, q = 0
//! ```
//! The scale of a row is its largest magnitude so far. With the mechanics first its sample ahead is the newest node of the motion's
//! polynomial, of the same order.
//! **Needs** samples. **Order** 2 in H; 3 where the signal is smooth from the start on
//! (beside a start from nothing every order is wrong by all of the signal, the hold is taken, and its error stays). **Known weakness**: one macro step late by construction; where the macro step is
//! long the order flickers, which is worse than either order alone.
//! **Source**: after the idea of Éguillon, Lacabanne, Tromeur-Dervout (F3ORNITS, arXiv 2101.09309; a polynomial order per coupling
//! variable) and Ben Khaled-El Feki et al. 2017 (CHOPtrey). Formulas not read; these, η and J are ours, and nothing is said about
//! the authors' methods.

use super::course::Course;
use super::entry::{Gain, SchemeEntry};
use super::extrapolation::History;
use super::line_style::{Dash, LineStyle, Marker};
use crate::cosim::{CouplingScheme, Cubic, MicroStep, PerSide, Sample, SchemeReport, Side};
use crate::error::Failure;

/// η: a higher order must be better by this much.
const BETTER: f64 = 0.1;
/// Values of the least error that are remembered.
const REMEMBERED: usize = 8;
/// An error this small is round-off and no jump.
const ROUND_OFF: f64 = 1e-12;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 2,
        samples: 4,
        gain: Some(Gain {
            about: "J: an error so many times its median is a jump, and the past is forgotten".into(),
            default: 10.0,
            range: [2.0, 1e6],
        }),
        line: LineStyle::new([0x1F, 0xA2, 0xB3], Dash::DashDotDot, Marker::OpenDiamond),
        ..SchemeEntry::new(
            "adaptive-order-hold",
            "Extrapolate with the order, 0 to 2, that would have been right last time",
            |construction| {
                let jump = construction.gain;
                Ok(Box::new(AdaptiveOrderHold {
                    sent: construction.ports.map(|ports| Channel::new(ports.outputs.len(), jump)),
                }))
            },
        )
    }
}

#[derive(Clone)]
struct AdaptiveOrderHold {
    sent: PerSide<Channel>,
}

/// The coupling variables that go one way.
#[derive(Clone)]
struct Channel {
    jump: f64,
    order: usize,
    history: History,
    course: Course,
    tried: Vec<Cubic>,
    scale: Vec<f64>,
    /// The last values of the least error, the newest at `next − 1`.
    errors: [f64; REMEMBERED],
    count: usize,
    next: usize,
}

impl Channel {
    fn new(width: usize, jump: f64) -> Self {
        Channel {
            jump,
            order: 0,
            history: History::new(width, 4),
            course: Course::new(width, 2),
            tried: vec![[0.0; 4]; width],
            scale: vec![0.0; width],
            errors: [0.0; REMEMBERED],
            count: 0,
            next: 0,
        }
    }

    fn receive(&mut self, sample: &Sample<'_>) {
        let known = self.history.count() > 0 && self.history.time(0) == sample.time;
        self.history.push(sample.time, sample.y);
        for (scale, y) in self.scale.iter_mut().zip(sample.y) {
            *scale = scale.max(y.abs());
        }
        // A sample that was sent ahead has been judged then.
        if !known {
            self.choose();
        }
        self.history.polynomials(self.order, sample.step.start, &mut self.course.rows);
    }

    /// Chooses the order that would have met the newest sample from those before it.
    fn choose(&mut self) {
        let before = self.history.count() - 1;
        if before == 0 {
            self.order = 0;
            return;
        }
        let mut errors = [f64::INFINITY; 3];
        for (order, error) in errors.iter_mut().enumerate().take(before.min(3)) {
            let time = self.history.time(0);
            self.history.polynomials_before(1, order, time, &mut self.tried);
            let newest = self.history.sample(0);
            let off = self.tried.iter().zip(newest).zip(&self.scale).map(|(([c0, ..], y), scale)| {
                let off = (c0 - y).abs();
                if off > 0.0 { off / scale } else { 0.0 }
            });
            *error = off.fold(0.0, f64::max);
        }
        let least = errors.into_iter().fold(f64::INFINITY, f64::min);
        if self.is_jump(least) {
            self.history.forget();
            (self.order, self.count) = (0, 0);
            return;
        }
        let judged = before.min(3);
        self.order = errors.iter().position(|error| *error <= (1.0 + BETTER) * least).unwrap_or(0);
        // While samples are few the highest order that they allow has not been judged: it gets its chance if the one below is best.
        if self.order + 1 == judged && judged < 3 {
            self.order += 1;
        }
        self.errors[self.next] = least;
        (self.next, self.count) = ((self.next + 1) % REMEMBERED, (self.count + 1).min(REMEMBERED));
    }

    /// True if an error is far beyond what was usual; while fewer than eight are known nothing is.
    fn is_jump(&self, least: f64) -> bool {
        if self.count < REMEMBERED {
            return false;
        }
        let mut sorted = self.errors;
        sorted.sort_unstable_by(f64::total_cmp);
        let median = 0.5 * (sorted[REMEMBERED / 2 - 1] + sorted[REMEMBERED / 2]);
        least > self.jump * median + ROUND_OFF
    }
}

impl CouplingScheme for AdaptiveOrderHold {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        self.sent[from].receive(sample);
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        self.sent[to.other()].course.mean(at, u);
        Ok(())
    }

    fn course(&self, to: Side, at: MicroStep, course: &mut [Cubic]) -> bool {
        self.sent[to.other()].course.within(at, course)
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport::default()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::MacroStep;

    fn fed(y: impl Fn(f64) -> f64, count: usize) -> Channel {
        let mut channel = Channel::new(1, 10.0);
        for k in 0..count {
            let step = MacroStep { index: k, start: k as f64, length: 1.0 };
            let value = [y(k as f64)];
            let sample = Sample { time: k as f64, ..Sample::of_outputs(step, &value, 1.0) };
            channel.receive(&sample);
        }
        channel
    }

    #[test]
    fn the_order_is_that_of_the_signal() {
        assert_eq!(fed(|_| 3.0, 6).order, 0);
        assert_eq!(fed(|t| 1.0 - 2.0 * t, 6).order, 1);
        assert_eq!(fed(|t| 4.0 - t + 0.5 * t * t, 6).order, 2);
    }

    #[test]
    fn a_jump_makes_it_forget_and_a_smooth_signal_does_not() {
        let smooth = |t: f64| libm::sin(0.3 * t);
        assert!(fed(smooth, 12).history.count() > 1);
        assert_eq!(fed(|t| smooth(t) + if t < 10.5 { 0.0 } else { 5.0 }, 12).history.count(), 1);
    }
}
