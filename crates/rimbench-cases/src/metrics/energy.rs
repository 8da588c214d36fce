//! What the coupling does to energy.

use super::contact_phase::ContactInterval;
use super::evidence::Metric;
use rimbench_statistics::slope;

pub(super) const WORK_SENT: Metric = Metric {
    name: "work_sent_j",
    unit: "J",
    floor: None,
    about: "Work the actuator did on the interface, with the velocity it was given",
    compute: |evidence| evidence.report.audit.work.sent_j,
};

pub(super) const WORK_RECEIVED: Metric = Metric {
    name: "work_received_j",
    unit: "J",
    floor: None,
    about: "Work the mechanics received through the interface, with its own velocity",
    compute: |evidence| evidence.report.audit.work.received_j,
};

pub(super) const INTERFACE_RESIDUAL: Metric = Metric {
    name: "interface_residual_j",
    unit: "J",
    floor: None,
    about: "Work sent minus work received: what the coupling lost (above 0) or created (below 0)",
    compute: |evidence| evidence.report.audit.work.residual_j(),
};

pub(super) const RESIDUAL_IN_IMPACTS: Metric = Metric {
    name: "interface_residual_in_impacts_j",
    unit: "J",
    floor: None,
    about: "Part of the interface residual from the macro steps in which a contact closed: lost (above 0) or created; the rest is smooth",
    compute: |evidence| {
        let mut instants: Vec<f64> =
            evidence.run_contacts.iter().flatten().filter_map(ContactInterval::closed_during_run).collect();
        instants.sort_by(f64::total_cmp);
        instants.dedup();
        let steps = evidence.report.interface_residual.windows(2);
        let in_impacts = steps.filter(|step| instants.binary_search_by(|t| t.total_cmp(&step[1][0])).is_ok());
        (!evidence.report.interface_residual.is_empty() && !evidence.gaps.is_empty())
            .then(|| in_impacts.map(|step| step[1][1] - step[0][1]).sum())
    },
};

pub(super) const INTERFACE_DRIFT: Metric = Metric {
    name: "interface_drift_w",
    unit: "W",
    floor: None,
    about: "Slope of the cumulative interface residual over time, by least squares: energy lost (above 0) or created per second",
    compute: |evidence| slope(&evidence.report.interface_residual),
};

pub(super) const STORED_CHANGE: Metric = Metric {
    name: "stored_energy_change_j",
    unit: "J",
    floor: None,
    about: "Change of kinetic, potential and elastic energy of both sides",
    compute: |evidence| evidence.report.audit.total(|account| account.stored),
};

pub(super) const PUMP_WORK: Metric = Metric {
    name: "pump_work_j",
    unit: "J",
    floor: None,
    about: "Energy of the fluid that came from the pump",
    compute: |evidence| evidence.report.audit.accounts.actuator.map(|account| account.pump),
};

pub(super) const VALVE_DISSIPATION: Metric = Metric {
    name: "valve_dissipation_j",
    unit: "J",
    floor: None,
    about: "Energy lost in the orifices of the valve",
    compute: |evidence| evidence.report.audit.accounts.actuator.map(|account| account.valve),
};

pub(super) const TANK_OUTFLOW: Metric = Metric {
    name: "tank_outflow_j",
    unit: "J",
    floor: None,
    about: "Energy of the fluid that went to the tank",
    compute: |evidence| evidence.report.audit.accounts.actuator.map(|account| account.tank),
};

pub(super) const VISCOUS_DISSIPATION: Metric = Metric {
    name: "viscous_dissipation_j",
    unit: "J",
    floor: None,
    about: "Energy lost in viscous friction of the actuator",
    compute: |evidence| evidence.report.audit.accounts.actuator.map(|account| account.viscous),
};

pub(super) const CONTACT_DISSIPATION: Metric = Metric {
    name: "contact_dissipation_j",
    unit: "J",
    floor: None,
    about: "Energy lost in contacts; below 0 where pushing penetrations out did more work",
    compute: |evidence| evidence.report.audit.accounts.mechanics.map(|account| account.contact),
};

pub(super) const FRICTION_DISSIPATION: Metric = Metric {
    name: "friction_dissipation_j",
    unit: "J",
    floor: None,
    about: "Energy lost in friction of contacts; 0 where there is none",
    compute: |evidence| evidence.report.audit.accounts.mechanics.map(|account| account.friction),
};

pub(super) const SCHEME_DISSIPATION: Metric = Metric {
    name: "scheme_dissipated_j",
    unit: "J",
    floor: None,
    about: "Energy that the scheme itself took out, where it has a damper or returns energy; part of the work received, not beside it",
    compute: |evidence| evidence.report.scheme.dissipated_j,
};

pub(super) const INTEGRATION_RESIDUAL: Metric = Metric {
    name: "integration_residual_j",
    unit: "J",
    floor: None,
    about: "Energy that the solvers of both sides created (above 0) or lost by their finite steps",
    compute: |evidence| evidence.report.audit.integration(),
};

pub(super) const AUDIT_CLOSURE: Metric = Metric {
    name: "audit_closure_j",
    unit: "J",
    floor: None,
    about: "What the energy audit does not explain: stored change minus all works, losses and residuals; round-off",
    compute: |evidence| evidence.report.audit.closure(),
};

pub(super) const IDENTITY_RESIDUAL: Metric = Metric {
    name: "energy_identity_residual_j",
    unit: "J",
    floor: None,
    about: "Largest violation, in one mechanics step, of the impulse-energy identity; round-off if the stepper is right",
    compute: |evidence| evidence.report.energy_identity_residual_j,
};
