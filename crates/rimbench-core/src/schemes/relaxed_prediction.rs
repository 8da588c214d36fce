//! `relaxed-prediction`: a straight line to where the true acceleration leads, or to where the samples lead, or between.
//!
//! ```text
//! y^acc: s_k + H w_k + ½ H² a_k,  w_k + H a_k;  λ_k + H (r + D u̇) + ½ H² (R u̇ + D ü)
//! y* = γ y^acc + (1 − γ)(y_k + Δ)        Δ = (y_k − y_{k−1}) H/H⁻
//! u(θ) = y_k + θ (y* − y_k)              θ = (t − t_k)/H
//! ```
//! γ = 0 is `first-order-hold`, γ = 1 `true-acceleration` with a chord instead of its parabola. With the mechanics first the
//! actuator's line ends at the mechanics' own sample.
//! **Needs** an interface model, output rates, two samples unless γ = 1. **Order** 2 in H. **Known weakness**: that of what it is
//! made from; the chord costs four to five times the error of the parabola, at the same stability.
//! **Source**: after the idea of Li, Yuan, Lu, Meyer, Schweizer, Arch. Appl. Mech. 2020 (coupling variables predicted with constant or
//! linear acceleration of the coupling bodies, relaxed). Formula not read, derived here; nothing is said about the authors' method.

use super::construction::{Construction, sent_rates};
use super::course::Course;
use super::entry::{Gain, SchemeEntry};
use super::extrapolation::History;
use super::interface_acceleration::InterfaceAcceleration;
use super::line_style::{Dash, LineStyle, Marker};
use super::need::Need;
use super::rated_force::rated_force;
use crate::cosim::{CouplingScheme, Cubic, MicroStep, PerSide, Sample, SchemeReport, Side};
use crate::error::{Failure, Result};

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 2,
        samples: 2,
        needs: vec![Need::ForceDisplacement, Need::InterfaceModel, Need::NoFriction, Need::OutputRates],
        gain: Some(Gain {
            about: "γ: 1 where the true acceleration leads, 0 where two samples lead".into(),
            default: 1.0,
            range: [0.0, 1.0],
        }),
        line: LineStyle::new([0x8C, 0x24, 0x4C], Dash::DashDot, Marker::OpenSquare),
        ..SchemeEntry::new(
            "relaxed-prediction",
            "A line to where the true acceleration leads, relaxed towards where the samples lead",
            |construction| Ok(Box::new(RelaxedPrediction::new(construction)?)),
        )
    }
}

#[derive(Clone)]
struct RelaxedPrediction {
    gamma: f64,
    mechanics: InterfaceAcceleration,
    /// No jerk.
    rest: Vec<f64>,
    /// Force by the actuator's rates.
    rated: Vec<Cubic>,
    sent: PerSide<(History, Course)>,
}

impl RelaxedPrediction {
    fn new(construction: &Construction<'_>) -> Result<Self> {
        Ok(RelaxedPrediction {
            gamma: construction.gain,
            mechanics: InterfaceAcceleration::new(construction.model()?),
            rest: vec![0.0; construction.interface()],
            rated: vec![[0.0; 4]; construction.interface()],
            sent: construction.ports.map(|ports| {
                let width = ports.outputs.len();
                (History::new(width, 2), Course::new(width, 1))
            }),
        })
    }

    /// Moves the end of the lines through two samples towards the predictions in `ends`.
    fn bend(gamma: f64, course: &mut Course, ends: impl Iterator<Item = f64>, h: f64) {
        for ([c0, c1, ..], end) in course.rows.iter_mut().zip(ends) {
            *c1 = gamma * (end - *c0) / h + (1.0 - gamma) * *c1;
        }
    }
}

impl CouplingScheme for RelaxedPrediction {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let (history, course) = &mut self.sent[from];
        history.push(sample.time, sample.y);
        history.polynomials(1, sample.step.start, &mut course.rows);
        if from == Side::Mechanics {
            // Without a model it has been sent ahead, and the line ends where the mechanics is.
            if let Some(model) = sample.model {
                self.mechanics.receive(model);
            }
            return Ok(());
        }
        let rates = sent_rates(sample.rates)?;
        self.mechanics.find(sample.y)?;
        let (h, a) = (sample.step.length, &self.mechanics.acceleration);
        let m = a.len();
        let (of_mechanics, motion) = &mut self.sent.mechanics;
        let (s, w) = of_mechanics.sample(0).split_at(m);
        let positions = (0..m).map(|i| s[i] + h * (w[i] + 0.5 * h * a[i]));
        let velocities = (0..m).map(|i| w[i] + h * a[i]);
        Self::bend(self.gamma, motion, positions.chain(velocities), h);
        let moves = [w, &a[..], &self.rest];
        rated_force(sample.y, rates, moves, &mut self.rated);
        let ends = self.rated.iter().map(|[c0, c1, c2, _]| c0 + h * (c1 + h * c2));
        Self::bend(self.gamma, &mut self.sent.actuator.1, ends, h);
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
        self.mechanics.report()
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}
