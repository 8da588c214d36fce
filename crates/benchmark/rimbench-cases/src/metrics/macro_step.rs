//! How far the macro steps of a run reached.

use super::evidence::{Evidence, metrics};
use rimbench_statistics::rank_correlation;

metrics! {
    /// Spearman's ρ of what the run knew of its error and what the reference knows.
    DEFECT_RANK: "model_defect_rank" in "-" (correlation),
    "Rank correlation of the model's defect in each macro step with the force error at its end; with step control model-defect"
    => |evidence| rank_correlation(&defects_and_errors(evidence));
}

/// The defect of each macro step and the magnitude of the force error at its end, of several rows the largest.
fn defects_and_errors(evidence: &Evidence<'_>) -> Vec<[f64; 2]> {
    let defects = evidence.report.model_defect.iter();
    let mut pairs: Vec<[f64; 2]> = defects.map(|[_, defect]| [*defect, 0.0]).collect();
    for row in evidence.interface {
        let errors = evidence.pairs(row.force).skip(1).map(|(own, reference)| (own - reference).abs());
        for (pair, error) in pairs.iter_mut().zip(errors) {
            pair[1] = pair[1].max(error);
        }
    }
    pairs
}

metrics! {
    /// `t_end / n`, n the macro steps that the solution is made of; repeated ones do not count.
    MEAN_MACRO_STEP: "mean_macro_step_s" in "s",
    "Mean length of the macro steps; with step control what was found necessary, else H, apart from the phase"
    => |evidence| {
        let steps = evidence.report.work.cosim.macro_steps;
        (steps > 0).then(|| evidence.report.ended_at_s / steps as f64)
    };
}
