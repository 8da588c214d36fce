//! `transmission-line`: a short elastic line between the sides, whose travel time is the macro step.
//!
//! One end of the line feels now the wave that the other end sent one travel time ago. With a travel time of H
//! everything that crosses the interface within a macro step is known when it begins: nothing is extrapolated, and the
//! line itself creates no energy.
//!
//! ```text
//! F₁(t) = c₁(t) − Z w₁(t)      c₁(t) = F₂(t − H) + Z w₂(t − H)       end 1: the mechanics
//! F₂(t) = c₂(t) + Z w₂(t)      c₂(t) = F₁(t − H) − Z w₁(t − H)       end 2: the actuator
//! ```
//! F is the push towards the mechanics. A line of stiffness k and travel time H has Z = k H, and with it a mass k H²
//! and a compliance 1/k that the system does not have.
//!
//! **How it sits on a force–displacement exchange.** The mechanics takes a force: F₁. The actuator is a source of force
//! and takes a motion, so its end of the line is a massless point on which the actuator's force λ and the line meet,
//! λ = F₂. That gives the velocity w₂ of the point, and by integration the length s₂ of the actuator:
//!
//! ```text
//! w₂ = (λ₀ − c₂) / (Z − D_w − δ D_s)      λ = λ₀ + (D_w + δ D_s) w₂      s₂⁺ = s₂ + δ w₂
//! ```
//! `D` the direct feedthrough of the actuator, solved for as the authors' components do. The waves keep their mean over
//! a macro step exactly (impulse and way arrive, late but whole) and are straight lines within it.
//!
//! **Impedance.** In the authors' tools k is a spring of the model. Here the interface is rigid and the line an
//! addition, so it must vanish with H: Z = γ √(K/H_ii), K the stiffness of the actuator and H_ii the mobility of the
//! mechanics at `t_0`. Added mass and added compliance are then in the same proportion to the system's own, and both
//! vanish with order 1. **Needs** a force–displacement coupling, force return `held`, directional derivatives of the
//! actuator (for K and D), an interface model (for H_ii, once). **Order** 1 in H. **Known weakness**: the added mass
//! and compliance; the mechanics holds F₁ over its own step with the velocity of its beginning, which is explicit: Z
//! H_ii H must stay well below 2. **Source**: transmission line modelling after Krus et al. 1990 (HOPSAN), Braun & Krus
//! 2016; deviations are in `docs/schemes/transmission-line.md`.

use super::construction::sent;
use super::entry::{Gain, SchemeEntry};
use super::requirement::Requirement;
use crate::cosim::{CouplingScheme, MicroStep, OutputRates, Sample, Side};
use crate::error::Failure;

/// Default of γ: added mass and added compliance of equal weight.
const IMPEDANCE: f64 = 1.0;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        needs: vec![
            Requirement::ForceDisplacement,
            Requirement::InterfaceModel,
            Requirement::OutputRates,
            Requirement::HeldReturn,
        ],
        gain: Some(Gain {
            about: "γ, impedance of the line over that of the system".into(),
            default: IMPEDANCE,
            range: [1e-3, 1e3],
        }),
        ..SchemeEntry::new(
            "transmission-line",
            "A line between the sides whose travel time is the macro step; waves instead of extrapolation",
            |construction| Ok(Box::new(TransmissionLine::new(construction.interface(), construction.gain))),
        )
    }
}

/// A wave over a macro step: a straight line.
#[derive(Debug, Clone, Copy, Default)]
struct Wave {
    mean: f64,
    /// From the beginning of the macro step to its end.
    rise: f64,
}

impl Wave {
    /// Value in the middle of a micro step.
    #[inline]
    fn at(self, at: MicroStep) -> f64 {
        self.mean + self.rise * ((at.index as f64 + 0.5) / at.count as f64 - 0.5)
    }
}

/// The line of one row of the interface.
#[derive(Debug, Clone, Copy, Default)]
struct Line {
    /// Z, N·s/m.
    impedance: f64,
    /// H_ii, 1/kg.
    mobility: f64,
    /// c₁ and c₂ of this macro step.
    to_mechanics: Wave,
    to_actuator: Wave,
    /// Motion of the mechanics at `t_k`, m and m/s.
    position: f64,
    velocity: f64,
    /// s₂, m.
    length: f64,
    /// Diagonal of the actuator's direct feedthrough.
    by_position: f64,
    by_velocity: f64,
    /// ∫ F₁ and ∫ (F₂ + Z w₂) since `t_k`; the latter's integrand in the first and in the latest micro step.
    force_sum: f64,
    wave_sum: f64,
    wave_first: f64,
    wave_last: f64,
}

#[derive(Clone)]
struct TransmissionLine {
    gain: f64,
    lines: Vec<Line>,
    /// `t_k`; NaN before the first sample.
    begun: f64,
    step: usize,
}

impl TransmissionLine {
    fn new(rows: usize, gain: f64) -> Self {
        TransmissionLine { gain, lines: vec![Line::default(); rows], begun: f64::NAN, step: 0 }
    }

    /// The wave sent over the last macro step arrives; `y` is the motion of the mechanics now.
    fn arrive(&mut self, y: &[f64], elapsed: f64) {
        let m = self.lines.len();
        for (i, line) in self.lines.iter_mut().enumerate() {
            let z = line.impedance;
            line.to_actuator = Wave {
                mean: (line.force_sum - z * (y[i] - line.position)) / elapsed,
                rise: -z * (y[m + i] - line.velocity),
            };
            line.to_mechanics = Wave { mean: line.wave_sum / elapsed, rise: line.wave_last - line.wave_first };
            (line.force_sum, line.wave_sum) = (0.0, 0.0);
        }
    }

    fn take_motion(&mut self, y: &[f64]) {
        let m = self.lines.len();
        for (i, line) in self.lines.iter_mut().enumerate() {
            (line.position, line.velocity) = (y[i], y[m + i]);
        }
    }

    /// Lays the line at `t_0`, loaded as if it had always been there.
    fn lay(&mut self, force: &[f64], rates: Option<&OutputRates>) -> Result<(), Failure> {
        let m = self.lines.len();
        for (i, line) in self.lines.iter_mut().enumerate() {
            let stiffness = rates
                .map_or(f64::NAN, |rates| -(rates.feedthrough[i * 2 * m + i] + rates.rate_gain[i * 2 * m + m + i]));
            // The impedance of a line is that of the system between whose sides it lies.
            if !(stiffness > 0.0 && stiffness.is_finite()) {
                return Err(Failure::out_of_range("stiffness of the actuator, which a line needs above 0,", stiffness));
            }
            line.impedance = self.gain * (stiffness / line.mobility).sqrt();
            if !(line.impedance.is_finite() && line.impedance > 0.0) {
                return Err(Failure::non_finite("impedance of the transmission line"));
            }
            let wave = |value| Wave { mean: value, rise: 0.0 };
            line.to_mechanics = wave(force[i] + line.impedance * line.velocity);
            line.to_actuator = wave(force[i] - line.impedance * line.velocity);
            line.length = line.position;
        }
        Ok(())
    }
}

impl CouplingScheme for TransmissionLine {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let (m, first) = (self.lines.len(), self.begun.is_nan());
        match from {
            Side::Mechanics if first => {
                let model = sent(sample.model)?;
                let first = model.interface_start();
                for (i, line) in self.lines.iter_mut().enumerate() {
                    line.mobility = model.entry(first + i, first + i);
                }
                self.take_motion(sample.y);
            }
            // With the mechanics first its sample comes ahead as well, and has to wait: waves travel for a macro step.
            Side::Mechanics if sample.step.index == self.step => {}
            Side::Mechanics => {
                self.arrive(sample.y, sample.step.start - self.begun);
                self.take_motion(sample.y);
                (self.step, self.begun) = (sample.step.index, sample.step.start);
            }
            Side::Actuator => {
                if first {
                    self.lay(sample.y, sample.rates)?;
                    (self.step, self.begun) = (sample.step.index, sample.step.start);
                }
                if let Some(rates) = sample.rates {
                    for (i, line) in self.lines.iter_mut().enumerate() {
                        line.by_position = rates.feedthrough[i * 2 * m + i];
                        line.by_velocity = rates.feedthrough[i * 2 * m + m + i];
                    }
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        let m = self.lines.len();
        for (i, line) in self.lines.iter_mut().enumerate() {
            let z = line.impedance;
            if to == Side::Mechanics {
                u[i] = line.to_mechanics.at(at) - z * own[m + i];
                line.force_sum += at.length * u[i];
                continue;
            }
            let wave = line.to_actuator.at(at);
            // `own` was put out under the last input: brought to length s₂ and velocity zero.
            let at_rest = own[i] + line.by_position * (line.length - u[i]) - line.by_velocity * u[m + i];
            let velocity = (at_rest - wave) / (z - line.by_velocity - at.length * line.by_position);
            line.length += at.length * velocity;
            // F₂ + Z w₂.
            line.wave_last = wave + 2.0 * z * velocity;
            if at.index == 0 {
                line.wave_first = line.wave_last;
            }
            line.wave_sum += at.length * line.wave_last;
            (u[i], u[m + i]) = (line.length, velocity);
        }
        Ok(())
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::MacroStep;

    #[test]
    fn line_and_actuator_push_equally_where_they_meet_though_the_force_follows_the_motion_at_once() {
        let at = MicroStep::new(MacroStep { index: 0, start: 0.0, length: 1.0 }, 1, 4);
        let (told, to_actuator) = ([0.25, 0.4], Wave { mean: 1.0, rise: 0.5 });
        let mut scheme = TransmissionLine::new(1, 1.0);
        let by = Line { by_position: -3.0, by_velocity: -0.5, ..Line::default() };
        scheme.lines[0] = Line { impedance: 2.0, length: 0.2, to_actuator, ..by };
        let mut u = told;
        scheme.input(Side::Actuator, at, &[5.0], &mut u).unwrap();
        let force = 5.0 - 3.0 * (u[0] - told[0]) - 0.5 * (u[1] - told[1]);
        approx::assert_relative_eq!(force, to_actuator.at(at) + 2.0 * u[1], max_relative = 1e-14);
        approx::assert_relative_eq!(u[0], 0.2 + at.length * u[1], max_relative = 1e-14);
    }
}
