//! What a run is held against, with its uncertainty.

use super::spec::RunSpec;
use super::spec::use_integrators;
use crate::cases::{Case, CoupledSystem, ExactSolution, Recorder, ReferenceMethod};
use crate::metrics::{
    ContactEvent, ContactInterval, FrictionPhase, contact_intervals, friction_phases, impulse_column, is_state,
    touch_downs,
};
use rimbench_core::cosim::{ActuatorIntegrator, Bounds, MechanicsIntegrator, PerSide, Side, StopFlag, Trajectory};
use rimbench_core::error::{Error, Result};
use rimbench_core::mechanics::{ReferenceSteps, monolithic};
use rimbench_core::solver_entry::SolverEntry;
use std::borrow::Cow;
use std::sync::Arc;

/// A run counts as diverged when an interface quantity exceeds this many times its reference maximum.
pub const DIVERGENCE_FACTOR: f64 = 3.0;

/// The finest monolithic solution, and how far to trust it.
///
/// ```text
/// p = log₂(‖u_h − u_{h/2}‖ / ‖u_{h/2} − u_{h/4}‖)             observed order
/// uncertainty = max(‖u_{h/2} − u_{h/4}‖, ½‖u_h − u_{h/2}‖) / (2^p − 1)     Richardson, with p held within [0.5, 1],
///                                                             or [0.5, 2] where the solution is of the second order
/// ```
/// The coarser pair has a say because jumps of the force move with the grid: two solutions can agree by chance there.
/// Norms are root mean squares over the stored points, column by column.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The solution with step h/4.
    pub trajectory: Trajectory,
    /// Estimated rms error of each column, in the column's unit.
    pub uncertainty: Vec<f64>,
    /// Observed order of each column; NaN where the differences vanish.
    pub order: Vec<f64>,
    /// Largest magnitude of each column.
    pub largest: Vec<f64>,
    /// What runs are judged by: time, the interface's columns and the gaps, at the same points. A run looks up as many rows as it
    /// has macro steps, and narrow rows stay in the processor's cache.
    pub judged: Trajectory,
    /// When each contact is closed, one list per gap column.
    pub contacts: Vec<Vec<ContactInterval>>,
    /// What each contact with friction does, with its state column.
    pub friction: Vec<(String, Vec<FrictionPhase>)>,
    /// Times at which a touch-down shows, from and to, s.
    pub touch_downs: Vec<[f64; 2]>,
    /// Its finest step, s.
    pub step: f64,
}

impl Reference {
    /// Refinements of the reference step: h, h/2, h/4.
    pub const REFINEMENTS: [u32; 3] = [1, 2, 4];

    /// Computes the reference of a run, one solution after the other.
    ///
    /// # Errors
    /// Bad parameters, or parameters for which the solution itself fails; [`Error::Stopped`].
    pub fn compute(spec: &RunSpec, stop: StopFlag<'_>) -> Result<Self> {
        if let Some(reference) = Self::exact(spec, stop)? {
            return Ok(reference);
        }
        let spec = &spec.of_the_reference();
        let [coarse, middle, fine] = Self::REFINEMENTS.map(|refinement| Self::solution(spec, refinement, stop));
        Self::compared(spec, [coarse?, middle?, fine?])
    }

    /// Samples the closed form of the run's case, which has no uncertainty; none if there is no closed form.
    ///
    /// # Errors
    /// Bad parameters; [`Error::Stopped`].
    pub fn exact(spec: &RunSpec, stop: StopFlag<'_>) -> Result<Option<Self>> {
        let spec = spec.of_the_reference();
        let ReferenceMethod::Exact(solution) = (spec.case.reference)(&spec.parameters)? else { return Ok(None) };
        Self::sample(&spec, &solution, stop).map(Some)
    }

    /// Tells whether a solution with one step per stored point has an event; none where no contact of the case could have it. It is a seventh
    /// of the work of the reference or less, and differs from it only where an event barely happens.
    ///
    /// # Errors
    /// As for [`compute`](Self::compute).
    pub fn has_event(spec: &RunSpec, event: ContactEvent, stop: StopFlag<'_>) -> Result<Option<bool>> {
        let reference = match Self::exact(spec, stop)? {
            Some(exact) => exact,
            None => {
                let mut coarse = spec.of_the_reference().into_owned();
                let defaults = &mut Arc::make_mut(&mut coarse.case).defaults;
                defaults.reference_step_s = defaults.reference_sampling_s;
                let solution = Self::solution(&coarse, Self::REFINEMENTS[0], stop)?;
                let unknown = vec![f64::NAN; solution.columns().len()];
                Self::of(&coarse.case, solution, unknown.clone(), unknown, f64::NAN)
            }
        };
        Ok(event.happens(&reference.contacts, &reference.friction))
    }

    /// Integrates the whole system with the reference step over `refinement`.
    ///
    /// # Errors
    /// As for [`compute`](Self::compute).
    pub fn solution(spec: &RunSpec, refinement: u32, stop: StopFlag<'_>) -> Result<Trajectory> {
        let case = &spec.case;
        // The run's own solver has no say in what it is held against: references are kept and shared.
        let mut system = (case.build)(&spec.parameters, &SolverEntry::active_set())?;
        let mut recorder = Recorder::new(case, &mut system)?.with_active_effective_mass(&mut system);
        let steps = reference_steps(spec, refinement);
        let mut trajectory = Trajectory::with_capacity(case.recorded_columns(), points(spec) + 1);
        let solved = match (case.reference)(&spec.parameters)? {
            ReferenceMethod::Own(integrate) => integrate(steps, stop, &mut trajectory),
            method @ (ReferenceMethod::Refined | ReferenceMethod::EventDriven | ReferenceMethod::Exact(_)) => {
                if matches!(method, ReferenceMethod::EventDriven) {
                    let integrators = (MechanicsIntegrator::EventSplit, ActuatorIntegrator::Midpoint);
                    if let Some(reason) = use_integrators(integrators, system.sides.lend()) {
                        return Err(Error::Incompatible(format!("the reference of case {}: {reason}", case.name)));
                    }
                }
                monolithic(system.sides.lend(), steps, stop, &mut |point| recorder.record(point, &mut trajectory))
            }
        };
        match solved {
            Ok(()) => Ok(trajectory),
            Err(failure) if failure.is_stop() => Err(Error::Stopped),
            Err(failure) => Err(Error::Incompatible(format!(
                "case {} has no reference with these parameters: the monolithic solution fails after {:.4} s ({failure})",
                case.name,
                trajectory.end_time().unwrap_or(0.0)
            ))),
        }
    }

    /// Compares the solutions of [`REFINEMENTS`](Self::REFINEMENTS), the coarsest first.
    ///
    /// # Errors
    /// Bad parameters.
    pub fn compared(spec: &RunSpec, [coarse, middle, fine]: [Trajectory; 3]) -> Result<Self> {
        let best = match (spec.case.reference)(&spec.parameters)? {
            ReferenceMethod::EventDriven => 2.0,
            _ => 1.0,
        };
        let columns = fine.columns().len();
        let distance = |a: &Trajectory, b: &Trajectory, column: usize| {
            let squares: f64 =
                a.column(column).zip(b.column(column)).map(|(x, y)| finite_difference(x, y).powi(2)).sum();
            (squares / a.len() as f64).sqrt()
        };
        let (mut uncertainty, mut order) = (Vec::with_capacity(columns), Vec::with_capacity(columns));
        for column in 0..columns {
            let (first, second) = (distance(&coarse, &middle, column), distance(&middle, &fine, column));
            let observed = libm::log2(first / second);
            let trusted = if observed.is_finite() { observed.clamp(0.5, best) } else { best };
            uncertainty.push(second.max(0.5 * first) / (libm::pow(2.0_f64, trusted) - 1.0));
            order.push(if second > 0.0 { observed } else { f64::NAN });
        }
        let finest = Self::REFINEMENTS[Self::REFINEMENTS.len() - 1];
        Ok(Self::of(&spec.case, fine, uncertainty, order, reference_steps(spec, finest).h))
    }

    /// Derives once what every run is held against.
    fn of(case: &Case, trajectory: Trajectory, uncertainty: Vec<f64>, order: Vec<f64>, step: f64) -> Self {
        let names = case.interface_columns.iter().flat_map(|row| [&row.position, &row.velocity, &row.force]);
        let mut columns = vec![0];
        columns.extend(names.filter_map(|name| trajectory.index_of(name)));
        columns.extend(gap_columns(trajectory.columns()));
        let judged = with_impulses(case, trajectory.selected(&columns));
        let contacts: Vec<_> = gap_columns(judged.columns()).map(|gap| contact_intervals(&judged, gap)).collect();
        let touch_downs = touch_downs(&contacts);
        let friction = friction_of(&trajectory);
        Reference {
            largest: largest(&trajectory),
            judged,
            touch_downs,
            contacts,
            friction,
            trajectory,
            uncertainty,
            order,
            step,
        }
    }

    fn sample(spec: &RunSpec, solution: &ExactSolution, stop: StopFlag<'_>) -> Result<Self> {
        let columns = spec.case.recorded_columns();
        let points = points(spec);
        let mut trajectory = Trajectory::with_capacity(columns, points + 1);
        for point in 0..=points {
            stop.check().map_err(|_| Error::Stopped)?;
            solution(spec.duration * point as f64 / points as f64, trajectory.push_row());
        }
        let count = trajectory.columns().len();
        Ok(Self::of(&spec.case, trajectory, vec![0.0; count], vec![f64::NAN; count], 0.0))
    }

    /// Returns the bounds beyond which a run counts as diverged: three times the largest magnitude of each coupling
    /// variable, if the case's runs are to be bounded.
    ///
    /// # Errors
    /// Those of building the case.
    pub fn bounds(&self, spec: &RunSpec) -> Result<Bounds> {
        Ok(self.bounds_of(&(spec.case.build)(&spec.parameters, &spec.solver)?))
    }

    /// Returns the bounds of a system that is at hand.
    pub(super) fn bounds_of(&self, system: &CoupledSystem) -> Bounds {
        PerSide::from_fn(|side: Side| {
            let outputs = system.sides[side].ports().outputs.iter();
            outputs
                .map(|port| match self.trajectory.index_of(&port.name) {
                    Some(column) if !system.unbounded => {
                        DIVERGENCE_FACTOR * self.largest[column].max(port.quantity.negligible())
                    }
                    _ => f64::INFINITY,
                })
                .collect()
        })
    }

    /// When the contact of a gap column is closed, if the reference has that column.
    pub fn contacts_of(&self, gap: &str) -> Option<&Vec<ContactInterval>> {
        let column = gap_columns(self.judged.columns()).position(|index| self.judged.columns()[index] == gap)?;
        self.contacts.get(column)
    }

    /// Returns what the contact with the state column `state` does; none if the reference does not know it.
    pub fn friction_of(&self, state: &str) -> Option<&Vec<FrictionPhase>> {
        self.friction.iter().find(|(name, _)| name == state).map(|(_, phases)| phases)
    }

    /// Returns the largest magnitude of a column while a touch-down shows; 0 where none does.
    pub fn touch_down_peak(&self, column: &str) -> f64 {
        let Some(index) = self.judged.index_of(column) else { return 0.0 };
        let near = |t: f64| self.touch_downs.iter().any(|[from, to]| (*from..=*to).contains(&t));
        self.judged.rows().filter(|row| near(row[0])).map(|row| row[index].abs()).fold(0.0, f64::max)
    }

    /// Returns the uncertainty of a column by name.
    pub fn uncertainty_of(&self, column: &str) -> Option<f64> {
        self.trajectory.index_of(column).map(|index| self.uncertainty[index])
    }

    /// Returns all of it as numbers, to be kept: the rows, then what is known about the columns, then the step, because
    /// what is read back is cut off from the end.
    pub fn pack(&self) -> Vec<f64> {
        [self.trajectory.data(), &self.uncertainty, &self.order, &[self.step]].concat()
    }

    /// Reads back what [`pack`](Self::pack) made of a reference of this case; none if the numbers do not fit.
    pub fn unpack(case: &Case, mut data: Vec<f64>) -> Option<Self> {
        let columns = case.recorded_columns();
        let n = columns.len();
        let step = data.pop()?;
        let order = data.split_off(data.len().checked_sub(n)?);
        let uncertainty = data.split_off(data.len().checked_sub(n)?);
        if data.is_empty() || !data.len().is_multiple_of(n) {
            return None;
        }
        Some(Self::of(case, Trajectory::from_data(columns, data), uncertainty, order, step))
    }
}

impl RunSpec {
    /// The run whose reference this one is held against: that of the case that judges, if another does.
    pub fn of_the_reference(&self) -> Cow<'_, RunSpec> {
        match &self.case.judged_by {
            None => Cow::Borrowed(self),
            Some(judge) => Cow::Owned(RunSpec { case: judge.clone(), ..self.clone() }),
        }
    }

    /// Tells whether two runs are held against the same reference.
    pub fn shares_reference_with(&self, other: &RunSpec) -> bool {
        self.case.name == other.case.name
            && self.case.defaults == other.case.defaults
            && self.duration == other.duration
            && self.parameters == other.parameters
    }
}

/// Stored points of a reference, the first one aside.
fn points(spec: &RunSpec) -> usize {
    (spec.duration / spec.case.defaults.reference_sampling_s).ceil().max(1.0) as usize
}

/// The steps that are taken: they divide the duration, in multiples of the stored points, and are no longer than asked.
fn reference_steps(spec: &RunSpec, refinement: u32) -> ReferenceSteps {
    let defaults = spec.case.defaults;
    let asked = defaults.reference_sampling_s / defaults.reference_step_s;
    // Slack for a quotient that is whole up to round-off.
    let every = (asked * (1.0 - 1e-9)).ceil().max(1.0) as usize * refinement as usize;
    let steps = points(spec) * every;
    ReferenceSteps { h: spec.duration / steps as f64, steps, every }
}

/// Adds the running integral of each interface force, by the trapezoidal rule over the stored points.
fn with_impulses(case: &Case, judged: Trajectory) -> Trajectory {
    let forces: Vec<usize> = case.interface_columns.iter().filter_map(|row| judged.index_of(&row.force)).collect();
    let mut columns = judged.columns().to_vec();
    columns.extend(forces.iter().map(|&force| impulse_column(&judged.columns()[force])));
    let mut extended = Trajectory::with_capacity(columns, judged.len());
    let mut impulses = vec![0.0; forces.len()];
    let width = judged.columns().len();
    for k in 0..judged.len() {
        let row = judged.row(k);
        if k > 0 {
            let before = judged.row(k - 1);
            for (impulse, &force) in impulses.iter_mut().zip(&forces) {
                *impulse += 0.5 * (row[0] - before[0]) * (row[force] + before[force]);
            }
        }
        let out = extended.push_row();
        out[..width].copy_from_slice(row);
        out[width..].copy_from_slice(&impulses);
    }
    extended
}

/// Positions of the gap columns among the recorded ones.
pub(super) fn gap_columns(columns: &[String]) -> impl Iterator<Item = usize> + '_ {
    (0..columns.len()).filter(|&index| columns[index].starts_with("gap_"))
}

/// What each contact with friction does, with its state column.
pub(super) fn friction_of(trajectory: &Trajectory) -> Vec<(String, Vec<FrictionPhase>)> {
    let states = trajectory.columns().iter().enumerate().filter(|(_, name)| is_state(name));
    states.map(|(column, name)| (name.clone(), friction_phases(trajectory, column))).collect()
}

/// Largest magnitude of each column.
fn largest(trajectory: &Trajectory) -> Vec<f64> {
    let mut largest = vec![0.0_f64; trajectory.columns().len()];
    for row in trajectory.rows() {
        for (largest, value) in largest.iter_mut().zip(row) {
            *largest = largest.max(value.abs());
        }
    }
    largest
}

/// Difference that treats equal infinities (a locked interface in both) as agreeing.
fn finite_difference(x: f64, y: f64) -> f64 {
    if x == y || (x.is_nan() && y.is_nan()) { 0.0 } else { x - y }
}
