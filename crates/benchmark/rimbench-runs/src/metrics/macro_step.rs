//! How far the macro steps of a run reached.

use super::evidence::metrics;
use rimbench_statistics::rank_correlation;

metrics! {
    /// Spearman's ρ of what the run knew of its error and what the reference knows.
    DEFECT_RANK: "model_defect_rank" in "-" (correlation),
    "Rank correlation of the model's defect in each macro step with the force error at its end; with step control model-defect"
    => |evidence| {
        let defects = evidence.report.model_defect.iter().map(|[_, defect]| *defect);
        // The first error is that at the start, where no macro step ends.
        let errors = evidence.sums.force_errors.iter().copied().skip(1);
        rank_correlation(&defects.zip(errors).map(|(defect, error)| [defect, error]).collect::<Vec<_>>())
    };
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
