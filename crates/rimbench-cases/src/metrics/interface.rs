//! How the rows of an interface feel each other, of schemes that have a model for each.

use super::evidence::metrics;

metrics! {
    LAMBDA: "interface_lambda" in "-" of Split,
    "Largest eigenvalue λ of the interface's correlations over the run: 1 for actuators that do not feel each other, N for N on one point"
    => |evidence| Some(evidence.report.scheme.interface?.lambda);

    CORRELATION: "interface_correlation" in "-" of Split,
    "Largest correlation |H_ij|/√(H_ii H_jj) of two rows of the interface over the run"
    => |evidence| Some(evidence.report.scheme.interface?.largest);
}
