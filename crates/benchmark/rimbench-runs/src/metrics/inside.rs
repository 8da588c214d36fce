//! Distance from the reference inside macro steps: what the actuator did, and what it was told of the motion, micro
//! step by micro step.
//!
//! At communication points a scheme has just been told the truth. Between them it guesses, and that is where the
//! actuator's state goes astray.

use super::accuracy::worst;
use super::evidence::metrics;

metrics! {
    /// ```text
    /// e = max over windows [a, b] of |Σ λ_received Δt − ∫ λ_ref dt|        b: first communication point with b − a ≥ 20 ms
    /// ```
    /// The force that the mechanics receives is a mean over each macro step, so its impulse is exact.
    IMPULSE_ERROR: "impulse_error_20ms_n_s" in "N s",
    "Largest difference, over windows of 20 ms, of the impulse that the mechanics received from the reference's"
    => |evidence| {
        evidence.sums.interface.iter().filter_map(|row| row.impulse.as_ref()?.worst).reduce(f64::max)
    };
}

metrics! {
    FORCE_ERROR_INSIDE: "force_error_inside_rms_n" in "N" above super::Floor::Force,
    "Root mean square over micro steps, inside macro steps as well, of the actuator's own force minus the reference's"
    => |evidence| worst(evidence, |_, sums| sums.inside[0].rms());

    POSITION_ERROR_INSIDE: "position_error_inside_rms_m" in "m" above super::Floor::Position,
    "Root mean square over micro steps of the interface position that the actuator was given minus the reference's"
    => |evidence| worst(evidence, |_, sums| sums.inside[1].rms());
}
