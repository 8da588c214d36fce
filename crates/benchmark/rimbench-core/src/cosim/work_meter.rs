//! Counts the work that the actuator sends across the interface.

use super::ports::{Port, Ports, Quantity};
use super::subsystem::Sides;

/// Tells whether both sides count the work across their interface, so that there is a residual.
pub fn counts_interface_work(sides: Sides<'_>) -> bool {
    WorkMeter::new(sides.actuator.ports()).sent().is_some() && sides.mechanics.capabilities().interface_work().is_some()
}

/// Counts the work that an actuator sends, `Σ δ F · w` over its steps and the rows of its interface, J.
#[derive(Debug, Clone)]
pub struct WorkMeter {
    /// Pairs (force output, velocity input) of the actuator that belong to one interface row.
    ports: Vec<(usize, usize)>,
    /// Whether they are the first output and the second input, as with one row, the most frequent number.
    one_row: bool,
    sent: f64,
}

impl WorkMeter {
    /// Counts from 0 for ports whose forces and velocities are as many; others have no account.
    pub fn new(actuator: &Ports) -> Self {
        let of = |ports: &[Port], quantity| -> Vec<usize> {
            (0..ports.len()).filter(|&index| ports[index].quantity == quantity).collect()
        };
        let (forces, velocities) = (of(&actuator.outputs, Quantity::Force), of(&actuator.inputs, Quantity::Velocity));
        let fit = forces.len() == velocities.len();
        let ports: Vec<_> = if fit { forces.into_iter().zip(velocities).collect() } else { Vec::new() };
        WorkMeter { one_row: ports == [(0, 1)], ports, sent: 0.0 }
    }

    /// Counts some rows only.
    pub(crate) fn of_rows(actuator: &Ports, rows: &[usize]) -> Self {
        let mut meter = WorkMeter::new(actuator);
        if !meter.ports.is_empty() {
            meter.ports = rows.iter().map(|&row| meter.ports[row]).collect();
        }
        meter
    }

    /// Adds `δ Σ F · w` over the interface rows.
    #[inline]
    pub(crate) fn add_step(&mut self, length: f64, outputs: &[f64], inputs: &[f64]) {
        self.sent += length * self.power(outputs, inputs);
    }

    /// Adds `½ δ Σ F · w` over the interface rows.
    #[inline]
    pub fn add_half_step(&mut self, length: f64, outputs: &[f64], inputs: &[f64]) {
        self.sent += 0.5 * length * self.power(outputs, inputs);
    }

    /// Returns `F · w` of each interface row, W.
    #[inline]
    pub(crate) fn powers(&self, forces: &[f64], motion: &[f64]) -> impl Iterator<Item = f64> {
        self.ports.iter().map(|&(force, velocity)| forces[force] * motion[velocity])
    }

    /// Returns `Σ F · w` over the interface rows, W.
    #[inline]
    fn power(&self, forces: &[f64], motion: &[f64]) -> f64 {
        if self.one_row { forces[0] * motion[1] } else { self.powers(forces, motion).sum() }
    }

    /// Returns the work sent so far, J; none where there is no account.
    #[inline]
    pub fn sent(&self) -> Option<f64> {
        (!self.ports.is_empty()).then_some(self.sent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_work_of_a_step_is_that_of_its_halves_over_all_rows() {
        let port = |quantity| Port::new("row", quantity);
        for (rows, work) in [(1, 6.0), (2, 7.0)] {
            let mut inputs = vec![port(Quantity::Position); rows];
            inputs.resize(2 * rows, port(Quantity::Velocity));
            let mut meter =
                WorkMeter::new(&Ports { inputs, outputs: vec![port(Quantity::Force); rows], direct_feedthrough: true });
            let (forces, motion) = ([3.0, 1.0], [[9.0, 4.0, 0.0, 0.0], [9.0, 9.0, 4.0, 2.0]][rows - 1]);
            meter.add_step(0.5, &forces[..rows], &motion[..2 * rows]);
            assert_eq!(meter.sent(), Some(work));
            (0..2).for_each(|_| meter.add_half_step(0.5, &forces[..rows], &motion[..2 * rows]));
            assert_eq!(meter.sent(), Some(2.0 * work));
        }
    }
}
