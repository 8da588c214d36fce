//! What the coupling does to energy.

use super::evidence::Metric;

pub(super) const WORK_SENT: Metric = Metric {
    name: "work_sent_j",
    unit: "J",
    about: "Work the actuator did on the interface, with the velocity it was given",
    compute: |evidence| evidence.report.work.sent_j,
};

pub(super) const WORK_RECEIVED: Metric = Metric {
    name: "work_received_j",
    unit: "J",
    about: "Work the mechanics received through the interface, with its own velocity",
    compute: |evidence| evidence.report.work.received_j,
};

pub(super) const INTERFACE_RESIDUAL: Metric = Metric {
    name: "interface_residual_j",
    unit: "J",
    about: "Work sent minus work received: what the coupling lost (above 0) or created (below 0)",
    compute: |evidence| Some(evidence.report.work.sent_j? - evidence.report.work.received_j?),
};

pub(super) const IDENTITY_RESIDUAL: Metric = Metric {
    name: "energy_identity_residual_j",
    unit: "J",
    about: "Largest violation, in one mechanics step, of the impulse-energy identity; round-off if the stepper is right",
    compute: |evidence| evidence.energy_identity_residual_j,
};
