//! A run held against its reference: metrics and counters by name.

use super::reference::{Reference, gap_columns};
use super::run::{RunResult, RunSpec};
use rimbench_cases::cases::ReferenceMethod;
use rimbench_cases::metrics::{Evidence, InterfaceRow, METRICS, contact_intervals};
use rimbench_core::cosim::{Latency, Outcome, Trajectory};
use std::any::Any;
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
    /// Uncertainty of the reference's interface force, N, and position, m; of several rows the largest.
    pub reference_uncertainty: [Option<f64>; 2],
    /// One value per entry of [`COUNTERS`].
    pub counters: [u64; COUNTERS.len()],
    /// Wall time of the macro loop.
    pub wall: Duration,
    /// Latency of its macro steps; deadline H.
    pub latency: Option<Latency>,
    /// The trajectory.
    pub trajectory: Trajectory,
}

impl EvaluatedRun {
    /// The record of a run that panicked: our bug, but no reason to lose the other runs.
    pub(super) fn panicked(spec: &RunSpec, panic: &(dyn Any + Send)) -> Self {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        // A record is one line.
        let message = text.unwrap_or("no message").replace(char::is_control, " ");
        EvaluatedRun {
            outcome: Outcome::Panicked { message },
            ended_at_s: 0.0,
            metrics: vec![None; METRICS.len()],
            reference_uncertainty: [None; 2],
            counters: [0; COUNTERS.len()],
            wall: Duration::ZERO,
            latency: None,
            trajectory: Trajectory::with_capacity(spec.case.recorded_columns(), 0),
        }
    }

    /// Simulated time over wall time.
    pub fn real_time_factor(&self) -> f64 {
        self.ended_at_s / self.wall.as_secs_f64()
    }
}

/// Computes all metrics of a run.
pub fn evaluate(spec: &RunSpec, result: RunResult, reference: &Reference) -> EvaluatedRun {
    let counters = counters(&result);
    let columns = spec.case.interface_columns;
    let column = |name: &str| result.trajectory.index_of(name).unwrap_or(0);
    let interface: Vec<InterfaceRow> = columns
        .iter()
        .map(|row| InterfaceRow {
            position: column(row.position),
            velocity: column(row.velocity),
            force: column(row.force),
            reference_force_peak: reference.largest[column(row.force)],
        })
        .collect();
    let gaps: Vec<usize> = gap_columns(result.trajectory.columns()).collect();
    let aligned =
        exact_at(spec, &result.trajectory).unwrap_or_else(|| reference.judged.resampled(result.trajectory.column(0)));
    let run_contacts: Vec<_> = gaps.iter().map(|&gap| contact_intervals(&result.trajectory, gap)).collect();
    let evidence = Evidence {
        run: &result.trajectory,
        reference: &aligned,
        run_contacts: &run_contacts,
        reference_contacts: &reference.contacts,
        report: &result.report,
        interface: &interface,
        effective_mass: result.trajectory.index_of("effective_mass_kg"),
        gaps: &gaps,
        energy_identity_residual_j: result.energy_identity_residual_j,
    };
    let skipped = matches!(result.report.outcome, Outcome::Skipped { .. });
    let metrics = METRICS.iter().map(|metric| if skipped { None } else { (metric.compute)(&evidence) }).collect();
    EvaluatedRun {
        metrics,
        reference_uncertainty: [
            columns.iter().filter_map(|row| reference.uncertainty_of(row.force)).reduce(f64::max),
            columns.iter().filter_map(|row| reference.uncertainty_of(row.position)).reduce(f64::max),
        ],
        ended_at_s: result.report.ended_at_s,
        outcome: result.report.outcome,
        counters,
        wall: result.wall,
        latency: Latency::of(result.report.latencies_s, spec.macro_step),
        trajectory: result.trajectory,
    }
}

/// Names of the exact counters, in the order of the columns in data.
pub const COUNTERS: [&str; 14] = [
    "macro_steps",
    "repeated_macro_steps",
    "exchanges",
    "mechanics_micro_steps",
    "actuator_micro_steps",
    "eliminations",
    "mechanics_lcp_solves",
    "mechanics_lcp_pivots",
    "mechanics_lcp_factorisations",
    "mechanics_lcp_fallbacks",
    "scheme_lcp_solves",
    "scheme_lcp_pivots",
    "scheme_lcp_factorisations",
    "scheme_lcp_fallbacks",
];

/// The counters of a run, in the order of [`COUNTERS`].
fn counters(result: &RunResult) -> [u64; COUNTERS.len()] {
    let (mechanics, scheme) = (&result.mechanics, &result.scheme);
    [
        result.report.counters.macro_steps,
        result.report.counters.repeated_macro_steps,
        result.report.counters.exchanges,
        mechanics.micro_steps,
        result.actuator.micro_steps,
        mechanics.eliminations,
        mechanics.solver.solves,
        mechanics.solver.pivots,
        mechanics.solver.factorisations,
        mechanics.solver.fallbacks,
        scheme.solves,
        scheme.pivots,
        scheme.factorisations,
        scheme.fallbacks,
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
