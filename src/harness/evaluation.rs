//! A run held against its reference: metrics and counters by name.

use super::reference::Reference;
use super::run::{RunResult, RunSpec};
use crate::cases::{Case, ReferenceMethod};
use crate::cosim::{Outcome, Trajectory};
use crate::metrics::{Evidence, METRICS};
use std::time::Duration;

/// What is kept of a run: its outcome, every metric, every counter.
#[derive(Debug, Clone)]
pub struct EvaluatedRun {
    /// How it ended.
    pub outcome: Outcome,
    /// Time of the last communication point reached, s.
    pub ended_at_s: f64,
    /// One value per entry of [`METRICS`].
    pub metrics: Vec<Option<f64>>,
    /// Uncertainty of the reference's interface force, N, and position, m.
    pub reference_uncertainty: [Option<f64>; 2],
    /// Exact counters by name.
    pub counters: Vec<(&'static str, u64)>,
    /// Wall time of the macro loop.
    pub wall: Duration,
    /// The trajectory.
    pub trajectory: Trajectory,
}

impl EvaluatedRun {
    /// A metric by name.
    pub fn metric(&self, name: &str) -> Option<f64> {
        METRICS.iter().position(|metric| metric.name == name).and_then(|index| self.metrics[index])
    }
}

/// Computes all metrics of a run.
pub fn evaluate(spec: &RunSpec, result: RunResult, reference: &Reference) -> EvaluatedRun {
    let counters = counters(&result);
    let columns = spec.case.interface_columns;
    let column = |name: &str| result.trajectory.index_of(name).unwrap_or(0);
    let gaps = gap_columns(spec.case);
    let exact = exact_at(spec, &result.trajectory);
    let evidence = Evidence {
        run: &result.trajectory,
        reference: exact.as_ref().unwrap_or(&reference.trajectory),
        report: &result.report,
        position: column(columns.position),
        velocity: column(columns.velocity),
        force: column(columns.force),
        effective_mass: result.trajectory.index_of("effective_mass_kg"),
        gaps: &gaps,
        energy_identity_residual_j: result.energy_identity_residual_j,
    };
    let skipped = matches!(result.report.outcome, Outcome::Skipped { .. });
    let metrics = METRICS.iter().map(|metric| if skipped { None } else { (metric.compute)(&evidence) }).collect();
    EvaluatedRun {
        metrics,
        reference_uncertainty: [reference.uncertainty_of(columns.force), reference.uncertainty_of(columns.position)],
        ended_at_s: result.report.ended_at_s,
        outcome: result.report.outcome,
        counters,
        wall: result.wall,
        trajectory: result.trajectory,
    }
}

/// All exact counters of a run, in the order of the columns in data.
pub fn counters(result: &RunResult) -> Vec<(&'static str, u64)> {
    let (mechanics, scheme) = (&result.mechanics, &result.scheme);
    vec![
        ("macro_steps", result.report.counters.macro_steps),
        ("exchanges", result.report.counters.exchanges),
        ("mechanics_steps", mechanics.micro_steps),
        ("actuator_micro_steps", result.actuator.micro_steps),
        ("eliminations", mechanics.eliminations),
        ("mechanics_lcp_solves", mechanics.solver.solves),
        ("mechanics_lcp_pivots", mechanics.solver.pivots),
        ("mechanics_lcp_factorisations", mechanics.solver.factorisations),
        ("mechanics_lcp_fallbacks", mechanics.solver.fallbacks),
        ("scheme_lcp_solves", scheme.solves),
        ("scheme_lcp_pivots", scheme.pivots),
        ("scheme_lcp_factorisations", scheme.factorisations),
        ("scheme_lcp_fallbacks", scheme.fallbacks),
    ]
}

/// The closed form at the communication points of a run, where the case has one: no error of interpolation.
fn exact_at(spec: &RunSpec, run: &Trajectory) -> Option<Trajectory> {
    let ReferenceMethod::Exact(solution) = (spec.case.reference)(&spec.parameters) else { return None };
    let solution = solution(&spec.parameters).ok()?;
    let mut exact = Trajectory::with_capacity(run.columns().to_vec(), run.len());
    run.rows().for_each(|row| solution(row[0], exact.push_row()));
    (!run.is_empty()).then_some(exact)
}

/// Positions of the gap columns among the recorded ones.
fn gap_columns(case: &Case) -> Vec<usize> {
    let columns = case.recorded_columns();
    (0..columns.len()).filter(|&index| columns[index].starts_with("gap_")).collect()
}
