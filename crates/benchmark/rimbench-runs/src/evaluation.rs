//! A run held against its reference: metrics and counters by name.

use super::findings::{Costs, Findings, Latency};
use super::predicted_growth::predicted_growth;
use super::reference::{GAP, Reference};
use super::run_result::RunResult;
use super::spec::RunSpec;
use crate::metrics::{Columns, Evidence, InterfaceRow, METRICS, Metric, Only, Sums};
use rimbench_cases::cases::{Case, ExactSolution, InterfaceColumns, ReferenceMethod};
use rimbench_core::cosim::{Jump, Outcome, StopFlag, Trajectory};
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::mechanics::is_contact_state;
use std::ops::Range;
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
    /// Why its error is not divided, where that was asked.
    pub undivided: Option<String>,
    /// The jump that created most, of those that did, in an audited run.
    pub largest_jump: Option<Jump>,
    /// The trajectory; of a run that was judged as it went on without a trace its last rows.
    pub trajectory: Trajectory,
}

impl EvaluatedRun {
    /// Makes the record of a run of which nothing is known but how it ended.
    pub fn not_evaluated(outcome: Outcome) -> Self {
        EvaluatedRun {
            found: Findings::nothing(&outcome),
            outcome,
            costs: Costs::default(),
            undivided: None,
            largest_jump: None,
            trajectory: Trajectory::with_capacity(Vec::new(), 0),
        }
    }

    /// Lists the metrics that the case of the run has, each with its value; nothing where it does not apply to this
    /// run.
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
    let mut judge = Judge::new(spec, reference, result.trajectory.columns())?;
    judge.add(&result.trajectory, 0..result.trajectory.len(), &result.interface_residual);
    judge.finish(result)
}

/// Rows after which a judge looks at them.
pub(super) const BLOCK: usize = 1024;

/// Holds a run against its reference as it goes on.
pub(super) struct Judge<'a> {
    spec: &'a RunSpec,
    reference: &'a Reference,
    exact: Option<ExactSolution>,
    names: Vec<String>,
    sums: Sums,
}

impl<'a> Judge<'a> {
    /// Makes the judge of a run that records these columns.
    pub(super) fn new(spec: &'a RunSpec, reference: &'a Reference, names: &[String]) -> Result<Self> {
        let place = |name: &str| names.iter().position(|known| known == name);
        let column = |name: &str| {
            let unknown =
                || Error::Incompatible(format!("case {} records no column `{name}` of its interface", spec.case.name));
            place(name).ok_or_else(unknown)
        };
        let row = |row: &InterfaceColumns| {
            let touch_down_peak = reference.touch_down_peak(&row.force);
            Ok(InterfaceRow {
                position: column(&row.position)?,
                velocity: column(&row.velocity)?,
                force: column(&row.force)?,
                reference_force_peak: reference.force_peak(&spec.case, &row.force).known(),
                reference_touch_down_peak: reference.peak_of(&spec.case, &row.force, touch_down_peak).known(),
            })
        };
        let all = 0..names.len();
        let (gaps, least_gaps) = all
            .clone()
            .filter(|&gap| names[gap].starts_with(GAP))
            .partition(|&gap| reference.is_contact_gap(&names[gap]));
        let columns = Columns {
            interface: spec.case.interface_columns.iter().map(row).collect::<Result<_>>()?,
            effective_mass: place("effective_mass_kg"),
            gaps,
            least_gaps,
            // A reference from outside may not say who sticks.
            states: all
                .filter(|&state| is_contact_state(&names[state]) && reference.friction_of(&names[state]).is_some())
                .collect(),
            touch_downs: reference.touch_downs.clone(),
            first_order: match spec.mechanics_integrator.second_order() {
                Some(_) => None,
                None => Some((spec.mechanics_steps, spec.micro_step)),
            },
            each_force_error: spec.step_control.is_some_and(|rule| rule.control.by_defect()),
        };
        let exact = match (spec.of_the_reference().case.reference)(&spec.parameters)? {
            ReferenceMethod::Exact(solution) => Some(solution),
            _ => None,
        };
        Ok(Judge { spec, reference, exact, names: names.to_vec(), sums: Sums::new(columns) })
    }

    /// Divides the force error of the run by the forces of its centre, row by row of the interface.
    pub(super) fn divide_by(&mut self, centre: Vec<Vec<f64>>) {
        self.sums.centre = centre;
    }

    /// Looks at `rows` of a run, with the interface residual of each from the first on, J, if it is counted.
    pub(super) fn add(&mut self, run: &Trajectory, rows: Range<usize>, residuals: &[f64]) {
        for start in rows.clone().step_by(BLOCK) {
            let block = start..rows.end.min(start + BLOCK);
            let times = run.column_of(block.clone(), 0);
            let aligned = self.reference_at((0..self.reference.judged.columns().len()).collect(), times);
            let residuals = residuals.get(start - rows.start..).unwrap_or_default();
            self.sums.add(run, block, &aligned, residuals);
        }
    }

    /// Looks at micro steps of the actuator.
    pub(super) fn add_inside(&mut self, log: &Trajectory) {
        let interface = &self.spec.case.interface_columns;
        let columns = |name: fn(&InterfaceColumns) -> &str| -> Vec<usize> {
            let places = interface.iter().filter_map(|row| self.reference.judged.index_of(name(row)));
            std::iter::once(0).chain(places).collect()
        };
        let [forces, positions] = [columns(|row| &row.force), columns(|row| &row.position)];
        let at_start = self.reference_at(forces, log.column(0));
        let in_middle = self.reference_at(positions, log.column(1));
        self.sums.add_inside(&self.names, log, [&at_start, &in_middle]);
    }

    /// The reference at times of a run; the closed form where the case has one: no error of interpolation.
    fn reference_at(&self, columns: Vec<usize>, times: impl ExactSizeIterator<Item = f64> + Clone) -> Arc<Trajectory> {
        let Some(exact) = &self.exact else { return self.reference.judged_at(columns, times) };
        let mut rows = Trajectory::with_capacity(self.reference.trajectory.columns().to_vec(), times.len());
        times.for_each(|time| exact(time, StopFlag::never(), rows.push_row()));
        Arc::new(rows)
    }

    /// Computes all metrics of the run, of whose rows all have been looked at.
    ///
    /// # Errors
    /// Those of predicting how the coupling grows.
    pub(super) fn finish(mut self, result: RunResult) -> Result<EvaluatedRun> {
        if let Some(log) = &result.report.inside {
            (0..log.len()).step_by(BLOCK).for_each(|start| self.add_inside(&log.slice(start, BLOCK)));
        }
        let Judge { spec, reference, names, sums, .. } = self;
        let name = |column: &usize| &names[*column];
        let reference_contacts: Vec<_> = sums
            .columns()
            .gaps
            .iter()
            .map(|gap| reference.contacts_of(name(gap)).cloned().unwrap_or_default())
            .collect();
        let states = sums.columns().states.iter();
        let reference_friction: Vec<_> =
            states.filter_map(|state| reference.friction_of(name(state)).cloned()).collect();
        // A prediction builds the case again, which code from outside need not survive.
        let predicted_growth = match spec.predict_growth && !spec.case.from_outside {
            // A run that failed at its start may fail to be linearised there; its outcome says why.
            true if result.report.ended_at_s == 0.0 => None,
            true => predicted_growth(spec)?.map(|(growth, _)| growth),
            false => None,
        };
        let evidence = Evidence {
            sums: &sums,
            run_contacts: &sums.contacts().map(|contact| contact.found.clone()).collect::<Vec<_>>(),
            reference_contacts: &reference_contacts,
            run_friction: &sums.friction().map(|contact| contact.found.clone()).collect::<Vec<_>>(),
            reference_friction: &reference_friction,
            report: &result.report,
            audited: spec.audit,
            predicted_growth,
        };
        let skipped = matches!(result.report.outcome, Outcome::Skipped { .. });
        let metrics: Box<[Option<f64>]> =
            METRICS.iter().map(|metric| if skipped { None } else { (metric.compute)(&evidence) }).collect();
        evaluated(spec, result, reference, metrics)
    }
}

/// Says how the run ended, with what was measured, and puts its record together.
fn evaluated(
    spec: &RunSpec,
    result: RunResult,
    reference: &Reference,
    metrics: Box<[Option<f64>]>,
) -> Result<EvaluatedRun> {
    let columns = &spec.case.interface_columns;
    // A run whose account of energy or errors cannot be drawn up has not come to its end within bounds, whatever its
    // interface quantities say.
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
    let latency = result.report.latencies.as_ref().and_then(Latency::of);
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
        undivided: None,
        largest_jump: result.report.audit.model.and_then(|model| model.largest),
        outcome,
        trajectory: result.trajectory,
    })
}
