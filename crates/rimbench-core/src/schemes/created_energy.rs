//! The energy that the coupling has created, counted from what the sides exchange.

use crate::error::Failure;

/// One row of the interface.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CreatedRow {
    /// Force handed to the mechanics, without the correction.
    pub(super) force: f64,
    /// Force that a scheme adds because of it.
    pub(super) correction: f64,
    /// Velocity of the mechanics at the start of its step, whose work is still to be counted.
    velocity_before: f64,
}

/// What the interface has created (above 0) or lost, J.
///
/// ```text
/// received  Σ u_λ · ½ (w⁻ + w⁺) δ_m        sent  Σ λ_j · ½ (w_j⁻ + w_j⁺) δ        E = received − sent
/// ```
/// The work of a correction is part of what is received, so a joule taken out leaves E by itself.
#[derive(Debug, Clone)]
pub(super) struct CreatedEnergy {
    pub(super) rows: Vec<CreatedRow>,
    /// Length of the mechanics' step whose work is still to be counted, s; 0 if there is none.
    open: f64,
    sent: f64,
    received: f64,
    taken_out: f64,
}

impl CreatedEnergy {
    pub(super) fn new(rows: usize) -> Self {
        CreatedEnergy { rows: vec![CreatedRow::default(); rows], open: 0.0, sent: 0.0, received: 0.0, taken_out: 0.0 }
    }

    /// E, J.
    pub(super) fn energy(&self) -> f64 {
        self.received - self.sent
    }

    /// What the corrections took out of the mechanics, J.
    pub(super) fn taken_out(&self) -> f64 {
        self.taken_out
    }

    /// Takes the actuator's force of a communication point.
    ///
    /// # Errors
    /// A coupling force that is no number.
    pub(super) fn set_force(&mut self, force: &[f64]) -> Result<(), Failure> {
        for (row, force) in self.rows.iter_mut().zip(force) {
            row.force = *force;
        }
        if self.rows.iter().all(|row| row.force.is_finite()) {
            Ok(())
        } else {
            Err(Failure::non_finite("coupling force"))
        }
    }

    /// Counts the work of the mechanics' last step, now that it is known with which velocity it ended.
    #[inline]
    pub(super) fn close_step(&mut self, velocities: &[f64]) {
        if self.open > 0.0 {
            for (row, velocity) in self.rows.iter().zip(velocities) {
                let way = 0.5 * (row.velocity_before + velocity) * self.open;
                self.received += (row.force + row.correction) * way;
                self.taken_out -= row.correction * way;
            }
        }
        self.open = 0.0;
    }

    /// A step of the mechanics begins, with the forces of the rows.
    #[inline]
    pub(super) fn open_step(&mut self, length: f64, velocities: &[f64]) {
        for (row, velocity) in self.rows.iter_mut().zip(velocities) {
            row.velocity_before = *velocity;
        }
        self.open = length;
    }

    /// A micro step of the actuator begins: it put out `force` while its input goes from one velocity to the other.
    #[inline]
    pub(super) fn send(&mut self, length: f64, force: &[f64], before: &[f64], now: &[f64]) {
        for ((force, before), now) in force.iter().zip(before).zip(now) {
            self.sent += force * 0.5 * (before + now) * length;
        }
    }
}
