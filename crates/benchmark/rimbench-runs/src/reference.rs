//! What a run is held against, with its uncertainty.

use super::samples::Samples;
use super::spec::RunSpec;
use super::spec::use_integrators;
use crate::metrics::{
    ContactEvent, ContactInterval, FrictionPhase, contact_intervals, friction_phases, impulse_column, touch_downs,
};
use rimbench_cases::cases::{Case, CoupledSystem, ExactSolution, InterfaceColumns, Recorder, ReferenceMethod, Scale};
use rimbench_cases::parameter::without_unit;
use rimbench_core::cosim::{
    ActuatorIntegrator, Bounds, MechanicsIntegrator, PerSide, Port, Quantity, Side, StopFlag, Trajectory,
};
use rimbench_core::error::{Cause, Error, Result};
use rimbench_core::mechanics::{Due, ReferenceSteps, is_contact_state, monolithic_with_events};
use rimbench_core::solver_entry::SolverEntry;
use std::borrow::Cow;
use std::sync::Arc;

/// A run counts as diverged when an interface quantity exceeds this many times its reference maximum.
pub const DIVERGENCE_FACTOR: f64 = 3.0;

/// Share of a case's own scale that counts as the maximum of a reference that stays below it, where divergence is
/// judged: of a system near rest, the first macro step under a held force moves more than all of the reference. Ours.
const STIRRED: f64 = 0.1;

/// Share of a case's own scale below which a peak is none to relate an error to. Ours.
const NO_PEAK: f64 = 1e-6;

/// How many times its uncertainty a peak must be to relate an error to: the first digit of it is known then. Ours.
const KNOWN_PEAK: f64 = 10.0;

/// The peak of a column of a reference, as far as it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Peak {
    /// Known to its first digit: errors can be related to it.
    Known(f64),
    /// Below a millionth of the case's own scale: the peak counts as zero.
    Nothing,
    /// Not ten times its uncertainty.
    NotKnown,
}

impl Peak {
    /// Returns it where it is known.
    pub fn known(self) -> Option<f64> {
        match self {
            Peak::Known(peak) => Some(peak),
            Peak::Nothing | Peak::NotKnown => None,
        }
    }
}

/// Rounding of a value that a side computes, relative to the largest of its column and to the case's own scale.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Columns that are infinite, or no number, where an interface is locked or a mass is none: data, and no lack of it.
const MAY_BE_INFINITE: &str = "effective_mass";

/// The finest monolithic solution, and how far to trust it.
///
/// ```text
/// p = log₂(‖u_h − u_{h/2}‖ / ‖u_{h/2} − u_{h/4}‖)             observed order
/// uncertainty = max(‖u_{h/2} − u_{h/4}‖, ½‖u_h − u_{h/2}‖) / (2^p − 1)     Richardson, with p held within [0.5, 1],
///                                                             or [0.5, 2] where the solution is of the second order
/// ```
/// The coarser pair has a say because jumps of the force move with the grid: two solutions can agree by chance there.
/// Norms are root mean squares over the stored points, column by column. No column of the interface is known better
/// than to rounding, not even by a closed form, and differences that are rounding have no order. Every value is finite
/// but an effective mass, or there is no reference.
///
/// Between its rows the reference is cubic, piece by piece ([`Trajectory::columns_at`]): located events have two rows,
/// before and after. Leaving out every second row tells what lies between them, also of jumps that no event was located
/// for:
/// ```text
/// d = ‖u(t_k) − (cubic through the other rows)(t_k)‖,  k odd         uncertainty = √(uncertainty² + ½ d²)
/// ```
/// The error of a jump somewhere between two rows has order ½ in their distance, and all others vanish faster.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The solution with step h/4, at equal distances.
    pub trajectory: Trajectory,
    /// What runs are judged by before and after each located event: time, the interface's columns and the gaps.
    pub events: Trajectory,
    /// Estimated rms error of each column, in the column's unit.
    pub uncertainty: Vec<f64>,
    /// Observed order of each column; NaN where the differences vanish.
    pub order: Vec<f64>,
    /// Largest magnitude of each column.
    pub largest: Vec<f64>,
    /// What runs are judged by: time, the interface's columns and the gaps, at the same points and at events. A run
    /// looks up as many rows as it has macro steps, and narrow rows stay in the processor's cache.
    pub judged: Trajectory,
    /// When each contact is closed, one list per gap column.
    pub contacts: Vec<Vec<ContactInterval>>,
    /// What each contact with friction does, with its state column.
    pub friction: Vec<(String, Vec<FrictionPhase>)>,
    /// Times at which a touch-down shows, from and to, s.
    pub touch_downs: Vec<[f64; 2]>,
    /// Largest magnitude of each column of `judged` while a touch-down shows; 0 where none does.
    touch_down_peaks: Vec<f64>,
    /// Its finest step, s.
    pub step: f64,
    /// Gap columns that are the gap of one contact each; others hold the least of several.
    contact_gaps: Vec<String>,
    /// What was made of `judged` for the times of runs.
    samples: Samples,
}

/// A solution of a whole system.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Its rows at equal distances.
    pub rows: Trajectory,
    /// Two rows of each event that was located, before and after it; no more in all than there are others.
    pub events: Trajectory,
}

/// What to do about a problem that was not solved, with these parameters changed from their defaults.
fn way_out(cause: &Cause, changed: &str) -> String {
    let to = match cause {
        Cause::SolverFailed { .. } => format!("the tolerance is {:e}", SolverEntry::active_set().tolerance),
        Cause::NotConverged { .. } | Cause::Singular { .. } => "force and motion must agree to 1e-12".to_owned(),
        _ => return String::new(),
    };
    if changed.is_empty() {
        return String::new();
    }
    format!(
        "; {to}, and changed from its default is {changed}: take a value nearer to it, as ratios of masses or stiffnesses of 1e8 and \
         more leave too few of 16 digits"
    )
}

impl Reference {
    /// Refinements of the reference step: h, h/2, h/4.
    pub const REFINEMENTS: [u32; 3] = [1, 2, 4];

    /// Computes the reference of a run, one solution after the other.
    ///
    /// # Errors
    /// Bad parameters, or parameters for which the solution itself fails or is [not known](Self::check);
    /// [`Error::Stopped`].
    pub fn compute(spec: &RunSpec, stop: StopFlag<'_>) -> Result<Self> {
        if let Some(reference) = Self::exact(spec, stop)? {
            return Ok(reference);
        }
        let spec = &spec.of_the_reference();
        let [coarse, middle, fine] = Self::REFINEMENTS.map(|refinement| Self::solution(spec, refinement, stop));
        let reference = Self::compared(spec, [coarse?, middle?, fine?], stop)?;
        reference.check(spec)?;
        Ok(reference)
    }

    /// Computes it by steps and rows so many times as long, and brings it to the rows of the reference: by 1 and 1 it is
    /// that.
    ///
    /// # Errors
    /// As for [`compute`](Self::compute).
    pub fn coarse(spec: &RunSpec, [steps, rows]: [f64; 2], stop: StopFlag<'_>) -> Result<Self> {
        let spec = &spec.of_the_reference();
        let mut case = Case::clone(&spec.case);
        case.defaults.reference_step_s *= steps;
        case.defaults.reference_sampling_s *= rows;
        let found = Self::compute(&spec.of_case(Arc::new(case)), stop)?;
        if rows == 1.0 {
            return Ok(found);
        }
        let times = (0..points(spec) + 1).map(|point| spec.duration * point as f64 / points(spec) as f64);
        let mut there = found.trajectory.resampled(times.clone());
        let judged = found.judged.resampled(times);
        let columns = judged_columns(&spec.case, &there, &found.contact_gaps);
        for (row, known) in there.rows_mut().zip(judged.rows()) {
            columns.iter().zip(known).for_each(|(&column, value)| row[column] = *value);
        }
        let rows = [there, found.events];
        Ok(Self::of(&spec.case, rows, found.uncertainty, found.order, found.step, found.contact_gaps))
    }

    /// Checks that it is known what runs are held against: no force and no position of the interface is uncertain by
    /// more than a tenth of its peak, where that is above the case's own scale. A run that is unbounded is not held
    /// against it, but against its own energy.
    ///
    /// # Errors
    /// [`Error::Incompatible`] naming the column; those of building the case.
    pub fn check(&self, spec: &RunSpec) -> Result<()> {
        match self.check_rows(&spec.case) {
            Err(_) if spec.is_unbounded()? => Ok(()),
            checked => checked,
        }
    }

    fn check_rows(&self, case: &Case) -> Result<()> {
        let of_row =
            |row: &InterfaceColumns| [(row.force.clone(), Quantity::Force), (row.position.clone(), Quantity::Position)];
        for (name, quantity) in case.interface_columns.iter().flat_map(of_row) {
            let Some(column) = self.trajectory.index_of(&name) else { continue };
            let (peak, uncertainty) = (self.largest[column], self.uncertainty[column]);
            // A single solution has no others to estimate its uncertainty from.
            let unknown = uncertainty.is_nan() || self.peak_of(case, &name, peak) != Peak::NotKnown;
            if !unknown && peak > case.scale_of(&name).unwrap_or(quantity.negligible()) {
                let unit = without_unit(&name).1;
                let uncertain = match uncertainty / peak {
                    share if share.is_finite() => {
                        format!(
                            "is uncertain by {uncertainty:.1e} {unit}, {share:.1e} of its peak, and may be by a tenth of it"
                        )
                    }
                    _ => format!("is uncertain by more than any number: its peak is {peak:.1e} {unit}"),
                };
                return Err(Error::Incompatible(format!(
                    "case {} has no reference with these parameters: its {name} {uncertain}",
                    case.name
                )));
            }
        }
        Ok(())
    }

    /// Samples the closed form of the run's case, which is uncertain by rounding; none if there is no closed form.
    ///
    /// # Errors
    /// Bad parameters; [`Error::Stopped`].
    pub fn exact(spec: &RunSpec, stop: StopFlag<'_>) -> Result<Option<Self>> {
        let spec = spec.of_the_reference();
        let ReferenceMethod::Exact(solution) = (spec.case.reference)(&spec.parameters)? else { return Ok(None) };
        Self::sample(&spec, &solution, stop).map(Some)
    }

    /// Tells whether a solution with one step per stored point has an event; none where no contact of the case could
    /// have it. It is a seventh of the work of the reference or less, and differs from it only where an event barely
    /// happens.
    ///
    /// # Errors
    /// As for [`compute`](Self::compute).
    pub fn has_event(spec: &RunSpec, event: ContactEvent, stop: StopFlag<'_>) -> Result<Option<bool>> {
        let reference = match Self::exact(spec, stop)? {
            Some(exact) => exact,
            None => {
                let mut case = Case::clone(&spec.of_the_reference().case);
                case.defaults.reference_step_s = case.defaults.reference_sampling_s;
                let coarse = spec.of_case(Arc::new(case));
                let solution = Self::solution(&coarse, Self::REFINEMENTS[0], stop)?;
                Self::of_one(&coarse, solution, f64::NAN)?
            }
        };
        Ok(event.happens(&reference.contacts, &reference.friction))
    }

    /// Makes a reference of one solution with this step (s), of whose uncertainty nothing is known.
    ///
    /// # Errors
    /// Bad parameters; a value that is not finite.
    pub fn of_one(spec: &RunSpec, Solution { rows, events }: Solution, step: f64) -> Result<Self> {
        check_finite(&spec.case, &rows)?;
        let unknown = vec![f64::NAN; rows.columns().len()];
        let contact_gaps = contact_gaps(spec)?;
        let events = events.selected(&judged_columns(&spec.case, &rows, &contact_gaps));
        Ok(Self::of(&spec.case, [rows, events], unknown.clone(), unknown, step, contact_gaps))
    }

    /// Integrates the whole system with the reference step over `refinement`.
    ///
    /// # Errors
    /// As for [`compute`](Self::compute).
    pub fn solution(spec: &RunSpec, refinement: u32, stop: StopFlag<'_>) -> Result<Solution> {
        Self::solution_by(spec, reference_steps(spec, refinement), stop)
    }

    fn solution_by(spec: &RunSpec, steps: ReferenceSteps, stop: StopFlag<'_>) -> Result<Solution> {
        let case = &spec.case;
        // By the usual solver, not that of the run: runs with different solvers share one reference.
        let mut system = (case.build)(&spec.parameters, &SolverEntry::active_set())?;
        let mut recorder = Recorder::new(case, &mut system)?.with_active_effective_mass(&mut system);
        let late = system.late_rows;
        let mut trajectory = Trajectory::with_capacity(case.recorded_columns(), steps.steps / steps.every + 1);
        let mut events = Trajectory::with_capacity(case.recorded_columns(), 0);
        let most = 2 * (steps.steps / steps.every / 2);
        let solved = match (case.reference)(&spec.parameters)? {
            ReferenceMethod::Own(integrate) => integrate(steps, stop, &mut trajectory),
            method @ (ReferenceMethod::Refined | ReferenceMethod::EventDriven | ReferenceMethod::Exact(_)) => {
                if matches!(method, ReferenceMethod::EventDriven) {
                    let integrators = (MechanicsIntegrator::EventSplit, ActuatorIntegrator::Midpoint);
                    if let Some(reason) = use_integrators(integrators, system.sides.lend()) {
                        return Err(Error::Incompatible(format!("the reference of case {}: {reason}", case.name)));
                    }
                }
                monolithic_with_events(system.sides.lend(), steps, stop, &mut |due, point| match due {
                    Due::Row => recorder.record(point, &mut trajectory),
                    // Rows that hold the values of the point before have none at an event.
                    Due::BeforeEvent | Due::AfterEvent if late || events.len() >= most => {}
                    Due::BeforeEvent | Due::AfterEvent => recorder.record(point, &mut events),
                })
            }
        };
        match solved {
            Ok(()) => Ok(Solution { rows: trajectory, events }),
            Err(failure) if failure.is_stop() => Err(Error::Stopped),
            Err(failure) => Err(Error::Incompatible(format!(
                "case {} has no reference with these parameters: the monolithic solution fails after {:.4} s ({failure}){}",
                case.name,
                trajectory.end_time().unwrap_or(0.0),
                way_out(failure.cause(), &spec.parameters.changed())
            ))),
        }
    }

    /// Compares the solutions of [`REFINEMENTS`](Self::REFINEMENTS), the coarsest first.
    ///
    /// Three equal solutions say nothing where a side may take steps of its own: a fourth one, by the case's macro
    /// step, then tells what the length of a step does.
    ///
    /// # Errors
    /// Bad parameters; a value that is not finite; a side that does not move in the steps of the reference.
    pub fn compared(spec: &RunSpec, solutions: [Solution; 3], stop: StopFlag<'_>) -> Result<Self> {
        let [Solution { rows: coarse, .. }, Solution { rows: middle, .. }, Solution { rows: fine, events }] = solutions;
        let best = match (spec.case.reference)(&spec.parameters)? {
            ReferenceMethod::EventDriven => 2.0,
            _ => 1.0,
        };
        [&coarse, &middle, &fine].into_iter().try_for_each(|solution| check_finite(&spec.case, solution))?;
        let columns = fine.columns().len();
        let largest = largest(&fine);
        let (mut uncertainty, mut order) = (Vec::with_capacity(columns), Vec::with_capacity(columns));
        for (column, largest) in largest.iter().enumerate() {
            let (first, second) = (distance(&coarse, &middle, column), distance(&middle, &fine, column));
            let rounding = ROUNDING * largest;
            let observed = if first.min(second) > rounding { libm::log2(first / second) } else { f64::NAN };
            let trusted = if observed.is_nan() { best } else { observed.clamp(0.5, best) };
            uncertainty.push(second.max(0.5 * first) / (libm::pow(2.0_f64, trusted) - 1.0));
            order.push(observed);
        }
        // Bound of the rounding that adds up over all steps, relative.
        let summed = f64::EPSILON * reference_steps(spec, 4).steps as f64;
        let equal = |column: usize| {
            distance(&coarse, &middle, column).max(distance(&middle, &fine, column)) <= summed * largest[column]
        };
        let interface: Vec<usize> = interface_of(&spec.case, &fine).collect();
        if !interface.is_empty() && interface.into_iter().all(equal) {
            uncertainty = Self::by_longer_steps(spec, &fine, stop)?;
        }
        let finest = Self::REFINEMENTS[Self::REFINEMENTS.len() - 1];
        let contact_gaps = contact_gaps(spec)?;
        let judged = judged_columns(&spec.case, &fine, &contact_gaps);
        let events = events.selected(&judged);
        check_finite(&spec.case, &events)?;
        for (column, between) in judged.iter().zip(between_rows(&fine.selected(&judged), &events)).skip(1) {
            uncertainty[*column] = libm::hypot(uncertainty[*column], between);
        }
        Ok(Self::of(&spec.case, [fine, events], uncertainty, order, reference_steps(spec, finest).h, contact_gaps))
    }

    /// Tells by how much a solution by the case's macro step differs from one that is the same for all steps of a
    /// reference.
    fn by_longer_steps(spec: &RunSpec, fine: &Trajectory, stop: StopFlag<'_>) -> Result<Vec<f64>> {
        let (end, macro_step) = (spec.reference_end(), spec.case.defaults.macro_step_s);
        let steps = (end / macro_step).ceil().max(1.0) as usize;
        let longer = match (ReferenceSteps { h: end / steps as f64, steps, every: 1 }) {
            equal if spec.case.allows_step(equal.h) => equal,
            // So many steps between stored points as come closest to it.
            _ => {
                let between = (macro_step / spec.case.defaults.reference_sampling_s).round().max(1.0);
                let h = between * spec.case.defaults.reference_sampling_s;
                ReferenceSteps { h, steps: (end / h * (1.0 + 1e-9)).floor().max(1.0) as usize, every: 1 }
            }
        };
        // Where longer steps fail there is no estimate.
        let solution = match Self::solution_by(spec, longer, stop) {
            Ok(Solution { rows, .. }) if check_finite(&spec.case, &rows).is_ok() => rows,
            Err(Error::Stopped) => return Err(Error::Stopped),
            _ => return Ok(vec![0.0; fine.columns().len()]),
        };
        let same = fine.resampled(solution.column(0));
        let apart: Vec<f64> = (0..fine.columns().len()).map(|column| distance(&solution, &same, column)).collect();
        let stands = |name: &str| {
            let column = fine.index_of(name);
            column.is_some_and(|column| fine.column(column).all(|value| value == fine.row(0)[column]))
        };
        let moves = |name: &str| fine.index_of(name).is_some_and(|column| apart[column] > 0.0);
        let mut rows = spec.case.interface_columns.iter();
        if rows.any(|row| stands(&row.position) && stands(&row.velocity) && moves(&row.position)) {
            return Err(Error::Incompatible(format!(
                "case {} has no reference: in its steps of {:e} s and less the interface stands, and in steps of {:e} s it moves, so \
                 that a side has longer steps of its own; set reference_step_s to a multiple of them",
                spec.case.name,
                reference_steps(spec, 1).h,
                longer.h
            )));
        }
        Ok(apart)
    }

    /// Derives once what every run is held against.
    fn of(
        case: &Case,
        [trajectory, events]: [Trajectory; 2],
        mut uncertainty: Vec<f64>,
        order: Vec<f64>,
        step: f64,
        contact_gaps: Vec<String>,
    ) -> Self {
        let mut largest = largest(&trajectory);
        let columns = judged_columns(case, &trajectory, &contact_gaps);
        for (&column, at_events) in columns.iter().zip(self::largest(&events)) {
            largest[column] = largest[column].max(at_events);
        }
        for column in interface_of(case, &trajectory) {
            let scale = case.scale_of(&trajectory.columns()[column]).unwrap_or(0.0);
            uncertainty[column] = uncertainty[column].max(ROUNDING * largest[column].max(scale));
        }
        let forces = case.interface_columns.iter().map(|row| &*row.force);
        let judged = with_impulses(forces, merged(trajectory.selected(&columns).rows(), &events));
        // By rows at equal distances, as those of a run are, which does not see hops of less than that.
        let gaps = contact_gaps.iter().filter_map(|gap| trajectory.index_of(gap));
        let contacts: Vec<_> = gaps.map(|gap| contact_intervals(&trajectory, gap)).collect();
        let touch_downs = touch_downs(&contacts);
        let near = |row: &&[f64]| touch_downs.iter().any(|[from, to]| (*from..=*to).contains(&row[0]));
        let touch_down_peaks = largest_of(judged.columns().len(), judged.rows().filter(near));
        let friction = friction_of(&trajectory);
        Reference {
            largest,
            judged,
            touch_down_peaks,
            touch_downs,
            contacts,
            friction,
            trajectory,
            events,
            uncertainty,
            order,
            step,
            contact_gaps,
            samples: Samples::default(),
        }
    }

    fn sample(spec: &RunSpec, solution: &ExactSolution, stop: StopFlag<'_>) -> Result<Self> {
        let columns = spec.case.recorded_columns();
        let points = points(spec);
        let mut trajectory = Trajectory::with_capacity(columns, points + 1);
        for point in 0..=points {
            solution(spec.duration * point as f64 / points as f64, stop, trajectory.push_row());
            stop.check().map_err(|_| Error::Stopped)?;
        }
        check_finite(&spec.case, &trajectory)?;
        let count = trajectory.columns().len();
        let contact_gaps = contact_gaps(spec)?;
        let columns = judged_columns(&spec.case, &trajectory, &contact_gaps);
        let events = trajectory.slice(0, 0).selected(&columns);
        let order = vec![f64::NAN; count];
        Ok(Self::of(&spec.case, [trajectory, events], vec![0.0; count], order, 0.0, contact_gaps))
    }

    /// Returns the bounds beyond which a run counts as diverged: three times the largest magnitude of each coupling
    /// variable, if the case's runs are to be bounded. A largest one below a tenth of the case's own scale counts as
    /// that, and one that is not known as ten times its uncertainty. A case that declares no scale has the largest
    /// magnitude of a quantity for all rows, of which one may rest by symmetry.
    ///
    /// # Errors
    /// Those of building the case.
    pub fn bounds(&self, spec: &RunSpec) -> Result<Bounds> {
        Ok(self.bounds_of(&spec.case, &(spec.case.build)(&spec.parameters, &spec.solver)?))
    }

    /// Returns the bounds of a system of the case that is at hand.
    pub(super) fn bounds_of(&self, case: &Case, system: &CoupledSystem) -> Bounds {
        PerSide::from_fn(|side: Side| {
            let ports = system.sides[side].ports();
            let follows = system.bounded_by_motion && side == Side::Actuator && ports.direct_feedthrough;
            let column_of = |port: &Port| self.trajectory.index_of(&port.name);
            ports
                .outputs
                .iter()
                .map(|port| match column_of(port) {
                    Some(column) if !(system.unbounded || follows) => {
                        let scale = case.scale.unwrap_or_else(|| self.own_scale(case)).of(port.quantity);
                        let least = (STIRRED * scale).max(KNOWN_PEAK * self.uncertainty[column]);
                        let alike = ports.outputs.iter().filter(|other| {
                            other.name == port.name || case.scale.is_none() && other.quantity == port.quantity
                        });
                        let largest = alike.filter_map(column_of).map(|column| self.largest[column]);
                        DIVERGENCE_FACTOR * largest.fold(least, f64::max).max(port.quantity.negligible())
                    }
                    _ => f64::INFINITY,
                })
                .collect()
        })
    }

    /// The scale of a case that declares none: the speed at which its interface would cover its own position within the
    /// run.
    fn own_scale(&self, case: &Case) -> Scale {
        let columns = case.interface_columns.iter().filter_map(|row| self.trajectory.index_of(&row.position));
        let position = columns.map(|column| self.largest[column]).fold(0.0, f64::max);
        let duration = self.trajectory.end_time().unwrap_or(f64::INFINITY);
        Scale { position_m: 0.0, velocity_m_s: position / duration, force_n: 0.0 }
    }

    /// Tells whether it runs away itself: force and velocity of a row grow from quarter to quarter of the run by twice
    /// or more, and by no less in the last ones than before, as an exponential does and no power of time.
    pub fn runs_away(&self, case: &Case) -> bool {
        let grows = |name: &str| {
            let Some(column) = self.trajectory.index_of(name) else { return false };
            let rows = self.trajectory.len();
            let peak = |quarter: usize| {
                let part = quarter * rows / 4..(quarter + 1) * rows / 4;
                part.map(|row| self.trajectory.row(row)[column].abs()).fold(0.0, f64::max)
            };
            let peaks = [0, 1, 2, 3].map(peak);
            let growth = [0, 1, 2].map(|quarter| peaks[quarter + 1] / peaks[quarter]);
            growth.iter().all(|growth| *growth >= 2.0 && growth.is_finite()) && growth[2] >= 0.8 * growth[1]
        };
        case.interface_columns.iter().any(|row| grows(&row.force) && grows(&row.velocity))
    }

    /// Says what is known of a peak of an interface column: the largest magnitude of all of it, or of a part.
    pub fn peak_of(&self, case: &Case, column: &str, peak: f64) -> Peak {
        let least = NO_PEAK * case.scale_of(column).unwrap_or(Quantity::Force.negligible());
        match self.uncertainty_of(column) {
            _ if peak <= least => Peak::Nothing,
            Some(uncertainty) if peak > KNOWN_PEAK * uncertainty => Peak::Known(peak),
            _ => Peak::NotKnown,
        }
    }

    /// Says what is known of the largest force (N) of a row of the interface; see [`peak_of`](Self::peak_of).
    pub fn force_peak(&self, case: &Case, force: &str) -> Peak {
        let peak = self.trajectory.index_of(force).map(|column| self.largest[column]);
        peak.map_or(Peak::NotKnown, |peak| self.peak_of(case, force, peak))
    }

    /// Says why no error is related to a peak of the force, if none is.
    pub fn without_peak(&self, case: &Case) -> Option<&'static str> {
        let mut peaks = case.interface_columns.iter().map(|row| self.force_peak(case, &row.force)).peekable();
        peaks.peek()?;
        peaks.try_fold("no force to speak of", |words, peak| match peak {
            Peak::Known(_) => None,
            Peak::Nothing => Some(words),
            Peak::NotKnown => Some("the force of the reference is not known to a tenth"),
        })
    }

    /// Tells whether a column of a run is the gap of one contact; of a column that the reference lacks its name says
    /// so.
    pub fn is_contact_gap(&self, column: &str) -> bool {
        column.starts_with(GAP) && (self.contact_gaps.iter().any(|gap| gap == column) || !self.has(column))
    }

    fn has(&self, column: &str) -> bool {
        self.trajectory.index_of(column).is_some()
    }

    /// When the contact of a gap column is closed, if the reference has that column.
    pub fn contacts_of(&self, gap: &str) -> Option<&Vec<ContactInterval>> {
        self.contacts.get(self.contact_gaps.iter().position(|name| name == gap)?)
    }

    /// Returns what the contact with the state column `state` does; none if the reference does not know it.
    pub fn friction_of(&self, state: &str) -> Option<&Vec<FrictionPhase>> {
        self.friction.iter().find(|(name, _)| name == state).map(|(_, phases)| phases)
    }

    /// Returns the largest magnitude of a column while a touch-down shows; 0 where none does.
    pub fn touch_down_peak(&self, column: &str) -> f64 {
        self.judged.index_of(column).map_or(0.0, |index| self.touch_down_peaks[index])
    }

    /// Returns some of the columns that runs are judged by, by position and the time first, at these times at least;
    /// made once for all runs on these times.
    pub(super) fn judged_at<I>(&self, columns: Vec<usize>, times: I) -> Arc<Trajectory>
    where
        I: ExactSizeIterator<Item = f64> + Clone,
    {
        self.samples.at(&self.judged, columns, times)
    }

    /// Returns the uncertainty of a column by name.
    pub fn uncertainty_of(&self, column: &str) -> Option<f64> {
        self.trajectory.index_of(column).map(|index| self.uncertainty[index])
    }

    /// Returns all of it as numbers, to be kept: the rows, those at events, then what is known about the columns, the
    /// step and how many numbers are of events, because what is read back is cut off from the end.
    pub fn pack(&self) -> Vec<f64> {
        let is_gap = self.trajectory.columns().iter().map(|name| f64::from(self.contact_gaps.contains(name)));
        let gaps: Vec<f64> = is_gap.collect();
        let (rows, events) = (self.trajectory.data(), self.events.data());
        [rows, events, &gaps, &self.uncertainty, &self.order, &[self.step, events.len() as f64]].concat()
    }

    /// Reads back what [`pack`](Self::pack) made of a reference of this case; none if the numbers do not fit.
    pub fn unpack(case: &Case, mut data: Vec<f64>) -> Option<Self> {
        let columns = case.recorded_columns();
        let n = columns.len();
        let at_events = data.pop().filter(|count| *count >= 0.0 && count.fract() == 0.0)? as usize;
        let step = data.pop()?;
        let mut cut = |count| Some(data.split_off(data.len().checked_sub(count)?));
        let (order, uncertainty, is_gap, events) = (cut(n)?, cut(n)?, cut(n)?, cut(at_events)?);
        if data.is_empty() || !data.len().is_multiple_of(n) {
            return None;
        }
        let gaps = columns.iter().zip(is_gap).filter(|(_, is_gap)| *is_gap == 1.0).map(|(name, _)| name.clone());
        let gaps: Vec<String> = gaps.collect();
        let trajectory = Trajectory::from_data(columns, data);
        let judged = trajectory.slice(0, 0).selected(&judged_columns(case, &trajectory, &gaps)).columns().to_vec();
        if !events.len().is_multiple_of(judged.len()) {
            return None;
        }
        let events = Trajectory::from_data(judged, events);
        [&trajectory, &events].into_iter().try_for_each(|rows| check_finite(case, rows)).ok()?;
        Some(Self::of(case, [trajectory, events], uncertainty, order, step, gaps))
    }
}

impl RunSpec {
    /// The run whose reference this one is held against: that of the case that judges, if another does.
    pub fn of_the_reference(&self) -> Cow<'_, RunSpec> {
        match &self.case.judged_by {
            None => Cow::Borrowed(self),
            Some(judge) => Cow::Owned(self.of_case(judge.clone())),
        }
    }

    /// The steps of the finest solution of the reference.
    pub fn reference_steps(&self) -> ReferenceSteps {
        reference_steps(self, Reference::REFINEMENTS[2])
    }

    /// Tells whether its runs end where they are no longer finite only.
    ///
    /// # Errors
    /// Those of building the case.
    pub fn is_unbounded(&self) -> Result<bool> {
        Ok((self.case.build)(&self.parameters, &self.solver)?.unbounded)
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
    let (end, sampling) = (spec.reference_end(), spec.case.defaults.reference_sampling_s);
    let count = end / sampling;
    // A quotient that is whole but for round-off is rounded to the whole number.
    (if end == spec.duration { count.ceil() } else { count.round() }).max(1.0) as usize
}

/// The steps that are taken: they divide the time to its end, in multiples of the stored points, and are no longer than
/// asked.
fn reference_steps(spec: &RunSpec, refinement: u32) -> ReferenceSteps {
    let every = spec.steps_between_points() * refinement as usize;
    let steps = points(spec) * every;
    ReferenceSteps { h: spec.reference_end() / steps as f64, steps, every }
}

/// Adds the running integral of each of these columns of forces, by the trapezoidal rule over the rows.
pub fn with_impulses<'a>(forces: impl Iterator<Item = &'a str>, judged: Trajectory) -> Trajectory {
    let forces: Vec<usize> = forces.filter_map(|force| judged.index_of(force)).collect();
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

/// How the name of a gap column begins.
pub(super) const GAP: &str = "gap_";

/// The recorded columns that are the gap of one contact each: those of the contacts that the mechanics names; all gap
/// columns of a mechanics from outside that names none.
fn contact_gaps(spec: &RunSpec) -> Result<Vec<String>> {
    let gaps: Vec<String> = spec.case.recorded_columns().into_iter().filter(|name| name.starts_with(GAP)).collect();
    if spec.case.from_outside || gaps.is_empty() {
        return Ok(gaps);
    }
    let mut system = (spec.case.build)(&spec.parameters, &SolverEntry::active_set())?;
    let contacts = system.sides.mechanics.capabilities().contact_mechanics();
    let contacts = contacts.map_or(&[][..], |mechanics| mechanics.contact_names());
    let is_of = |gap: &str| contacts.iter().any(|name| *gap == format!("{GAP}{name}_m"));
    let of_contact = |gap: &String| contacts.is_empty() || is_of(gap);
    Ok(gaps.into_iter().filter(of_contact).collect())
}

/// Refuses a solution with a value that is not finite.
fn check_finite(case: &Case, solution: &Trajectory) -> Result<()> {
    let bad = solution.rows().find_map(|row| {
        let bad = |index: &usize| !row[*index].is_finite() && !solution.columns()[*index].contains(MAY_BE_INFINITE);
        (0..row.len()).find(bad).map(|column| (column, row))
    });
    let Some((column, row)) = bad else { return Ok(()) };
    Err(Error::Incompatible(format!(
        "case {} has no reference with these parameters: its {} is {} at {:.4} s",
        case.name,
        solution.columns()[column],
        row[column],
        row[0]
    )))
}

/// Columns of the interface of a case.
fn interface_of<'a>(case: &'a Case, trajectory: &'a Trajectory) -> impl Iterator<Item = usize> + 'a {
    let names = case.interface_columns.iter().flat_map(|row| [&row.position, &row.velocity, &row.force]);
    names.filter_map(|name| trajectory.index_of(name))
}

/// What runs are judged by of a trajectory: time, columns of the interface, gaps of contacts.
fn judged_columns(case: &Case, trajectory: &Trajectory, contact_gaps: &[String]) -> Vec<usize> {
    let gaps = contact_gaps.iter().filter_map(|name| trajectory.index_of(name));
    std::iter::once(0).chain(interface_of(case, trajectory)).chain(gaps).collect()
}

/// Rows in the order of their times, with those at events.
fn merged<'a>(rows: impl Iterator<Item = &'a [f64]>, events: &Trajectory) -> Trajectory {
    let mut data = Vec::with_capacity(rows.size_hint().0 * events.columns().len() + events.data().len());
    let mut events_left = events.rows().peekable();
    for row in rows {
        while let Some(event) = events_left.next_if(|event| event[0] <= row[0]) {
            data.extend_from_slice(event);
        }
        data.extend_from_slice(row);
    }
    Trajectory::from_data(events.columns().to_vec(), data)
}

/// Root mean square error of each column between rows: what leaving out every second row changes at these, less what a
/// jump somewhere between two rows, of which no error vanishes more slowly, gains when the rows are as dense again.
fn between_rows(rows: &Trajectory, events: &Trajectory) -> Vec<f64> {
    let last = rows.len() - 1;
    let is_left_out = |k: usize| k % 2 == 1 && k != last;
    let kept = rows.rows().enumerate().filter(|(k, _)| !is_left_out(*k)).map(|(_, row)| row);
    let left_out = rows.rows().enumerate().filter(|(k, _)| is_left_out(*k));
    let data = left_out.flat_map(|(_, row)| row).copied().collect();
    let left_out = Trajectory::from_data(rows.columns().to_vec(), data);
    let found = merged(kept, events).resampled(left_out.column(0));
    (0..rows.columns().len()).map(|column| distance(&found, &left_out, column) / 2.0_f64.sqrt()).collect()
}

/// Root mean square distance of two solutions in a column.
fn distance(a: &Trajectory, b: &Trajectory, column: usize) -> f64 {
    let squares: f64 = a.column(column).zip(b.column(column)).map(|(x, y)| finite_difference(x, y).powi(2)).sum();
    (squares / a.len().max(1) as f64).sqrt()
}

/// What each contact with friction does, with its state column.
pub(super) fn friction_of(trajectory: &Trajectory) -> Vec<(String, Vec<FrictionPhase>)> {
    let states = trajectory.columns().iter().enumerate().filter(|(_, name)| is_contact_state(name));
    states.map(|(column, name)| (name.clone(), friction_phases(trajectory, column))).collect()
}

/// Largest magnitude of each column.
fn largest(trajectory: &Trajectory) -> Vec<f64> {
    largest_of(trajectory.columns().len(), trajectory.rows())
}

fn largest_of<'a>(columns: usize, rows: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
    let mut largest = vec![0.0_f64; columns];
    for row in rows {
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
