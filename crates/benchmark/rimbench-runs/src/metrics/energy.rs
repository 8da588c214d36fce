//! What the coupling does to energy.

use super::evidence::metrics;

metrics! {
    WORK_SENT: "work_sent_j" in "J" (signed),
    "Work the actuator did on the interface, with the velocity it was given"
    => |evidence| evidence.report.audit.work.sent_j;

    WORK_RECEIVED: "work_received_j" in "J" (signed),
    "Work the mechanics received through the interface, with its own velocity"
    => |evidence| evidence.report.audit.work.received_j;

    INTERFACE_RESIDUAL: "interface_residual_j" in "J" (signed),
    "Work sent minus work received: what the coupling lost (above 0) or created (below 0)"
    => |evidence| evidence.report.audit.work.residual_j();

    RESIDUAL_IN_IMPACTS: "interface_residual_in_impacts_j" in "J" (signed),
    "Part of the interface residual from the macro steps in which a contact closed: lost (above 0) or created; the rest is smooth"
    => |evidence| {
        let sums = evidence.sums;
        (sums.counts_residual() && !sums.columns.gaps.is_empty()).then_some(sums.residual_in_impacts)
    };

    INTERFACE_DRIFT: "interface_drift_w" in "W" (signed),
    "Slope of the cumulative interface residual over time, by least squares: energy lost (above 0) or created per second"
    => |evidence| evidence.sums.drift.slope();

    STORED_CHANGE: "stored_energy_change_j" in "J" (signed),
    "Change of kinetic, potential and elastic energy of both sides"
    => |evidence| evidence.report.audit.total(|account| account.stored);

    GROWTH: "energy_growth" in "-" of Column,
    "Most energy of the whole system, less what was supplied, over that of its start and what was turned over"
    => |evidence| evidence.sums.growth;

    PUMP_WORK: "pump_work_j" in "J" (signed),
    "Energy of the fluid that came from the pump"
    => |evidence| evidence.report.audit.accounts.actuator.map(|account| account.pump);

    VALVE_DISSIPATION: "valve_dissipation_j" in "J",
    "Energy lost in the orifices of the valve"
    => |evidence| evidence.report.audit.accounts.actuator.map(|account| account.valve);

    TANK_OUTFLOW: "tank_outflow_j" in "J" (signed),
    "Energy of the fluid that went to the tank"
    => |evidence| evidence.report.audit.accounts.actuator.map(|account| account.tank);

    VISCOUS_DISSIPATION: "viscous_dissipation_j" in "J",
    "Energy lost in viscous friction of the actuator"
    => |evidence| evidence.report.audit.accounts.actuator.map(|account| account.viscous);

    CONTACT_DISSIPATION: "contact_dissipation_j" in "J" (signed),
    "Energy lost in contacts; below 0 where pushing penetrations out did more work"
    => |evidence| evidence.report.audit.accounts.mechanics.map(|account| account.contact);

    FRICTION_DISSIPATION: "friction_dissipation_j" in "J",
    "Energy lost in friction of contacts; 0 where there is none"
    => |evidence| evidence.report.audit.accounts.mechanics.map(|account| account.friction);

    SCHEME_DISSIPATION: "scheme_dissipated_j" in "J" (signed),
    "Energy that the scheme itself took out, where it has a damper or returns energy; part of the work received, not beside it"
    => |evidence| evidence.report.scheme.dissipated_j;

    INTEGRATION_RESIDUAL: "integration_residual_j" in "J" (signed),
    "Energy that the solvers of both sides created (above 0) or lost by their finite steps"
    => |evidence| evidence.report.audit.integration();

    AUDIT_CLOSURE: "audit_closure_j" in "J" (signed),
    "What the energy audit does not explain: stored change minus all works, losses and residuals; round-off"
    => |evidence| evidence.report.audit.closure();

    IDENTITY_RESIDUAL: "energy_identity_residual_j" in "J",
    "Largest violation, in one mechanics step, of the impulse-energy identity; round-off if the stepper is right"
    => |evidence| evidence.report.energy_identity_residual_j;
}
