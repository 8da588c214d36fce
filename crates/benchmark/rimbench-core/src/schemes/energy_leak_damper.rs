//! `energy-leak-damper`: count the energy that the interface creates, and dissipate it in a virtual damper.
//!
//! Between the sides stands a hold. What the mechanics receives as work and what the actuator sends differ; the
//! difference accumulates in a pool. As long as the pool is positive, a damper on the interface takes it out of the
//! mechanics, never more per macro step than it holds, and never with more force than a share of the coupling force.
//!
//! ```text
//! received  Σ u_λ · ½ (w⁻ + w⁺) δ_m        sent  Σ λ_j · ½ (w_j⁻ + w_j⁺) δ        pool E ← E + received − sent
//! damper    f = −μ w(t_k),   μ = E⁺ / (H w(t_k)²),   |f| ≤ γ |λ(t_k)|           u_λ = λ(t_k) + f
//! ```
//! The work of the damper is part of what is received, so a joule taken out leaves E by itself. −E is the interface
//! residual of the energy audit, to round-off where the interface row `A_i` is constant; where it turns, the audit has
//! the row of the start of a step and the pool, which sees velocities only, that of both ends.
//! [`SchemeReport::dissipated_j`] says how much the damper took: the ledger. Where samples of the mechanics are late
//! the actuator works against where it was, and the damper, which acts at the mechanics, takes out what the macro step
//! to come will create as well: `E ← E + λ · (w − w_late) H`, `w` the velocity there. **Needs** a force–displacement
//! coupling and force return `held`, else its force would not arrive. **Order** 1 in H, that of the hold, up to a
//! logarithm (error ∝ H ln(1/H)): the force that takes a given energy out grows as the interface slows down. **Known
//! weakness**: acts after the harm is done and only on moving interfaces; a negative pool (energy lost) is not given
//! back, only counted against later gains; the bound, which keeps the explicit damper from adding energy itself,
//! decides how much it can do. **Source**: after González et al. 2019 (energy-leak monitoring and correction),
//! Rodríguez et al. 2022; deviations are in `docs/schemes/energy-leak-damper.md`.

use super::entry::{Gain, SchemeEntry};
use super::requirement::Requirement;
use crate::cosim::{CouplingScheme, MicroStep, Sample, SchemeReport, Side};
use crate::error::Failure;

/// Default of γ (ours).
const BOUND: f64 = 0.1;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        needs: vec![Requirement::ForceDisplacement, Requirement::HeldReturn],
        gain: Some(Gain {
            about: "γ, most damper force per coupling force".into(), default: BOUND, range: [0.0, 1.0]
        }),
        ..SchemeEntry::new(
            "energy-leak-damper",
            "Hold; energy created at the interface is counted and dissipated in a bounded virtual damper",
            |construction| Ok(Box::new(EnergyLeakDamper::new(construction.interface(), construction.gain))),
        )
    }
}

/// One row of the interface.
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    /// Force of the actuator, and that of the damper.
    force: f64,
    damping: f64,
    /// Velocity of the mechanics at the start of its step, whose work is still to be counted.
    velocity_before: f64,
}

#[derive(Clone)]
struct EnergyLeakDamper {
    /// γ.
    bound: f64,
    /// Position and velocity of the last sample.
    motion: Vec<f64>,
    rows: Vec<Row>,
    /// Length of the mechanics' step whose work is still to be counted, s; 0 if there is none.
    open: f64,
    /// Middle of the mechanics' last step, s: a sample from before is late.
    middle: f64,
    late: bool,
    /// What was sent up to the communication point, J.
    sent_before: f64,
    sent: f64,
    received: f64,
    dissipated: f64,
}

impl EnergyLeakDamper {
    fn new(rows: usize, bound: f64) -> Self {
        EnergyLeakDamper {
            bound,
            motion: vec![0.0; 2 * rows],
            rows: vec![Row::default(); rows],
            open: 0.0,
            middle: f64::NEG_INFINITY,
            late: false,
            sent_before: 0.0,
            sent: 0.0,
            received: 0.0,
            dissipated: 0.0,
        }
    }

    /// Sets the damper for the macro step of length `h`, which the mechanics starts with these velocities.
    fn damp(&mut self, h: f64, velocity: &[f64]) {
        // E, J: what the interface has created (above 0) or lost.
        let mut energy = self.received - self.sent;
        if self.late {
            let known = &self.motion[self.rows.len()..];
            let created =
                self.rows.iter().zip(velocity.iter().zip(known)).map(|(row, (w, known))| row.force * (w - known));
            energy = self.received - self.sent_before + h * created.sum::<f64>();
        }
        let energy = energy.max(0.0);
        let squares: f64 = velocity.iter().map(|velocity| velocity * velocity).sum();
        for (row, velocity) in self.rows.iter_mut().zip(velocity) {
            let wanted = -energy * velocity / (h * squares);
            let most = self.bound * row.force.abs();
            // Over an interface that rests, or all but rests, the quotient is no number.
            row.damping = if wanted.is_finite() { wanted.clamp(-most, most) } else { 0.0 };
        }
    }

    /// Counts the work of the mechanics' last step, now that it is known with which velocity it ended.
    #[inline]
    fn close_step(&mut self, velocities: &[f64]) {
        if self.open > 0.0 {
            for (row, velocity) in self.rows.iter().zip(velocities) {
                let way = 0.5 * (row.velocity_before + velocity) * self.open;
                self.received += (row.force + row.damping) * way;
                self.dissipated -= row.damping * way;
            }
        }
        self.open = 0.0;
    }
}

impl CouplingScheme for EnergyLeakDamper {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        match from {
            Side::Mechanics => {
                self.late = sample.time < self.middle;
                if !self.late {
                    self.close_step(&sample.y[self.rows.len()..]);
                }
                self.motion.copy_from_slice(sample.y);
            }
            Side::Actuator => {
                if !sample.y.iter().all(|force| force.is_finite()) {
                    return Err(Failure::non_finite("coupling force"));
                }
                for (row, force) in self.rows.iter_mut().zip(sample.y) {
                    row.force = *force;
                }
                self.sent_before = self.sent;
                if !self.late {
                    let motion = std::mem::take(&mut self.motion);
                    self.damp(sample.step.length, &motion[self.rows.len()..]);
                    self.motion = motion;
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        let m = self.rows.len();
        if to == Side::Mechanics {
            self.close_step(&own[m..]);
            if self.late && at.index == 0 {
                self.damp(at.length * at.count as f64, &own[m..]);
            }
            for ((row, velocity), u) in self.rows.iter_mut().zip(&own[m..]).zip(u) {
                *u = row.force + row.damping;
                row.velocity_before = *velocity;
            }
            (self.open, self.middle) = (at.length, at.start + 0.5 * at.length);
            return Ok(());
        }
        for ((force, before), now) in own.iter().zip(&u[m..]).zip(&self.motion[m..]) {
            self.sent += force * 0.5 * (before + now) * at.length;
        }
        u.copy_from_slice(&self.motion);
        Ok(())
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport { dissipated_j: Some(self.dissipated), ..SchemeReport::default() }
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}
