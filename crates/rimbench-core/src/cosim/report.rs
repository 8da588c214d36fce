//! What the macro loop reports of a run.

use super::energy_account::EnergyAudit;
use super::interface_work::InterfaceWork;
use super::outcome::Outcome;
use super::work::Work;

/// Exact counters of the loop itself.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CosimCounters {
    /// Macro steps that the solution is made of.
    pub macro_steps: u64,
    /// Macro steps taken besides: iterations but the last, trial steps, rejected steps. Zero in a non-iterative run.
    pub repeated_macro_steps: u64,
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
    /// Counters of the loop.
    pub counters: CosimCounters,
    /// All work, that of the loop included; what was done on copies counts.
    pub spent: Work,
    /// Largest violation of the mechanics' energy identity in one step, J.
    pub energy_identity_residual_j: Option<f64>,
    /// Work across the interface.
    pub work: InterfaceWork,
    /// Energy that the scheme itself took out, J, if it does such a thing.
    pub scheme_dissipated_j: Option<f64>,
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
            spent: Work::default(),
            energy_identity_residual_j: None,
            work: InterfaceWork::default(),
            scheme_dissipated_j: None,
            audit: EnergyAudit::default(),
            interface_residual: Vec::new(),
            latencies_s: Vec::new(),
        }
    }
}
