//! A trajectory from anywhere, scored by the files of a pack: the numbers of `simulate` where they can be had from
//! samples, by the same sums.

use super::problem::{Problem, ProblemRow, read_trajectory};
use rimbench_core::cosim::{Outcome, Report, Trajectory};
use rimbench_core::error::{Error, Result};
use rimbench_runs::metrics::{Columns, Evidence, InterfaceRow, METRICS, Sums};
use rimbench_runs::with_impulses;
use std::path::Path;

/// Metrics that samples suffice for.
pub const SCORES: [&str; 10] = [
    "force_error_rms_n",
    "force_error_l1_n",
    "force_error_max_n",
    "force_error_rms_of_peak",
    "force_error_rms_of_event_peak",
    "impulse_error_20ms_n_s",
    "touch_down_peak_ratio",
    "velocity_error_rms_m_s",
    "position_error_rms_m",
    "position_error_end_m",
];

/// What comes of a trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// `completed`, `diverged` or `ended-early`.
    pub outcome: &'static str,
    /// H, s.
    pub macro_step_s: f64,
    /// φ.
    pub phase: f64,
    /// Communication points.
    pub points: usize,
    /// When a bound was exceeded first, s.
    pub diverged_at_s: Option<f64>,
    /// When it ended, s.
    pub ended_at_s: f64,
    /// Values of [`SCORES`]; none where one does not apply.
    pub scores: [Option<f64>; SCORES.len()],
    /// Whether it tells the forces that the mechanics received.
    pub received: bool,
    /// Work sent minus work received, J, of a file that has both.
    pub interface_residual_j: Option<f64>,
}

impl Judged {
    /// Returns a score by name.
    pub fn score(&self, name: &str) -> Option<f64> {
        self.scores[SCORES.iter().position(|known| *known == name)?]
    }
}

/// Scores a file by a problem and the rows of its reference; where a `phase` is given, it must be the file's.
///
/// # Errors
/// [`Error::File`] for a file that is no result of this problem: columns missing or exchanged, other units, times off
/// the grid, too few digits.
pub fn judge(path: &Path, problem: &(Problem, Trajectory), phase: Option<f64>) -> Result<Judged> {
    judge_rows(&read_trajectory(path)?, problem, phase).map_err(|message| Error::file(path, message))
}

/// Scores a trajectory likewise, or says what is wrong with it.
pub(super) fn judge_rows(
    run: &Trajectory,
    (problem, known): &(Problem, Trajectory),
    phase: Option<f64>,
) -> Result<Judged, String> {
    let needed: Vec<&str> =
        std::iter::once("time_s").chain(problem.rows.iter().flat_map(ProblemRow::columns)).collect();
    if let Some(missing) = needed.iter().find(|name| run.index_of(name).is_none()) {
        let there = run.columns().join(", ");
        return Err(format!("has no column {missing}; needed: {}; there are: {there}", needed.join(", ")));
    }
    let received = problem.rows.iter().map(|row| &*row.received);
    let wanted = needed.iter().copied().chain(received.filter(|name| run.index_of(name).is_some()));
    let of = |name: &str| run.index_of(name).unwrap_or_default();
    let run_rows = run.selected(&wanted.map(of).collect::<Vec<_>>());
    let times: Vec<f64> = run_rows.column(0).collect();
    let (macro_step_s, found) = grid(&times, problem.duration_s)?;
    if let Some(phase) = phase.filter(|phase| (phase - found).abs() > 1e-6) {
        return Err(format!("time_s: the first step is {found:.6} H; valid: {phase:.6} H, the phase of the run"));
    }
    let place = |name: &str| run_rows.index_of(name).unwrap_or_default();
    let (mut rows, mut diverged) = (Vec::new(), None);
    for row in &problem.rows {
        check(row, &run_rows)?;
        let columns = row.columns().map(place);
        for (column, bound) in columns.into_iter().zip(row.bounds) {
            let beyond = |value: f64| value.is_nan() || value.abs() > bound.unwrap_or(f64::INFINITY);
            let at = run_rows.column(column).position(beyond).map(|at| times[at]);
            diverged = [diverged, at].into_iter().flatten().reduce(f64::min);
        }
        let [position, velocity, force] = columns;
        let reference_force_peak = row.force_peak_n;
        rows.push(InterfaceRow {
            position,
            velocity,
            force,
            reference_force_peak,
            reference_touch_down_peak: row.touch_down_peak_n,
        });
    }
    let columns = Columns { interface: rows, touch_downs: problem.touch_downs_s.clone(), ..Columns::default() };
    let mut sums = Sums::new(columns);
    let reference = with_impulses(problem.rows.iter().map(|row| &*row.force), known.clone());
    sums.add(&run_rows, 0..run_rows.len(), &reference.resampled(times.iter().copied()), &[]);
    let report = Report::not_run(Outcome::Completed);
    let evidence = Evidence {
        sums: &sums,
        run_contacts: &[],
        reference_contacts: &[],
        run_friction: &[],
        reference_friction: &[],
        report: &report,
        audited: false,
        predicted_growth: None,
    };
    let score = |name| METRICS.iter().find(|metric| metric.name == name).and_then(|metric| (metric.compute)(&evidence));
    let last = |name| Some(run.row(run.len() - 1)[run.index_of(name)?]);
    let ended_at_s = times[times.len() - 1];
    // A master of fixed steps ends with its last whole step.
    let whole = ended_at_s >= problem.duration_s - macro_step_s * (1.0 + 1e-6);
    Ok(Judged {
        outcome: if diverged.is_some() {
            "diverged"
        } else if whole {
            "completed"
        } else {
            "ended-early"
        },
        macro_step_s,
        phase: found.min(1.0),
        points: times.len(),
        diverged_at_s: diverged,
        ended_at_s,
        scores: SCORES.map(score),
        received: problem.rows.iter().all(|row| run.index_of(&row.received).is_some()),
        interface_residual_j: last("work_sent_j").zip(last("work_received_j")).map(|(sent, got)| sent - got),
    })
}

/// Finds H and φ of t_0 = 0, t_k = (φ + k − 1) H, the last at the end; rows that are missing or moved are refused.
fn grid(times: &[f64], end: f64) -> Result<(f64, f64), String> {
    let rises = times.windows(2).all(|pair| pair[1] > pair[0]);
    if times[0] != 0.0
        || !rises
        || times.iter().any(|time| !time.is_finite())
        || times[times.len() - 1] > end * (1.0 + 1e-9)
    {
        return Err(format!("time_s: must rise from 0 to at most {end} s, and be finite"));
    }
    let mut steps: Vec<f64> =
        times.windows(2).map(|pair| pair[1] - pair[0]).skip(usize::from(times.len() > 3)).collect();
    steps.sort_by(f64::total_cmp);
    let middle = steps.len() / 2;
    let step = match steps.len() {
        few if times.len() <= 3 => steps[few - 1],
        odd if odd % 2 == 1 => steps[middle],
        _ => 0.5 * (steps[middle - 1] + steps[middle]),
    };
    let phase = if times.len() == 2 { 1.0 } else { times[1] / step };
    let off = |(k, time): (usize, &f64)| (k + 1, (time - ((phase + k as f64) * step).min(end)).abs());
    let worst = times[1..].iter().enumerate().map(off).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
    if phase > 1.0 + 1e-6 || worst.1 > 1e-6 * step {
        return Err(format!("time_s: no grid with H = {step:.6e} s: row {} is off by {:.1e} s", worst.0, worst.1));
    }
    Ok((step, phase))
}

/// Refuses what is not this row of this problem in SI units, whatever its error would be.
fn check(row: &ProblemRow, run: &Trajectory) -> Result<(), String> {
    let columns = row.columns().map(|name| run.index_of(name).unwrap_or_default());
    for (at, name) in row.columns().into_iter().enumerate().take(2) {
        let (found, start) = (run.row(0)[columns[at]], row.start[at]);
        let allowed = 1e-6 * (start.abs() + 1e-3 * row.bounds[at].unwrap_or(0.0));
        if found.is_nan() || (found - start).abs() > allowed {
            return Err(format!(
                "{name}: begins with {found:?}, and the problem with {start:?}; valid: SI units, each column under its own name"
            ));
        }
    }
    let is_short = |value: f64| format!("{value:.5e}").parse() == Ok(value);
    for (&column, name) in columns.iter().zip(row.columns()) {
        let mut told: Vec<u64> = run.column(column).filter(|value| value.is_finite()).map(f64::to_bits).collect();
        let all_short = told.iter().all(|bits| is_short(f64::from_bits(*bits)));
        told.sort_unstable();
        told.dedup();
        if told.len() > 20 && all_short {
            return Err(format!("{name}: has six digits or fewer; valid: nine or more"));
        }
    }
    let (mut off, mut size) = (0.0, 0.0);
    for k in 1..run.len() {
        let (before, after) = (run.row(k - 1), run.row(k));
        let moved = after[columns[0]] - before[columns[0]];
        let [start, end] = [before, after].map(|row| (after[0] - before[0]) * row[columns[1]]);
        if (moved + end + start).is_finite() {
            off += (moved - end).abs().min((moved - start).abs()).min((moved - 0.5 * (end + start)).abs());
            size += moved.abs().max(start.abs()).max(end.abs());
        }
    }
    if off > 0.5 * size && size > 1e-6 * row.bounds[0].unwrap_or(0.0) {
        let [position, velocity, _] = row.columns();
        return Err(format!("{velocity}: is not the rate of {position}: columns are exchanged, or not in SI units"));
    }
    Ok(())
}
