//! How the rows of an interface feel each other, of schemes that have a model for each.

use super::evidence::Metric;

pub(super) const LAMBDA: Metric = Metric {
    name: "interface_lambda",
    unit: "-",
    floor: None,
    about: "Largest eigenvalue λ of the interface's correlations over the run: 1 for actuators that do not feel each other, N for N on one point",
    compute: |evidence| Some(evidence.report.scheme.interface?.lambda),
};

pub(super) const CORRELATION: Metric = Metric {
    name: "interface_correlation",
    unit: "-",
    floor: None,
    about: "Largest correlation |H_ij|/√(H_ii H_jj) of two rows of the interface over the run",
    compute: |evidence| Some(evidence.report.scheme.interface?.largest),
};
