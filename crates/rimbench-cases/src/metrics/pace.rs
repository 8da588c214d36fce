//! How far the macro steps of a run reached.

use super::evidence::Metric;

/// `t_end / n`, n the macro steps that the solution is made of; repeated ones do not count.
pub(super) const MEAN_MACRO_STEP: Metric = Metric {
    name: "mean_macro_step_s",
    unit: "s",
    about: "Mean length of the macro steps; with step control what was found necessary, else H but for the phase",
    compute: |evidence| {
        let steps = evidence.report.work.cosim.macro_steps;
        (steps > 0).then(|| evidence.report.ended_at_s / steps as f64)
    },
};
