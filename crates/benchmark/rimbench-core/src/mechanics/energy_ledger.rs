//! The energy account of a stepper, exact in its own discretisation.

use crate::cosim::EnergyAccount;

/// Work done on the mechanics, bucket by bucket, since the start.
///
/// ```text
/// T⁺ − T⁻ = ½ (v⁺ + v⁻)ᵀ (h f + A_bᵀ P_b + A_uᵀ P_u + A_tᵀ P_t + A_iᵀ h λ_i)
/// ```
/// The identity holds to round-off in each step, with `M` as it was at the start of the step; its violation is kept as
/// `identity_residual`. What `T` changes because `M` turns with `q` is booked apart, in `inertia`.
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
    /// Work of friction, with the mean velocity of each step, J. In a step that ends in stick it can be above 0: what
    /// is done to a contact that is stopped on its way back.
    pub friction: f64,
    /// `Σ w_t⁺ P_t`, with the velocities that the law of friction speaks of, J. Never above 0.
    pub slip: f64,
    /// Work received through the interface, J.
    pub interface: f64,
    /// Change of kinetic energy by impulses, J.
    pub kinetic: f64,
    /// Change of kinetic energy by the change of `M`, `Σ ½ v⁺ᵀ (M(q⁺) − M(q)) v⁺`, J. In continuous time the Coriolis
    /// terms in `f` balance it.
    pub inertia: f64,
    /// Largest violation of the identity in one step, J.
    pub identity_residual: f64,
}

impl EnergyLedger {
    /// Books one step.
    #[inline]
    pub fn book(&mut self, step: EnergyLedger) {
        let residual = step.kinetic - step.applied - step.bilateral - step.contact - step.interface - step.friction;
        self.applied += step.applied;
        self.bilateral += step.bilateral;
        self.contact += step.contact;
        self.friction += step.friction;
        self.slip += step.slip;
        self.interface += step.interface;
        self.kinetic += step.kinetic;
        self.inertia += step.inertia;
        self.identity_residual = self.identity_residual.max(residual.abs());
    }

    /// Returns the account of the mechanics, from this ledger and two functions of state.
    ///
    /// ```text
    /// stored      = Δ(T + V)
    /// integration = applied + ΔV + bilateral + inertia
    /// ```
    /// In continuous time the applied forces do the work `−ΔV`, joints none, and Coriolis terms (booked with the
    /// applied forces) balance the inertia: what they do in discrete time is the integration residual of the
    /// semi-implicit step. Applied forces without a potential would show there too. `T` is that of the state, not a sum
    /// of works: that both agree is what the closure tests. `V` stands on both sides and is tested by nothing but that
    /// the residual vanishes.
    pub fn account(&self, stored: f64, potential_change: f64) -> EnergyAccount {
        EnergyAccount {
            stored,
            interface: self.interface,
            contact: -self.contact,
            friction: -self.friction,
            integration: self.applied + potential_change + self.bilateral + self.inertia,
            ..EnergyAccount::default()
        }
    }
}
