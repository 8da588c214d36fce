//! The energy account of a stepper, exact in its own discretisation.

/// Work done on the mechanics, bucket by bucket, since the start.
///
/// ```text
/// T⁺ − T⁻ = ½ (v⁺ + v⁻)ᵀ (h f + A_bᵀ P_b + A_uᵀ P_u + A_iᵀ h λ_i)
/// ```
/// The identity holds to round-off in each step with constant `M`; its violation is kept as `identity_residual`.
/// # Source
/// Follows from `M (v⁺ − v⁻) = Σ impulses`; the impulse–energy identity of non-smooth mechanics.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EnergyLedger {
    /// Work of applied forces, J.
    pub applied: f64,
    /// Work of joints (not zero in discrete time), J.
    pub bilateral: f64,
    /// Work of contacts; negative means dissipated in impacts, J.
    pub contact: f64,
    /// Work received through the interface, J.
    pub interface: f64,
    /// Change of kinetic energy, J.
    pub kinetic: f64,
    /// Largest violation of the identity in one step, J.
    pub identity_residual: f64,
}

impl EnergyLedger {
    /// Books one step.
    #[inline]
    pub fn book(&mut self, step: EnergyLedger) {
        let residual = step.kinetic - step.applied - step.bilateral - step.contact - step.interface;
        self.applied += step.applied;
        self.bilateral += step.bilateral;
        self.contact += step.contact;
        self.interface += step.interface;
        self.kinetic += step.kinetic;
        self.identity_residual = self.identity_residual.max(residual.abs());
    }
}
