//! `energy-input-correction`: count the energy that the interface creates or loses, and
//! correct the force so that it comes back.
//!
//! Like `energy-leak-damper`, but signed: what was lost is given back, too.
//!
//! ```text
//! E ← E + received − sent                     as in `energy_pool`; E > 0: created
//! f_k = −α E w_k/(H w_kᵀw_k)                  |f_k| ≤ γ |λ_k|,  γ = 0.2;  0 where the interface rests
//! u_λ = λ_k + f_k                             over the macro step
//! ```
//! `received` grows by f·w·H = −αE over the macro step, as far as the velocity stays what it was.
//! **Needs** a force–displacement coupling and force return `held`: with the actuator first and its mean returned the force is not
//! the scheme's to change. **Order** 1 in H, that of the hold, up to a
//! logarithm. **Known weakness**: acts late, on moving
//! interfaces only; what an impact left in the pool is paid back over many steps in the wrong place; holds energy, not phase; books
//! the energy of the interface only.
//! **Source**: after the idea of Rodríguez, Rodríguez, Sputh, Pastorino, Naya, González, Multibody Syst. Dyn. 55 (2022) (energy
//! artefacts found from exchanged variables, removed by correcting inputs). Formula not read, derived here; nothing is said about
//! the authors' method.

use super::energy_pool::EnergyPool;
use super::entry::{Gain, SchemeEntry};
use super::line_style::{Dash, LineStyle, Marker};
use super::need::Need;
use crate::cosim::{CouplingScheme, MicroStep, Sample, SchemeReport, Side};
use crate::error::Failure;

/// γ, most correction per coupling force (ours).
const BOUND: f64 = 0.2;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        needs: vec![Need::ForceDisplacement, Need::HeldReturn],
        gain: Some(Gain {
            about: "α, the share of the energy that is corrected per macro step".into(),
            default: 1.0,
            range: [0.0, 2.0],
        }),
        line: LineStyle::new([0xA6, 0x7C, 0x00], Dash::Dotted, Marker::Plus),
        ..SchemeEntry::new(
            "energy-input-correction",
            "Hold; energy created or lost at the interface comes back through a bounded correction of the force",
            |construction| Ok(Box::new(EnergyInputCorrection::new(construction.interface(), construction.gain))),
        )
    }
}

#[derive(Clone)]
struct EnergyInputCorrection {
    alpha: f64,
    /// Position and velocity of the last sample.
    motion: Vec<f64>,
    pool: EnergyPool,
}

impl EnergyInputCorrection {
    fn new(rows: usize, alpha: f64) -> Self {
        EnergyInputCorrection { alpha, motion: vec![0.0; 2 * rows], pool: EnergyPool::new(rows) }
    }

    /// Sets the correction for the macro step of length `h`.
    fn correct(&mut self, h: f64) {
        let energy = self.pool.energy();
        let velocity = &self.motion[self.pool.rows.len()..];
        let squares: f64 = velocity.iter().map(|velocity| velocity * velocity).sum();
        for (row, velocity) in self.pool.rows.iter_mut().zip(velocity) {
            let wanted = -self.alpha * energy * velocity / (h * squares);
            let most = BOUND * row.force.abs();
            // Over an interface that rests, or all but rests, the quotient is no number.
            row.correction = if wanted.is_finite() { wanted.clamp(-most, most) } else { 0.0 };
        }
    }
}

impl CouplingScheme for EnergyInputCorrection {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        match from {
            Side::Mechanics => {
                self.pool.close_step(&sample.y[self.pool.rows.len()..]);
                self.motion.copy_from_slice(sample.y);
            }
            Side::Actuator => {
                self.pool.set_force(sample.y)?;
                self.correct(sample.step.length);
            }
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        let m = self.pool.rows.len();
        if to == Side::Mechanics {
            self.pool.close_step(&own[m..]);
            for (row, u) in self.pool.rows.iter().zip(&mut *u) {
                *u = row.force + row.correction;
            }
            self.pool.open_step(at.length, &own[m..]);
            return Ok(());
        }
        self.pool.send(at.length, own, &u[m..], &self.motion[m..]);
        u.copy_from_slice(&self.motion);
        Ok(())
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport { dissipated_j: Some(self.pool.taken_out()), ..SchemeReport::default() }
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::MacroStep;

    /// One exchange and one step of each side, H = 1; returns the force on the mechanics.
    fn macro_step(scheme: &mut EnergyInputCorrection, index: usize, w: f64, force: f64) -> f64 {
        let step = MacroStep { index, start: index as f64, length: 1.0 };
        let y = [0.0, w];
        let sample = Sample { time: step.start, y: &y, model: None, rates: None, step, actuator_micro_step: 1.0 };
        scheme.receive(Side::Mechanics, &sample).unwrap();
        scheme.receive(Side::Actuator, &Sample { y: &[force], ..sample }).unwrap();
        let at = MicroStep::new(step, 0, 1);
        let mut u = [0.0, w];
        scheme.input(Side::Actuator, at, &[force], &mut u).unwrap();
        let mut u = [force];
        scheme.input(Side::Mechanics, at, &y, &mut u).unwrap();
        u[0]
    }

    #[test]
    fn a_joule_created_is_taken_out_and_a_joule_lost_is_given_back() {
        // 4 N over a mean of 1.25 m/s is received, over 1 m/s sent: 1 J from nowhere, wanted −1/1.5 N, the bound is 0.8 N.
        let mut scheme = EnergyInputCorrection::new(1, 1.0);
        assert_eq!(macro_step(&mut scheme, 0, 1.0, 4.0), 4.0);
        approx::assert_relative_eq!(macro_step(&mut scheme, 1, 1.5, 4.0), 4.0 - 1.0 / 1.5, epsilon = 1e-14);
        let mut scheme = EnergyInputCorrection::new(1, 1.0);
        macro_step(&mut scheme, 0, 1.5, 4.0);
        // Received over 1.25, sent over 1.5: 1 J lost, wanted +1 N, the bound is 0.8 N.
        approx::assert_relative_eq!(macro_step(&mut scheme, 1, 1.0, 4.0), 4.8, epsilon = 1e-14);
    }

    #[test]
    fn an_interface_at_rest_gets_no_correction() {
        let mut scheme = EnergyInputCorrection::new(1, 1.0);
        macro_step(&mut scheme, 0, 1.0, 4.0);
        assert_eq!(macro_step(&mut scheme, 1, 0.0, 4.0), 4.0);
    }
}
