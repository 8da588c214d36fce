//! What the time of a benchmark comes to per step.

use super::history::Row;

/// Times and estimated work of a row in units one can compare with a deadline or with the clock of a core.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PerStep {
    /// Wall time per macro step, ns; `None` where the benchmark has none.
    pub macro_step_ns: Option<f64>,
    /// Wall time per micro step of either side, ns; `None` where the benchmark has none.
    pub micro_step_ns: Option<f64>,
    /// Estimated floating-point operations of eliminations and complementarity problems per nanosecond of the whole; `None`
    /// where the benchmark has neither. A core that does two scalar operations per cycle at 4 GHz reaches 8.
    pub flops_per_ns: Option<f64>,
}

impl PerStep {
    /// Of a row with wall times and the right answer.
    pub fn of(row: &Row) -> Option<PerStep> {
        let wall_ns = 1e9 * row.wall_s.filter(|_| row.is_ok())?;
        let per = |count: u64| (count > 0).then(|| wall_ns / count as f64);
        Some(PerStep {
            macro_step_ns: per(row.macro_steps),
            micro_step_ns: per(row.mechanics_micro_steps + row.actuator_micro_steps),
            flops_per_ns: per(row.flops_estimate).map(f64::recip),
        })
    }
}
