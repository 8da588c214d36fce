//! How the rows of an interface feel each other, of schemes that have a model for each.

use super::evidence::{Evidence, metrics};
use crate::predicted_growth::NEUTRAL;
use rimbench_core::cosim::{InterfaceWork, OutcomeClass};

metrics! {
    LAMBDA: "interface_lambda" in "-" of Split,
    "Largest eigenvalue λ of the interface's correlations over the run, free or with the contacts that push: 1 for actuators that do not feel each other, N for N on one point"
    => |evidence| Some(evidence.report.scheme.interface?.lambda);

    CORRELATION: "interface_correlation" in "-" of Split,
    "Largest correlation |H_ij|/√(H_ii H_jj) of two rows of the interface over the run"
    => |evidence| Some(evidence.report.scheme.interface?.largest);

    CREATED: "bond_residual_min_j" in "J" (signed) of Split,
    "Least work of a bond that it sent and the mechanics did not receive: below 0 what its coupling created"
    => |evidence| evidence.report.bonds.iter().filter_map(InterfaceWork::residual_j).reduce(f64::min);

    BOOKED: "booked_share" in "-" of Split,
    "Micro steps of the longest bond of each stage, of those of all bonds: 1 one after the other, 1/N for N alike at once"
    => |evidence| {
        let [longest, all] = evidence.report.booked_micro_steps;
        (all > 0).then(|| longest as f64 / all as f64)
    };

    TRIALS: "trials_per_step" in "-" of Trials,
    "Steps of the mechanics that were tried, per macro step"
    => |evidence| Some(evidence.report.scheme.trials?.count as f64 / evidence.report.work.cosim.macro_steps as f64);

    MOST_TRIALS: "trials_per_step_max" in "-" of Trials,
    "Most steps of the mechanics that were tried in one macro step"
    => |evidence| Some(evidence.report.scheme.trials?.most as f64);

    CUT_TRIALS: "trials_cut" in "-" of Trials,
    "Macro steps in which a force was not tried because there were as many trials as are allowed"
    => |evidence| Some(evidence.report.scheme.trials?.cut as f64);

    SECOND_TANGENTS: "second_tangents" in "-" of Trials,
    "How often an answer of the mechanics was not as foreseen, and a second tangent was taken"
    => |evidence| Some(evidence.report.scheme.trials?.further as f64);

    MISS: "answer_error_p50" in "-" of Trials,
    "Error of the velocity foreseen at the end of a macro step, of what it moves (half of the macro steps are below)"
    => |evidence| Some(evidence.report.scheme.trials?.miss[0]);

    LARGEST_MISS: "answer_error_max" in "-" of Trials,
    "Error of the velocity foreseen at the end of a macro step, of what it moves (largest)"
    => |evidence| Some(evidence.report.scheme.trials?.miss[1]);

    AS_PREDICTED: "completed_as_predicted" in "-" (ends) of Claimed,
    "1 if the run completed and its coupling, linearised at the start, does not grow, or if neither; 0 if only one of the two"
    => |evidence| {
        let [completed, predicted] = found_and_predicted(evidence)?;
        Some(f64::from(completed == predicted))
    };

    UNFORESEEN: "failed_unforeseen" in "-" (ends) of Claimed,
    "1 if the run did not complete although its coupling, linearised at the start, does not grow: a prediction that errs on the unsafe side; else 0"
    => |evidence| {
        let [completed, predicted] = found_and_predicted(evidence)?;
        Some(f64::from(predicted && !completed))
    };
}

/// Whether the run completed, and whether that is predicted.
fn found_and_predicted(evidence: &Evidence<'_>) -> Option<[bool; 2]> {
    let completed = match evidence.report.outcome.class() {
        OutcomeClass::NoAnswer => return None,
        class => class == OutcomeClass::Completed,
    };
    Some([completed, evidence.predicted_growth? <= 1.0 + NEUTRAL])
}
