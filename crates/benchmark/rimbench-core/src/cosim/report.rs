//! The report of the macro loop on a run.

use super::coupling_scheme::SchemeReport;
use super::energy_account::EnergyAudit;
use super::interface_work::InterfaceWork;
use super::latencies::Latencies;
use super::outcome::Outcome;
use super::trajectory::Trajectory;
use super::work::Work;

/// The report of the loop on a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// How it ended. A run that diverges is followed to its end, or to the point where it cannot go on.
    pub outcome: Outcome,
    /// Time of the last communication point reached, s.
    pub ended_at_s: f64,
    /// All work; what was done on copies counts.
    pub work: Work,
    /// Largest violation of the mechanics' energy identity in one step, J.
    pub energy_identity_residual_j: Option<f64>,
    /// Accounts of both sides and the work across the interface.
    pub audit: EnergyAudit,
    /// The scheme's own picture at the end.
    pub scheme: SchemeReport,
    /// By how much the scheme's model was wrong at the end of each macro step, one pair (t_k in s, N) per macro step:
    /// see [`StepControl::ModelDefect`](super::StepControl::ModelDefect). Empty under any other rule.
    pub model_defect: Vec<[f64; 2]>,
    /// Work across the rows of each bond, where there are several: what it sent, and what the mechanics received of it with
    /// the velocities of its rows at both ends of each of its steps.
    pub bonds: Vec<InterfaceWork>,
    /// Micro steps that the longest bond of each stage has taken, and those of all bonds: how long an order takes with a
    /// processor for each bond, and with one for all.
    pub booked_micro_steps: [u64; 2],
    /// The factor on the mass of the interface model that the actuator has learned, where it learns.
    pub learned_mass: Option<f64>,
    /// Least correlation of the mechanics' free accelerations that are no farther apart than samples are old; none
    /// where none is late.
    pub late_acceleration_correlation: Option<f64>,
    /// Wall times of the macro steps; none unless asked for. They depend on machine and load.
    pub latencies: Option<Latencies>,
    /// The micro steps of the actuator: `time_s` at which its outputs are read (its start, of the midpoint rule its
    /// middle), `middle_s`, these outputs, its inputs over it. None unless asked for, and where steps are taken again
    /// or both sides step together.
    pub inside: Option<Trajectory>,
}

impl Report {
    /// Makes the report of a run that was not begun.
    pub fn not_run(outcome: Outcome) -> Self {
        Report {
            outcome,
            ended_at_s: 0.0,
            work: Work::default(),
            energy_identity_residual_j: None,
            audit: EnergyAudit::default(),
            scheme: SchemeReport::default(),
            model_defect: Vec::new(),
            bonds: Vec::new(),
            booked_micro_steps: [0; 2],
            learned_mass: None,
            late_acceleration_correlation: None,
            latencies: None,
            inside: None,
        }
    }
}
