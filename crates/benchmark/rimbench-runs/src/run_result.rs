//! What comes of a run.

use rimbench_core::cosim::{Report, Trajectory};
use std::time::Duration;

/// What comes of a run.
#[derive(Debug, Clone)]
pub struct RunResult {
    /// How it ended, and all that was counted.
    pub report: Report,
    /// One row per communication point.
    pub trajectory: Trajectory,
    /// What the coupling lost (> 0) or created (< 0) up to each communication point, J; empty where it is not counted.
    pub interface_residual: Vec<f64>,
    /// Wall time of the macro loop; zero without a clock.
    pub wall: Duration,
}
