//! Work across the interface, as each side counts it.

use super::subsystem::{Port, Ports, Quantity, Subsystem};

/// Work across the interface, counted by each side in its own discretisation.
///
/// ```text
/// sent = Σ δ F_j · ½(w_j + w_{j+1})   over the actuator's micro steps, with the velocities it was given
/// received                     as the mechanics counts it, Σ h λ · ½(w⁺ + w⁻)
/// residual = sent − received   what the coupling lost (> 0) or created (< 0)
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct InterfaceWork {
    /// J; `None` where the ports are not a force and its velocity.
    pub sent_j: Option<f64>,
    /// J; `None` where the mechanics does not count it.
    pub received_j: Option<f64>,
}

impl InterfaceWork {
    /// `sent − received`, J.
    pub fn residual_j(&self) -> Option<f64> {
        Some(self.sent_j? - self.received_j?)
    }
}

/// Whether both sides count the work across their interface, so that there is a residual.
pub fn counts_interface_work(mechanics: &dyn Subsystem, actuator: &dyn Subsystem) -> bool {
    WorkMeter::new(actuator.ports()).sent().is_some() && mechanics.interface_work().is_some()
}

/// Counts what the actuator sends.
#[derive(Debug, Clone)]
pub(super) struct WorkMeter {
    /// Pairs (force output, velocity input) of the actuator that belong to the same interface row.
    ports: Vec<(usize, usize)>,
    sent: f64,
}

impl WorkMeter {
    pub(super) fn new(actuator: &Ports) -> Self {
        let of = |ports: &[Port], quantity| -> Vec<usize> {
            (0..ports.len()).filter(|&index| ports[index].quantity == quantity).collect()
        };
        let (forces, velocities) = (of(&actuator.outputs, Quantity::Force), of(&actuator.inputs, Quantity::Velocity));
        let fit = forces.len() == velocities.len();
        WorkMeter { ports: if fit { forces.into_iter().zip(velocities).collect() } else { Vec::new() }, sent: 0.0 }
    }

    /// Adds `½ δ Σ F · w` over the interface rows.
    #[inline]
    pub(super) fn add_half_step(&mut self, length: f64, outputs: &[f64], inputs: &[f64]) {
        let power: f64 = self.ports.iter().map(|&(force, velocity)| outputs[force] * inputs[velocity]).sum();
        self.sent += 0.5 * length * power;
    }

    /// Work sent so far, J.
    #[inline]
    pub(super) fn sent(&self) -> Option<f64> {
        (!self.ports.is_empty()).then_some(self.sent)
    }
}
