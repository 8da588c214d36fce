//! `relaxed-hold`: between the straight line through the last two samples and its mean, held.
//!
//! ```text
//! u(θ) = y_k + [a + (1 − 2a) θ] Δ        θ = (t − t_k)/H,   Δ = (y_k − y_{k−1}) H/H⁻
//! ```
//! a = 0 is the line, a = ½ its mean over the macro step, held; every value keeps the mean, and with it order 2. With the mechanics
//! first the actuator's input goes from its sample at t_k to the one at t_{k+1} in the same way.
//! **Needs** two samples. **Order** 2 in H. **Known weakness**: as any extrapolation after an impact.
//! **Source**: after the idea of Li, Yuan, Lu, Meyer, Schweizer, Arch. Appl. Mech. 2020 (extrapolation relaxed with the current and
//! the previous coupling variables). Formula not read, derived here; nothing is said about the authors' method.

use super::course::Course;
use super::entry::{Gain, SchemeEntry};
use super::extrapolation::History;
use super::line_style::{Dash, LineStyle, Marker};
use crate::cosim::{CouplingScheme, Cubic, MicroStep, PerSide, Sample, SchemeReport, Side};
use crate::error::Failure;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 2,
        samples: 2,
        gain: Some(Gain {
            about: "a: 0 the line through two samples, ½ its mean held".into(),
            default: 0.5,
            range: [-0.5, 1.0],
        }),
        line: LineStyle::new([0x3F, 0x7F, 0x5F], Dash::DashDotDot, Marker::Square),
        ..SchemeEntry::new("relaxed-hold", "Between the line through two samples and its mean, held", |construction| {
            let sent = construction.ports.map(|ports| {
                let width = ports.outputs.len();
                (History::new(width, 2), Course::new(width, 1))
            });
            Ok(Box::new(RelaxedHold { a: construction.gain, sent }))
        })
    }
}

#[derive(Clone)]
struct RelaxedHold {
    a: f64,
    /// What each side sends.
    sent: PerSide<(History, Course)>,
}

impl CouplingScheme for RelaxedHold {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let (a, (history, course)) = (self.a, &mut self.sent[from]);
        history.push(sample.time, sample.y);
        // Where the newest sample lies ahead the line already has its two ends: same rule, from the older one on.
        history.polynomials(1, sample.step.start, &mut course.rows);
        for [c0, c1, ..] in &mut course.rows {
            let rise = *c1 * sample.step.length;
            (*c0, *c1) = (*c0 + a * rise, (1.0 - 2.0 * a) * *c1);
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, _own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        self.sent[to.other()].1.mean(at, u);
        Ok(())
    }

    fn course(&self, to: Side, at: MicroStep, course: &mut [Cubic]) -> bool {
        self.sent[to.other()].1.within(at, course)
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport::default()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}
