//! What the macro loop reports of a run.

use super::energy_account::EnergyAudit;
use super::interface_work::InterfaceWork;
use super::outcome::Outcome;

/// Exact counters of the loop itself.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CosimCounters {
    /// Macro steps taken.
    pub macro_steps: u64,
    /// Exchanges between the sides.
    pub exchanges: u64,
}

/// What the loop reports of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// How it ended. A run that diverges is followed to its end, or to the point where it cannot go on.
    pub outcome: Outcome,
    /// Time of the last communication point reached, s.
    pub ended_at_s: f64,
    /// Counters.
    pub counters: CosimCounters,
    /// Work across the interface.
    pub work: InterfaceWork,
    /// Accounts of both sides and the interface.
    pub audit: EnergyAudit,
    /// Cumulative interface residual, one pair (t_k in s, J) per communication point; empty where it is not counted.
    pub interface_residual: Vec<[f64; 2]>,
    /// Wall time of each macro step, s; empty unless asked for. Depends on machine and load.
    pub latencies_s: Vec<f64>,
}

impl Report {
    /// The report of a run that was not begun.
    pub fn not_run(outcome: Outcome) -> Self {
        Report {
            outcome,
            ended_at_s: 0.0,
            counters: CosimCounters::default(),
            work: InterfaceWork::default(),
            audit: EnergyAudit::default(),
            interface_residual: Vec::new(),
            latencies_s: Vec::new(),
        }
    }
}
