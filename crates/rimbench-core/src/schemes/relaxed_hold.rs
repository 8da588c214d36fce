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

use super::entry::{Gain, SchemeEntry};
use super::extrapolation::Extrapolation;
use super::line_style::{Dash, LineStyle, Marker};
use crate::cosim::{CouplingScheme, Cubic, MicroStep, Sample, SchemeReport, Side};
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
        line: LineStyle::new([0x3C, 0x81, 0x65], Dash::DashDotDot, Marker::Square),
        ..SchemeEntry::new("relaxed-hold", "Between the line through two samples and its mean, held", |construction| {
            Ok(Box::new(RelaxedHold { a: construction.gain, line: Extrapolation::new(1, construction.ports) }))
        })
    }
}

#[derive(Clone)]
struct RelaxedHold {
    a: f64,
    line: Extrapolation,
}

impl CouplingScheme for RelaxedHold {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        // Where the newest sample lies ahead the line already has its two ends: same rule, from the older one on.
        self.line.receive(from, sample)?;
        let a = self.a;
        for [c0, c1, ..] in self.line.sent_by(from) {
            let rise = *c1 * sample.step.length;
            (*c0, *c1) = (*c0 + a * rise, (1.0 - 2.0 * a) * *c1);
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        self.line.input(to, at, own, u)
    }

    fn course(&self, to: Side, at: MicroStep, course: &mut [Cubic]) -> bool {
        self.line.course(to, at, course)
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport::default()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}
