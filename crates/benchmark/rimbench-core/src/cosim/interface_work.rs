//! Work across the interface, as each side counts it.

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
    /// Returns `sent − received`, J.
    pub fn residual_j(&self) -> Option<f64> {
        Some(self.sent_j? - self.received_j?)
    }
}
