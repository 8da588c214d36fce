//! The energy account of a run: what each side stored, received, lost, and what its solver made out of nothing.

use super::interface_work::InterfaceWork;
use super::model_audit::ModelEnergy;
use super::side::PerSide;

/// Energy account of one subsystem since the start, J, as its own discretisation counts it.
///
/// ```text
/// stored = interface − contact − friction − viscous + pump − valve − tank + integration + closure
/// ```
/// Every bucket is booked on its own: `stored` is a difference of two values of a function of state, the works and
/// losses are sums over steps of force (or flow) times displacement (or pressure), and `integration` is a sum of the
/// defects of the discretisation, each worked out where it arises. None of them is "what is left", so that
/// [`closure`](Self::closure) is round-off if, and only if, nothing was forgotten or booked twice.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EnergyAccount {
    /// Change of the stored energy: kinetic and potential, or elastic.
    pub stored: f64,
    /// Work received through the interface.
    pub interface: f64,
    /// Lost in contacts; below zero where the push out of a penetration did work.
    pub contact: f64,
    /// Lost in viscous friction.
    pub viscous: f64,
    /// Brought in by the fluid that came from the pump.
    pub pump: f64,
    /// Lost in the valve's orifices.
    pub valve: f64,
    /// Carried out by the fluid that went to the tank.
    pub tank: f64,
    /// Energy that the subsystem's own discretisation created (above 0) or lost (below 0). Vanishes with the
    /// subsystem's step.
    pub integration: f64,
    /// Lost in friction of contacts.
    pub friction: f64,
}

impl EnergyAccount {
    fn losses(&self) -> f64 {
        self.contact + self.viscous + self.valve + self.tank + self.friction
    }

    /// Says what the account does not explain, J: round-off.
    pub fn closure(&self) -> f64 {
        let explained = self.interface - self.contact - self.viscous + self.pump - self.valve - self.tank;
        self.stored - explained - self.integration + self.friction
    }
}

/// The energy audit of a run: both sides and the interface between them.
///
/// The interface has two counts of what the actuator sent: the actuator's own, and the macro loop's trapezium of
/// [`InterfaceWork`], which compares across schemes. They differ by a quadrature error, which counts as integration.
///
/// ```text
/// stored = pump − valve − tank − viscous − contact − friction − (sent − received) + integration + closure
/// integration = those of both sides + (sent − the actuator's own count)
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EnergyAudit {
    /// Account of each side, if it keeps one.
    pub accounts: PerSide<Option<EnergyAccount>>,
    /// Work across the interface.
    pub work: InterfaceWork,
    /// The part that the scheme's interface model created of the interface residual, where that is asked for and known.
    pub model: Option<ModelEnergy>,
}

impl EnergyAudit {
    /// Returns `sent − received`, J: what the coupling lost (> 0) or created (< 0).
    pub fn interface_residual(&self) -> Option<f64> {
        self.work.residual_j()
    }

    /// Returns a bucket of both sides together, J.
    pub fn total(&self, bucket: fn(&EnergyAccount) -> f64) -> Option<f64> {
        Some(bucket(&self.accounts.mechanics?) + bucket(&self.accounts.actuator?))
    }

    /// Says what the solvers of both sides created (above 0) or lost (below 0), J.
    pub fn integration(&self) -> Option<f64> {
        let quadrature = self.work.sent_j? + self.accounts.actuator?.interface;
        Some(self.total(|account| account.integration)? + quadrature)
    }

    /// Names the first entry that is no finite number; none where the account can be drawn up, or is not kept.
    pub fn not_finite(&self) -> Option<&'static str> {
        let model = |part: fn(&ModelEnergy) -> f64| self.model.as_ref().map(part);
        let entries = [
            ("work_sent_j", self.work.sent_j),
            ("work_received_j", self.work.received_j),
            ("stored_energy_change_j", self.total(|account| account.stored)),
            ("pump_work_j", self.total(|account| account.pump)),
            ("integration_residual_j", self.integration()),
            ("audit_closure_j", self.closure()),
            ("created_by_jump_j", model(|model| model.jump)),
            ("created_by_first_moment_j", model(|model| model.first_moment)),
            ("created_by_contacts_j", model(|model| model.contacts)),
            ("created_unfrozen_j", model(|model| model.unfrozen)),
        ];
        entries.into_iter().find(|(_, value)| value.is_some_and(|value| !value.is_finite())).map(|(name, _)| name)
    }

    /// Says what the audit does not explain, J: round-off.
    pub fn closure(&self) -> Option<f64> {
        let losses = self.total(EnergyAccount::losses)?;
        let created = self.integration()? - self.interface_residual()?;
        Some(self.total(|account| account.stored - account.pump)? + losses - created)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_forgotten_bucket_shows_in_the_closure() {
        // By hand: 10 J from the pump, 2 to the valve, 1 to the tank, 1 to friction, 5 sent; 4 of them arrive, 1.5 end
        // in a contact, 2.5 are kinetic; 1 J stays as pressure. Nothing is created.
        let actuator = EnergyAccount {
            stored: 1.0,
            interface: -5.0,
            viscous: 1.0,
            pump: 10.0,
            valve: 2.0,
            tank: 1.0,
            ..EnergyAccount::default()
        };
        let mechanics = EnergyAccount { stored: 2.5, interface: 4.0, contact: 1.5, ..EnergyAccount::default() };
        assert_eq!((actuator.closure(), mechanics.closure()), (0.0, 0.0));
        let work = InterfaceWork { sent_j: Some(5.0), received_j: Some(4.0) };
        let accounts = PerSide { mechanics: Some(mechanics), actuator: Some(actuator) };
        let audit = EnergyAudit { accounts, work, model: None };
        assert_eq!(audit.interface_residual(), Some(1.0));
        assert_eq!((audit.integration(), audit.closure()), (Some(0.0), Some(0.0)));
        // The loop counts 5.25 J sent: a quarter is quadrature, and neither side's account moves.
        let work = InterfaceWork { sent_j: Some(5.25), received_j: Some(4.0) };
        let other = EnergyAudit { work, ..audit };
        assert_eq!((other.integration(), other.closure()), (Some(0.25), Some(0.0)));
        let forgotten = EnergyAccount { contact: 0.0, ..mechanics };
        assert_eq!(
            EnergyAudit { accounts: PerSide { mechanics: Some(forgotten), ..audit.accounts }, ..audit }.closure(),
            Some(-1.5)
        );
        assert_eq!(EnergyAudit { accounts: PerSide { mechanics: None, ..audit.accounts }, ..audit }.closure(), None);
    }

    #[test]
    fn an_account_that_cannot_be_drawn_up_is_told_from_one_that_is_not_kept() {
        let account = |contact: f64| Some(EnergyAccount { contact, ..EnergyAccount::default() });
        let work = InterfaceWork { sent_j: Some(1.0), received_j: Some(1.0) };
        let audit = |mechanics: Option<EnergyAccount>| EnergyAudit {
            accounts: PerSide { mechanics, actuator: account(0.0) },
            work,
            model: None,
        };
        assert_eq!([account(1.0), None].map(|mechanics| audit(mechanics).not_finite()), [None, None]);
        for lost in [f64::NAN, f64::INFINITY] {
            assert_eq!(audit(account(lost)).not_finite(), Some("audit_closure_j"));
            let work = InterfaceWork { sent_j: Some(lost), ..work };
            assert_eq!(EnergyAudit { work, ..audit(None) }.not_finite(), Some("work_sent_j"));
        }
    }
}
