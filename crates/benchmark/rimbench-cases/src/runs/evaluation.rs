//! A run held against its reference: metrics and counters by name.

use super::findings::{Costs, Findings, Latency};
use super::predicted_growth::predicted_growth;
use super::reference::{GAP, Reference, friction_of};
use super::simulation::RunResult;
use super::spec::RunSpec;
use crate::cases::{Case, ReferenceMethod};
use crate::metrics::{Evidence, Inside, InterfaceRow, METRICS, Metric, Only, contact_intervals};
use rimbench_core::cosim::{Jump, Outcome, StopFlag, Trajectory};
use rimbench_core::error::{Error, Failure, Result};
use std::sync::Arc;

/// What is kept of a run: its outcome, every metric, every counter.
#[derive(Debug, Clone)]
pub struct EvaluatedRun {
    /// How it ended.
    pub outcome: Outcome,
    /// What was found.
    pub found: Findings,
    /// What it cost on this machine.
    pub costs: Costs,
    /// The jump that created most, of those that did, in an audited run.
    pub largest_jump: Option<Jump>,
    /// The trajectory.
    pub trajectory: Trajectory,
}

impl EvaluatedRun {
    /// Makes the record of a run of which nothing is known but how it ended.
    pub fn not_evaluated(outcome: Outcome) -> Self {
        EvaluatedRun {
            found: Findings::nothing(&outcome),
            outcome,
            costs: Costs::default(),
            largest_jump: None,
            trajectory: Trajectory::with_capacity(Vec::new(), 0),
        }
    }

    /// Lists the metrics that the case of the run has, each with its value; nothing where it does not apply to this run.
    pub fn metrics_of(&self, case: &Case) -> impl Iterator<Item = (&'static Metric, Option<f64>)> + '_ {
        let friction = case.records_friction();
        let all = METRICS.iter().zip(self.found.metrics.iter().copied());
        all.filter(move |(metric, value)| match metric.only {
            Some(Only::Friction) => friction,
            Some(Only::Claimed) => false,
            only => value.is_some() || only.is_none(),
        })
    }
}

/// Computes all metrics of a run.
///
/// # Errors
/// Those of the case's closed form; a case that does not record its interface.
pub fn evaluate(spec: &RunSpec, result: RunResult, reference: &Reference) -> Result<EvaluatedRun> {
    let columns = &spec.case.interface_columns;
    let column = |name: &str| {
        let unknown =
            || Error::Incompatible(format!("case {} records no column `{name}` of its interface", spec.case.name));
        result.trajectory.index_of(name).ok_or_else(unknown)
    };
    let interface = columns
        .iter()
        .map(|row| {
            Ok(InterfaceRow {
                position: column(&row.position)?,
                velocity: column(&row.velocity)?,
                force: column(&row.force)?,
                reference_force_peak: reference.force_peak(&spec.case, &row.force).known(),
                reference_touch_down_peak: reference
                    .peak_of(&spec.case, &row.force, reference.touch_down_peak(&row.force))
                    .known(),
            })
        })
        .collect::<Result<Vec<InterfaceRow>>>()?;
    let names = result.trajectory.columns();
    let (gaps, least_gaps): (Vec<usize>, Vec<usize>) = (0..names.len())
        .filter(|&gap| names[gap].starts_with(GAP))
        .partition(|&gap| reference.is_contact_gap(&names[gap]));
    let exact = exact_at(spec, reference, result.trajectory.column(0))?;
    let all = || (0..reference.judged.columns().len()).collect();
    let aligned = exact.unwrap_or_else(|| reference.judged_at(all(), result.trajectory.column(0)));
    let reference_contacts: Vec<_> = gaps
        .iter()
        .map(|&gap| reference.contacts_of(&result.trajectory.columns()[gap]).cloned().unwrap_or_default())
        .collect();
    let run_contacts: Vec<_> = gaps.iter().map(|&gap| contact_intervals(&result.trajectory, gap)).collect();
    // A reference from outside may not say who sticks, and that of another case may have its columns in another order.
    let (run_friction, reference_friction): (Vec<_>, Vec<_>) = friction_of(&result.trajectory)
        .into_iter()
        .filter_map(|(contact, phases)| Some((phases, reference.friction_of(&contact)?.clone())))
        .unzip();
    let inside = match result.report.inside.as_ref().filter(|log| !log.is_empty()) {
        Some(log) => Some(Inside {
            log,
            reference: [reference_at(spec, reference, log, 0)?, reference_at(spec, reference, log, 1)?],
        }),
        None => None,
    };
    // Code from outside is not built once more.
    let predicted_growth = match spec.predict_growth && !spec.case.from_outside {
        // What did not get beyond its start may be what cannot be linearised there, and the outcome says why.
        true if result.report.ended_at_s == 0.0 => None,
        true => predicted_growth(spec)?.map(|(growth, _)| growth),
        false => None,
    };
    let evidence = Evidence {
        run: &result.trajectory,
        reference: &aligned,
        run_contacts: &run_contacts,
        reference_contacts: &reference_contacts,
        run_friction: &run_friction,
        reference_friction: &reference_friction,
        report: &result.report,
        audited: spec.audit,
        interface: &interface,
        effective_mass: result.trajectory.index_of("effective_mass_kg"),
        gaps: &gaps,
        least_gaps: &least_gaps,
        touch_downs: &reference.touch_downs,
        inside: inside.as_ref(),
        half_steps: &half_steps(spec, &result.trajectory),
        predicted_growth,
    };
    let skipped = matches!(result.report.outcome, Outcome::Skipped { .. });
    let metrics: Box<[Option<f64>]> =
        METRICS.iter().map(|metric| if skipped { None } else { (metric.compute)(&evidence) }).collect();
    // A run whose account of energy or errors cannot be drawn up has not come to its end within bounds, whatever its interface quantities say.
    let all = METRICS.iter().zip(&metrics);
    let not_finite =
        all.filter(|(metric, value)| value.is_some_and(|value| !value.is_finite()) && !metric.may_be_infinite());
    let not_finite = not_finite.map(|(metric, _)| metric.name).next();
    let outcome = match (result.report.outcome, result.report.audit.not_finite().or(not_finite)) {
        (Outcome::Completed, Some(quantity)) => {
            Outcome::from_failure(Failure::non_finite(quantity), result.report.ended_at_s)
        }
        (outcome, _) => outcome,
    };
    let ended_at_s = result.report.ended_at_s;
    let latency = Latency::of(result.report.latencies_s, spec.macro_step);
    Ok(EvaluatedRun {
        found: Findings {
            ended_at_s,
            model_exact: spec.model_is_exact(),
            metrics,
            reference_uncertainty: [
                columns.iter().filter_map(|row| reference.uncertainty_of(&row.force)).reduce(f64::max),
                columns.iter().filter_map(|row| reference.uncertainty_of(&row.position)).reduce(f64::max),
            ],
            work: result.report.work,
            ..Findings::nothing(&outcome)
        },
        costs: Costs::of(ended_at_s, result.wall.as_secs_f64(), latency),
        largest_jump: result.report.audit.model.and_then(|model| model.largest),
        outcome,
        trajectory: result.trajectory,
    })
}

/// See [`Evidence::half_steps`].
fn half_steps(spec: &RunSpec, run: &Trajectory) -> Vec<f64> {
    let half = |length: f64| match spec.mechanics_integrator.second_order() {
        Some(_) => 0.0,
        None => 0.5 * length / spec.mechanics_steps.within(length, spec.micro_step) as f64,
    };
    // Nothing has been stepped at the start.
    let lengths = run.column(0).skip(1).zip(run.column(0)).map(|(end, start)| end - start);
    std::iter::once(0.0).chain(lengths.map(half)).collect()
}

/// The closed form at the communication points of a run, where the case has one: no error of interpolation.
fn exact_at(
    spec: &RunSpec,
    reference: &Reference,
    times: impl ExactSizeIterator<Item = f64>,
) -> Result<Option<Arc<Trajectory>>> {
    let case = &spec.of_the_reference().case;
    let ReferenceMethod::Exact(solution) = (case.reference)(&spec.parameters)? else { return Ok(None) };
    let mut exact = Trajectory::with_capacity(reference.trajectory.columns().to_vec(), times.len());
    times.for_each(|time| solution(time, StopFlag::never(), exact.push_row()));
    Ok((!exact.is_empty()).then(|| Arc::new(exact)))
}

/// Forces (`time` 0) or positions (`time` 1) of the reference's interface at the times in that column of the log.
fn reference_at(spec: &RunSpec, reference: &Reference, log: &Trajectory, time: usize) -> Result<Arc<Trajectory>> {
    if let Some(exact) = exact_at(spec, reference, log.column(time))? {
        return Ok(exact);
    }
    let names = spec.case.interface_columns.iter().map(|row| if time == 0 { &row.force } else { &row.position });
    let columns = names.filter_map(|name| reference.judged.index_of(name));
    Ok(reference.judged_at(std::iter::once(0).chain(columns).collect(), log.column(time)))
}
