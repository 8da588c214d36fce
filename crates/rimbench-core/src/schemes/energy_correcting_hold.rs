//! A hold whose force on the mechanics is corrected by the energy that the coupling has created, shared by the schemes that are paid from it.

use super::created_energy::CreatedEnergy;
use crate::cosim::{CouplingScheme, MicroStep, Sample, SchemeReport, Side};
use crate::error::Failure;

/// How much of the created energy is corrected, and how hard.
#[derive(Debug, Clone, Copy)]
pub(super) struct Correction {
    /// α, the share of the energy that is corrected per macro step.
    pub(super) share: f64,
    /// γ, most correction per coupling force.
    pub(super) bound: f64,
    /// Whether energy that was lost is given back.
    pub(super) gives_back: bool,
}

/// Holds the last samples, and corrects the force by
///
/// ```text
/// f_k = −α E w_k/(H w_kᵀw_k),   |f_k| ≤ γ |λ_k|          E the created energy, or E⁺; 0 where the interface rests
/// ```
#[derive(Clone)]
pub(super) struct EnergyCorrectingHold {
    correction: Correction,
    /// Position and velocity of the last sample.
    motion: Vec<f64>,
    pub(super) created: CreatedEnergy,
}

impl EnergyCorrectingHold {
    pub(super) fn new(rows: usize, correction: Correction) -> Self {
        EnergyCorrectingHold { correction, motion: vec![0.0; 2 * rows], created: CreatedEnergy::new(rows) }
    }

    /// Sets the correction for the macro step of length `h`.
    fn correct(&mut self, h: f64) {
        let Correction { share, bound, gives_back } = self.correction;
        let energy = if gives_back { self.created.energy() } else { self.created.energy().max(0.0) };
        let velocity = &self.motion[self.created.rows.len()..];
        let squares: f64 = velocity.iter().map(|velocity| velocity * velocity).sum();
        for (row, velocity) in self.created.rows.iter_mut().zip(velocity) {
            let wanted = -share * energy * velocity / (h * squares);
            let most = bound * row.force.abs();
            // Over an interface that rests, or all but rests, the quotient is no number.
            row.correction = if wanted.is_finite() { wanted.clamp(-most, most) } else { 0.0 };
        }
    }
}

impl CouplingScheme for EnergyCorrectingHold {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        match from {
            Side::Mechanics => {
                self.created.close_step(&sample.y[self.created.rows.len()..]);
                self.motion.copy_from_slice(sample.y);
            }
            Side::Actuator => {
                self.created.set_force(sample.y)?;
                self.correct(sample.step.length);
            }
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        let m = self.created.rows.len();
        if to == Side::Mechanics {
            self.created.close_step(&own[m..]);
            for (row, u) in self.created.rows.iter().zip(&mut *u) {
                *u = row.force + row.correction;
            }
            self.created.open_step(at.length, &own[m..]);
            return Ok(());
        }
        self.created.send(at.length, own, &u[m..], &self.motion[m..]);
        u.copy_from_slice(&self.motion);
        Ok(())
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport { dissipated_j: Some(self.created.taken_out()), ..SchemeReport::default() }
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

/// One exchange and one step of each side, H = 1; returns the force on the mechanics.
#[cfg(test)]
pub(super) fn macro_step(scheme: &mut EnergyCorrectingHold, index: usize, w: f64, force: f64) -> f64 {
    let step = crate::cosim::MacroStep { index, start: index as f64, length: 1.0 };
    let y = [0.0, w];
    let sample = Sample::of_outputs(step, &y, 1.0);
    scheme.receive(Side::Mechanics, &sample).unwrap();
    scheme.receive(Side::Actuator, &Sample { y: &[force], ..sample }).unwrap();
    let at = MicroStep::new(step, 0, 1);
    let mut u = [0.0, w];
    scheme.input(Side::Actuator, at, &[force], &mut u).unwrap();
    assert_eq!(u, [0.0, w]);
    let mut u = [force];
    scheme.input(Side::Mechanics, at, &y, &mut u).unwrap();
    u[0]
}
