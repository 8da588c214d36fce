//! A problem as numbers: what `score.json` and `reference.csv.gz` of a pack hold.

use crate::phase_ensemble;
use flate2::read::GzDecoder;
use flate2::{Compression, GzBuilder};
use rimbench_cases::cases::{Case, ReferenceMethod};
use rimbench_core::cosim::{Bounds, Side, StopFlag, Trajectory};
use rimbench_core::error::{Error, Result};
use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_results::input::read_bytes;
use rimbench_runs::{Reference, RunSpec};
use serde::{Deserialize, Serialize};
use std::io::{Read, Write};
use std::path::Path;

/// Version of what a pack holds, behind that of the digits.
const PACK_VERSION: &str = "1";

/// Phases of each macro step that an entry of the closed division has at least. Ours.
pub(super) const LEAST_PHASES: usize = 4;

/// The version of packs that this program writes and reads.
pub(super) fn pack_version() -> String {
    format!("{NUMERICS_VERSION}.{PACK_VERSION}")
}

/// Most bytes of a table that is read.
const MOST_BYTES: u64 = 1 << 30;

/// What a trajectory is scored by, apart from the rows of the reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Problem {
    /// Name of the case.
    pub problem: String,
    /// Its parameters that are not at their defaults, as `key=value` separated by spaces.
    pub set: String,
    /// Versions of digits and pack.
    pub version: String,
    /// Simulated time, s.
    pub duration_s: f64,
    /// Macro steps of the ranking, s.
    pub macro_steps_s: Vec<f64>,
    /// Phases of the ranking.
    pub phases: Vec<f64>,
    /// Longest step of the actuator, s.
    pub micro_step_s: f64,
    /// Steps of the mechanics in each macro step.
    pub mechanics_steps: String,
    /// Distance of the rows of the reference, s.
    pub sampling_s: f64,
    /// Rows of the interface.
    pub rows: Vec<ProblemRow>,
    /// Times at which a touch-down shows, from and to, s.
    pub touch_downs_s: Vec<[f64; 2]>,
}

/// A row of the interface; lists are of position (m), velocity (m/s) and force (N).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProblemRow {
    /// Column of the position.
    pub position: String,
    /// Column of the velocity.
    pub velocity: String,
    /// Column of the actuator's own force.
    pub force: String,
    /// Column of the force that the mechanics received over the step that ends at a row.
    pub received: String,
    /// What they begin with.
    pub start: [f64; 3],
    /// Magnitudes beyond which a run has diverged; none where it is unbounded.
    pub bounds: [Option<f64>; 3],
    /// Rms uncertainty of the reference.
    pub uncertainty: [f64; 3],
    /// Largest force, N; none where there is none to speak of.
    pub force_peak_n: Option<f64>,
    /// Largest force while a touch-down shows, N; none likewise.
    pub touch_down_peak_n: Option<f64>,
}

impl ProblemRow {
    /// Returns the columns of position, velocity and force.
    pub fn columns(&self) -> [&str; 3] {
        [&self.position, &self.velocity, &self.force]
    }
}

impl Problem {
    /// Describes the problem of a run by its reference, which `ranked` runs ask at several macro steps and phases, and
    /// returns it with the rows of the reference.
    ///
    /// # Errors
    /// Those of building the case; [`Error::Incompatible`] for a case without an interface of force and motion.
    pub fn of(spec: &RunSpec, reference: &Reference, ranked: &[RunSpec]) -> Result<(Self, Trajectory)> {
        let case = &spec.case;
        let asked: Vec<&RunSpec> = ranked.iter().filter(|known| known.shares_reference_with(spec)).collect();
        let mut macro_steps_s: Vec<f64> = asked.iter().map(|known| known.macro_step).collect();
        macro_steps_s.sort_by(f64::total_cmp);
        macro_steps_s.dedup();
        if macro_steps_s.is_empty() {
            macro_steps_s.push(spec.macro_step);
        }
        let mut phases: Vec<f64> = Vec::new();
        let more = if case.has_fixed_steps() { vec![1.0] } else { phase_ensemble(LEAST_PHASES) };
        for phase in asked.iter().map(|known| known.phase).chain(more) {
            if !phases.contains(&phase) {
                phases.push(phase);
            }
        }
        let names = case.interface_columns.iter().flat_map(|row| [&row.position, &row.velocity, &row.force]);
        let columns: Option<Vec<usize>> = names.map(|name| reference.judged.index_of(name)).collect();
        let columns = columns.filter(|columns| !columns.is_empty()).ok_or_else(|| {
            Error::Incompatible(format!("case {} records no interface of force and motion to be scored by", case.name))
        })?;
        let rows = reference.judged.selected(&[&[0], &columns[..]].concat());
        let rows = match (case.reference)(&spec.parameters)? {
            ReferenceMethod::Exact(exact) => {
                let all = case.recorded_columns();
                let at: Option<Vec<usize>> =
                    rows.columns().iter().map(|name| all.iter().position(|own| own == name)).collect();
                let of = |time: f64| {
                    let mut row = Trajectory::with_capacity(all.clone(), 1);
                    exact(time, StopFlag::never(), row.push_row());
                    at.iter().flatten().map(|column| row.row(0)[*column]).collect()
                };
                with_jumps(&rows, of)
            }
            _ => rows,
        };
        let bounds = reference.bounds(spec)?;
        let described = (0..case.interface_columns.len()).map(|row| described(spec, reference, &bounds, row, &rows));
        let problem = Problem {
            problem: case.name.to_string(),
            set: spec.parameters.changed(),
            version: pack_version(),
            duration_s: spec.duration,
            macro_steps_s,
            phases,
            micro_step_s: asked.first().map_or(spec.micro_step, |known| known.micro_step),
            mechanics_steps: asked.first().map_or(spec.mechanics_steps, |known| known.mechanics_steps).to_string(),
            sampling_s: spec.duration / (reference.trajectory.len().max(2) - 1) as f64,
            rows: described.collect::<Result<_>>()?,
            touch_downs_s: reference.touch_downs.clone(),
        };
        let rows = problem.rounded(&rows);
        Ok((problem, rows))
    }

    /// Reads a pack's folder.
    ///
    /// # Errors
    /// [`Error::File`] for files that are not there or not of a pack of this version.
    pub fn read(folder: &Path) -> Result<(Self, Trajectory)> {
        let path = folder.join("score.json");
        let wrong = |error: serde_json::Error| Error::file(&path, format!("is of no problem pack: {error}"));
        let problem: Problem = serde_json::from_slice(&read_bytes(&path, MOST_BYTES)?).map_err(wrong)?;
        let expected = pack_version();
        if problem.version != expected {
            let message =
                format!("version = \"{}\" is not that of this program; valid: \"{expected}\"", problem.version);
            return Err(Error::file(&path, message));
        }
        let rows = read_trajectory(&folder.join("reference.csv.gz"))?;
        let columns: Vec<&str> = problem.rows.iter().flat_map(ProblemRow::columns).collect();
        match columns.iter().find(|name| rows.index_of(name).is_none()) {
            Some(missing) => {
                Err(Error::file(&path, format!("names the column {missing}, which reference.csv.gz lacks")))
            }
            None => Ok((problem, rows)),
        }
    }

    /// Returns the peak of the force over that at the event, of the row of the interface in which it is largest; none
    /// without a force to speak of.
    pub fn peak_over_event_peak(&self) -> Option<f64> {
        let ratio = |row: &ProblemRow| Some(row.force_peak_n? / row.touch_down_peak_n.or(row.force_peak_n)?);
        self.rows.iter().filter_map(ratio).reduce(f64::max)
    }

    /// Names the pack: its case, and its parameters where some are changed.
    pub fn name(&self) -> String {
        let set = self.set.replace(['=', ' '], "-");
        if set.is_empty() { self.problem.clone() } else { format!("{}-{set}", self.problem) }
    }

    /// Rounds times to 1e-8 of the distance of rows, and each column to a tenth of its uncertainty.
    fn rounded(&self, rows: &Trajectory) -> Trajectory {
        let digits = |step: f64| (-libm::log10(step)).ceil().clamp(0.0, 18.0) as usize;
        let mut places = vec![digits(1e-8 * self.sampling_s)];
        places.extend(self.rows.iter().flat_map(|row| row.uncertainty).map(|own| digits(0.1 * own)));
        let places: Vec<usize> = places;
        let short = |value: f64, places: usize| format!("{value:.places$}").parse().unwrap_or(value) + 0.0;
        let data = rows.rows().flat_map(|row| row.iter().zip(&places).map(|(value, places)| short(*value, *places)));
        Trajectory::from_data(rows.columns().to_vec(), data.collect())
    }
}

/// The name of the column of the force that the mechanics receives of a row of the interface.
fn received(row: usize) -> String {
    if row == 0 { "force_to_mechanics_n".to_owned() } else { format!("force_{}_to_mechanics_n", row + 1) }
}

fn described(
    spec: &RunSpec,
    reference: &Reference,
    bounds: &Bounds,
    row: usize,
    rows: &Trajectory,
) -> Result<ProblemRow> {
    let case: &Case = &spec.case;
    let own = &case.interface_columns[row];
    let names = [&own.position, &own.velocity, &own.force];
    let sides = (case.build)(&spec.parameters, &spec.solver)?.sides;
    let bound = |name: &str| {
        let of_side = |side: Side| {
            let place = sides[side].ports().outputs.iter().position(|port| *port.name == *name)?;
            bounds[side].get(place).copied().filter(|bound| bound.is_finite())
        };
        of_side(Side::Mechanics).or_else(|| of_side(Side::Actuator))
    };
    Ok(ProblemRow {
        position: own.position.to_string(),
        velocity: own.velocity.to_string(),
        force: own.force.to_string(),
        received: received(row),
        start: names.map(|name| rows.index_of(name).map_or(0.0, |column| rows.row(0)[column])),
        bounds: names.map(|name| bound(name)),
        uncertainty: names.map(|name| reference.uncertainty_of(name).unwrap_or(0.0)),
        force_peak_n: reference.force_peak(case, &own.force).known(),
        touch_down_peak_n: reference.peak_of(case, &own.force, reference.touch_down_peak(&own.force)).known(),
    })
}

/// Adds two rows at each jump of a closed form, before and after it: where a column moves by ten times as much as
/// before and after.
fn with_jumps(rows: &Trajectory, exact: impl Fn(f64) -> Vec<f64>) -> Trajectory {
    let (count, width) = (rows.len(), rows.columns().len());
    let moved = |k: usize, column: usize| (rows.row(k + 1)[column] - rows.row(k)[column]).abs();
    let mut data = Vec::with_capacity(rows.data().len());
    for k in 0..count {
        data.extend_from_slice(rows.row(k));
        if k == 0 || k + 2 >= count {
            continue;
        }
        let jumps = |column: &usize| {
            let around = moved(k - 1, *column).max(moved(k + 1, *column));
            moved(k, *column) > 10.0 * around && moved(k, *column) > 0.0
        };
        let Some(column) = (1..width).find(jumps) else { continue };
        let (mut low, mut high) = (rows.row(k)[0], rows.row(k + 1)[0]);
        let (mut before, mut after) = (rows.row(k).to_vec(), rows.row(k + 1).to_vec());
        while high > low.next_up() {
            let time = 0.5 * (low + high);
            let middle = exact(time);
            let first = (middle[column] - before[column]).abs() >= (after[column] - middle[column]).abs();
            if first { (high, after) = (time, middle) } else { (low, before) = (time, middle) }
        }
        before[0] = low;
        after[0] = low;
        data.extend(before.into_iter().chain(after));
    }
    Trajectory::from_data(rows.columns().to_vec(), data)
}

/// Writes rows as CSV, each number as the shortest text that reads back to it.
pub(super) fn csv_of(rows: &Trajectory) -> Vec<u8> {
    let mut text = rows.columns().join(",") + "\n";
    for row in rows.rows() {
        let cells: Vec<String> = row.iter().map(f64::to_string).collect();
        text += &(cells.join(",") + "\n");
    }
    text.into_bytes()
}

/// Compresses bytes without a time or a name, so that the same give the same.
///
/// # Errors
/// None of memory.
pub(super) fn zipped(bytes: &[u8]) -> Result<Vec<u8>> {
    let mut encoder = GzBuilder::new().mtime(0).write(Vec::new(), Compression::best());
    let done = encoder.write_all(bytes).and_then(|()| encoder.finish());
    done.map_err(|error| Error::Incompatible(format!("cannot be compressed: {error}")))
}

/// Reads a table of numbers under names, compressed where it ends in `.gz`; an empty cell is no number.
///
/// # Errors
/// [`Error::File`] with the line.
pub(super) fn read_trajectory(path: &Path) -> Result<Trajectory> {
    let bytes = read_bytes(path, MOST_BYTES)?;
    let wrong = |message: String| Error::file(path, format!("is no table of numbers under names: {message}"));
    let bytes = match path.extension().is_some_and(|extension| extension == "gz") {
        true => {
            let mut plain = Vec::new();
            let read = GzDecoder::new(&bytes[..]).take(MOST_BYTES).read_to_end(&mut plain);
            read.map_err(|error| wrong(error.to_string()))?;
            plain
        }
        false => bytes,
    };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(&bytes[..]);
    let header = reader.headers().map_err(|error| wrong(error.to_string()))?.clone();
    let columns: Vec<String> = header.iter().map(str::to_owned).collect();
    if let Some(twice) = (1..columns.len()).find(|at| columns[..*at].contains(&columns[*at])) {
        return Err(wrong(format!("two columns are called {}", columns[twice])));
    }
    let mut data = Vec::new();
    for (line, record) in reader.records().enumerate() {
        for (cell, name) in record.map_err(|error| wrong(error.to_string()))?.iter().zip(&columns) {
            let value = if cell.is_empty() { Ok(f64::NAN) } else { cell.parse::<f64>() };
            data.push(value.map_err(|_| wrong(format!("line {}: {name} = `{cell}`", line + 2)))?);
        }
    }
    let rows = Trajectory::from_data(columns, data);
    if rows.len() < 2 { Err(wrong("it has fewer than two rows".to_owned())) } else { Ok(rows) }
}
