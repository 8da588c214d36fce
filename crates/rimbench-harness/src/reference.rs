//! The monolithic reference with its uncertainty, computed once and cached by content.

use super::cache::Cache;
use rayon::prelude::*;
use rimbench_cases::cases::{Case, ExactSolution, Parameters, Recorder, ReferenceMethod};
use rimbench_cases::metrics::{ContactInterval, contact_intervals};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::cosim::{Bounds, Trajectory};
use rimbench_core::error::{Error, Result};
use rimbench_core::mechanics::monolithic;

/// A run counts as diverged when an interface quantity exceeds this many times its reference maximum.
pub const DIVERGENCE_FACTOR: f64 = 3.0;

/// Refinements of the reference step: h, h/2, h/4.
const REFINEMENTS: [u32; 3] = [1, 2, 4];

/// The finest monolithic solution, and how far to trust it.
///
/// ```text
/// p = log₂(‖u_h − u_{h/2}‖ / ‖u_{h/2} − u_{h/4}‖)             observed order
/// uncertainty = max(‖u_{h/2} − u_{h/4}‖, ½‖u_h − u_{h/2}‖) / (2^p − 1)     Richardson, with p held within [0.5, 1]
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
    /// Its finest step, s.
    pub step: f64,
}

impl Reference {
    /// Computes the reference of a case, or takes it from the cache.
    ///
    /// # Errors
    /// Bad parameters; or parameters for which the monolithic solution itself fails.
    pub fn obtain(
        case: &Case,
        parameters: &Parameters,
        solver: &SolverEntry,
        duration: f64,
        cache: &Cache,
    ) -> Result<Self> {
        if let ReferenceMethod::Exact(solution) = (case.reference)(parameters) {
            return Self::sample(case, solution(parameters)?, duration);
        }
        let key = content_key(case, parameters, duration);
        if let Some(data) = cache.read(&key)
            && let Some(reference) = Self::unpack(case, data)
        {
            return Ok(reference);
        }
        let reference = Self::compute(case, parameters, solver, duration)?;
        cache.write(&key, &reference.pack());
        Ok(reference)
    }

    /// Derives once what every run is held against.
    fn of(case: &Case, trajectory: Trajectory, uncertainty: Vec<f64>, order: Vec<f64>, step: f64) -> Self {
        let names = case.interface_columns.iter().flat_map(|row| [row.position, row.velocity, row.force]);
        let mut columns = vec![0];
        columns.extend(names.filter_map(|name| trajectory.index_of(name)));
        columns.extend(gap_columns(trajectory.columns()));
        let judged = trajectory.selected(&columns);
        let contacts = gap_columns(judged.columns()).map(|gap| contact_intervals(&judged, gap)).collect();
        Reference { largest: largest(&trajectory), judged, contacts, trajectory, uncertainty, order, step }
    }

    /// Samples a closed form, which has no uncertainty.
    fn sample(case: &Case, solution: ExactSolution, duration: f64) -> Result<Self> {
        let columns = case.recorded_columns();
        let points = (duration / case.defaults.reference_sampling_s).ceil().max(1.0) as usize;
        let mut trajectory = Trajectory::with_capacity(columns, points + 1);
        for point in 0..=points {
            solution(duration * point as f64 / points as f64, trajectory.push_row());
        }
        let count = trajectory.columns().len();
        Ok(Self::of(case, trajectory, vec![0.0; count], vec![f64::NAN; count], 0.0))
    }

    /// Computes the three solutions and compares them.
    fn compute(case: &Case, parameters: &Parameters, solver: &SolverEntry, duration: f64) -> Result<Self> {
        let solutions: Result<Vec<Trajectory>> = REFINEMENTS
            .par_iter()
            .rev()
            .map(|&refinement| solve(case, parameters, solver, duration, refinement))
            .collect();
        let Ok([fine, middle, coarse]) = <[Trajectory; 3]>::try_from(solutions?) else {
            unreachable!("three refinements give three solutions")
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
            let observed = (first / second).log2();
            let trusted = if observed.is_finite() { observed.clamp(0.5, 1.0) } else { 1.0 };
            uncertainty.push(second.max(0.5 * first) / (2.0_f64.powf(trusted) - 1.0));
            order.push(if second > 0.0 { observed } else { f64::NAN });
        }
        let finest = f64::from(REFINEMENTS[REFINEMENTS.len() - 1]);
        let step = case.defaults.reference_step_s / finest;
        Ok(Self::of(case, fine, uncertainty, order, step))
    }

    /// Bounds beyond which a run counts as diverged: three times the largest magnitude of each coupling variable.
    ///
    /// # Errors
    /// Those of building the case.
    pub fn bounds(&self, case: &Case, parameters: &Parameters, solver: &SolverEntry) -> Result<Bounds> {
        let system = (case.build)(parameters, solver)?;
        let largest = |ports: &[rimbench_core::cosim::Port]| {
            ports
                .iter()
                .map(|port| match self.trajectory.index_of(port.name) {
                    Some(column) => DIVERGENCE_FACTOR * self.largest[column].max(port.quantity.negligible()),
                    None => f64::INFINITY,
                })
                .collect()
        };
        Ok(Bounds {
            mechanics: largest(&system.mechanics.ports().outputs),
            actuator: largest(&system.actuator.ports().outputs),
        })
    }

    /// Uncertainty of a column by name.
    pub fn uncertainty_of(&self, column: &str) -> Option<f64> {
        self.trajectory.index_of(column).map(|index| self.uncertainty[index])
    }

    /// The rows, then what is known about the columns, then the step: what is read back is cut off from the end.
    fn pack(&self) -> Vec<f64> {
        [self.trajectory.data(), &self.uncertainty, &self.order, &[self.step]].concat()
    }

    fn unpack(case: &Case, mut data: Vec<f64>) -> Option<Self> {
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

/// Positions of the gap columns among the recorded ones.
pub(super) fn gap_columns(columns: &[String]) -> impl Iterator<Item = usize> + '_ {
    (0..columns.len()).filter(|&index| columns[index].starts_with("gap_"))
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

/// Everything that determines a reference, as text; the code itself included.
fn content_key(case: &Case, parameters: &Parameters, duration: f64) -> String {
    let mut key = format!(
        "reference of {}\nsources {} {}\nduration_s = {duration:?}\n",
        case.name,
        rimbench_core::SOURCES,
        rimbench_cases::SOURCES
    );
    key += &format!("columns = {:?}\nsteps = {:?}\n", case.recorded_columns(), case.defaults);
    for (parameter, value) in parameters.iter() {
        key += &format!("{} = {value}\n", parameter.name);
    }
    key
}

/// Difference that treats equal infinities (a locked interface in both) as agreeing.
fn finite_difference(x: f64, y: f64) -> f64 {
    if x == y || (x.is_nan() && y.is_nan()) { 0.0 } else { x - y }
}

fn solve(
    case: &Case,
    parameters: &Parameters,
    solver: &SolverEntry,
    duration: f64,
    refinement: u32,
) -> Result<Trajectory> {
    let mut system = (case.build)(parameters, solver)?;
    let mut recorder = Recorder::new(case, &mut system).with_active_effective_mass(&system);
    let every = (case.defaults.reference_sampling_s / case.defaults.reference_step_s).round().max(1.0) as usize;
    // The step used divides the duration, in multiples of the stored points.
    let points = (duration / case.defaults.reference_sampling_s).ceil().max(1.0) as usize;
    let every = every * refinement as usize;
    let steps = points * every;
    let h = duration / steps as f64;
    let mut trajectory = Trajectory::with_capacity(case.recorded_columns(), points + 1);
    let solved = match (case.reference)(parameters) {
        ReferenceMethod::Own(solve) => solve(parameters, h, steps, every, &mut trajectory),
        ReferenceMethod::Refined | ReferenceMethod::Exact(_) => {
            monolithic(&mut *system.mechanics, &mut *system.actuator, h, steps, every, &mut |point| {
                recorder.record(point, &mut trajectory)
            })
        }
    };
    solved.map_err(|failure| {
        let at = trajectory.end_time().unwrap_or(0.0);
        Error::Incompatible(format!(
            "case {} has no reference with these parameters: the monolithic solution fails after {at:.4} s ({failure})",
            case.name
        ))
    })?;
    Ok(trajectory)
}
