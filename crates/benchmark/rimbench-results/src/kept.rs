//! What is kept of an experiment's results where its rows are made and not kept: medians, and a digest by which rows
//! that are made anew can be told to be the same.
//!
//! ```text
//! summary.csv   one row per case, set, scheme row, macro step and tolerance: runs by what they say, quartiles of some metrics;
//!               where settings are drawn, all of a case and a point of its grid in one row, with the error that has no unit
//! digest.toml   numerics version, number of rows, checksums of the plan, of runs.csv and of summary.csv
//! ```

use super::atomic_file::write_atomically;
use super::checksums::sha256_of_file;
use super::results_table::read_table;
use super::run_table::{Run, RunTable};
use super::selection::Runs;
use crate::input::read_text;
use crate::text_place::said_at;
use rimbench_core::error::{Error, Result};
use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_runs::Finding;
use rimbench_runs::metrics::USABLE;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Name of the file of medians.
pub const SUMMARY: &str = "summary.csv";
/// Name of the file of checksums.
pub const DIGEST: &str = "digest.toml";

/// Columns of `runs.csv` that runs of one row of the summary have in common.
pub const SUMMARY_KEYS: [&str; 5] = ["case", "set", "label", "macro_step_s", "step_tolerance"];

/// Metrics whose quartiles over the completed runs are kept.
pub const SUMMARY_METRICS: [&str; 7] = [
    "force_error_rms_n",
    "force_error_rms_of_peak",
    "force_error_max_n",
    "force_error_inside_rms_n",
    "position_error_rms_m",
    "position_error_end_m",
    "interface_residual_j",
];

/// The metric that is kept of settings that were drawn: newtons and metres of several machines are no quantity.
const POOLED_METRIC: &str = SUMMARY_METRICS[1];

/// What the quartiles are called, behind the name of the metric.
const QUARTILES: [&str; 3] = ["_q1", "_median", "_q3"];

/// The metric by which a run is usable: the share of the event's peak that is wrong.
const JUDGE: &str = "force_error_rms_of_event_peak";

/// Columns that count the runs.
const COUNTS: [&str; 5] = ["runs", "completed", "failed", "no_answer", "usable"];

/// A row of the summary.
#[derive(Debug, Clone, PartialEq)]
pub struct SummaryRow {
    /// Values of [`SUMMARY_KEYS`].
    pub keys: [String; SUMMARY_KEYS.len()],
    /// Number of runs, where settings are pooled less those that were skipped.
    pub runs: usize,
    /// How many of them completed.
    pub completed: usize,
    /// How many did not hold.
    pub failed: usize,
    /// How many say nothing, skipped ones only where they are among the runs.
    pub no_answer: usize,
    /// How many are usable: they completed with an rms force error of at most a tenth of the peak at the event.
    pub usable: usize,
    /// Quartiles of [`SUMMARY_METRICS`] over those that did; NaN where none has a value.
    pub quartiles: [[f64; 3]; SUMMARY_METRICS.len()],
    /// The largest error over those that did, where settings are pooled.
    pub worst: Option<f64>,
}

/// Case and set of parameters of runs with drawn settings, with the set less what was drawn; empty where nothing was.
pub type PooledSets = BTreeMap<(String, String), String>;

/// What tells whether rows are the same.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Digest {
    /// Version of everything that a digit can depend on.
    pub numerics_version: u32,
    /// Number of runs.
    pub rows: usize,
    /// SHA-256 of what was planned, hexadecimal.
    pub plan_sha256: String,
    /// SHA-256 of `runs.csv`, hexadecimal.
    pub runs_sha256: String,
    /// SHA-256 of `summary.csv`, hexadecimal.
    pub summary_sha256: String,
}

/// Makes the rows of the summary from those of `runs.csv`, in their order.
pub fn summarise(table: &RunTable, pooled: &PooledSets) -> Vec<SummaryRow> {
    let is_kept = |name: &&str| pooled.is_empty() || *name == POOLED_METRIC;
    let finding = |name: &str| Finding::named(name).ok();
    let (metrics, judge) = (SUMMARY_METRICS.map(|name| finding(name).filter(|_| is_kept(&name))), finding(JUDGE));
    let row = |(keys, runs): ([String; SUMMARY_KEYS.len()], Runs<'_>)| {
        let (completed, tally) = (runs.completed(), runs.tally());
        // Of settings without a reference there is nothing to tell.
        let no_answer = tally.no_answer + if pooled.is_empty() { tally.skipped } else { 0 };
        let value = |row, metric: Option<Finding>| metric.map_or(f64::NAN, |metric| runs.value(row, metric));
        let pool = |metric| completed.pool(|row| value(row, metric));
        let worst = || pool(metrics.iter().find_map(|metric| *metric)).range().map_or(f64::NAN, |[_, most]| most);
        SummaryRow {
            keys,
            runs: tally.completed + tally.failed + no_answer,
            completed: tally.completed,
            failed: tally.failed,
            no_answer,
            usable: completed.rows().iter().filter(|&&row| value(row, judge) <= USABLE).count(),
            quartiles: metrics.map(|metric| pool(metric).quartiles()),
            worst: (!pooled.is_empty()).then(worst),
        }
    };
    let written = |number: f64| if number.is_nan() { String::new() } else { format!("{number:?}") };
    let keys = |run: &Run| {
        let problem: (String, String) = run.problem().map(str::to_owned).into();
        let set = pooled.get(&problem).unwrap_or(&problem.1).clone();
        [problem.0, set, String::from(&*run.label), written(run.macro_step_s), written(run.step_tolerance)]
    };
    Runs::of(table).by_key(keys).into_iter().map(row).collect()
}

/// Writes `summary.csv` and `digest.toml` beside `runs.csv`, the rows of what was planned, by its checksum; drawn
/// settings are pooled.
///
/// # Errors
/// [`Error::File`] naming the file.
pub fn keep(folder: &Path, pooled: &PooledSets, plan_sha256: &str) -> Result<()> {
    let path = folder.join("runs.csv");
    let runs = RunTable::read(&path)?;
    let text = summary_csv(&runs, pooled)?;
    let summary = folder.join(SUMMARY);
    write_atomically(&summary, |file| file.write_all(&text))?;
    let sum = |path: &Path| sha256_of_file(path).ok_or_else(|| Error::file(path, "has gone as soon as it was written"));
    let (runs_sha256, summary_sha256) = (sum(&path)?, sum(&summary)?);
    let text = format!(
        "numerics_version = {NUMERICS_VERSION}\nrows = {}\nplan_sha256 = \"{plan_sha256}\"\nruns_sha256 = \"{runs_sha256}\"\nsummary_sha256 = \"{summary_sha256}\"\n",
        runs.len()
    );
    write_atomically(&folder.join(DIGEST), |file| file.write_all(text.as_bytes()))
}

/// Checks that the `summary.csv` in a folder is the one that its rows give.
///
/// # Errors
/// [`Error::File`] if it is another, or not there.
pub fn check_summary(folder: &Path, runs: &RunTable, pooled: &PooledSets) -> Result<()> {
    let path = folder.join(SUMMARY);
    let written = std::fs::read(&path).map_err(|error| Error::file(&path, format!("cannot be read: {error}")))?;
    let same = written == summary_csv(runs, pooled)?;
    if same { Ok(()) } else { Err(Error::file(&path, "is not that of runs.csv beside it: run the experiment again")) }
}

/// The text of `summary.csv`.
fn summary_csv(runs: &RunTable, pooled: &PooledSets) -> Result<Vec<u8>> {
    let text = summary_text(&summarise(runs, pooled), !pooled.is_empty());
    text.map_err(|error| Error::file(runs.path(), format!("has no summary: {error}")))
}

/// Writes rows of a summary as text, with the columns of drawn settings where these are pooled.
///
/// # Errors
/// None of memory.
pub fn summary_text(rows: &[SummaryRow], pooled: bool) -> csv::Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let lines = rows.iter().map(|row| {
        let counts = [row.runs, row.completed, row.failed, row.no_answer, row.usable].map(|count| count.to_string());
        let metrics = if row.worst.is_some() { &row.quartiles[1..2] } else { &row.quartiles[..] };
        let values = metrics.iter().flatten().copied().chain(row.worst).map(short);
        row.keys.iter().cloned().chain(counts).chain(values).collect()
    });
    std::iter::once(header(pooled)).chain(lines).try_for_each(|line| table.write_record(line))?;
    table.into_inner().map_err(|error| error.into_error().into())
}

fn header(pooled: bool) -> Vec<String> {
    let metrics = if pooled { &[POOLED_METRIC][..] } else { &SUMMARY_METRICS };
    let quartiles = metrics.iter().flat_map(|metric| QUARTILES.map(|quartile| format!("{metric}{quartile}")));
    let worst = pooled.then(|| format!("{POOLED_METRIC}_worst"));
    SUMMARY_KEYS.into_iter().chain(COUNTS).map(str::to_owned).chain(quartiles).chain(worst).collect()
}

/// Six significant digits: what is read is the size of a number, and its last digits are in the digest.
fn short(value: f64) -> String {
    if value.is_nan() { String::new() } else { format!("{:?}", format!("{value:.5e}").parse().unwrap_or(value)) }
}

/// Reads the summary in a folder, which must be that of its digest.
///
/// # Errors
/// [`Error::File`] if one of the two is missing or damaged, or of another numerics version.
pub fn read_summary(folder: &Path) -> Result<Vec<SummaryRow>> {
    Digest::of_this_version(folder)?;
    read_rows(&folder.join(SUMMARY))
}

/// Reads the rows of a summary, whose digest is not looked at.
///
/// # Errors
/// [`Error::File`] if it is missing, or has other columns than this program writes.
pub fn read_rows(path: &Path) -> Result<Vec<SummaryRow>> {
    let table = read_table(path)?;
    let is = |pooled: bool| table.names() == header(pooled);
    let pooled = is(true);
    if !pooled && !is(false) {
        return Err(Error::file(path, "has other columns than this program writes: run the experiment again"));
    }
    let column = |name: &str| table.column(name).ok();
    let quartiles = SUMMARY_METRICS.map(|metric| QUARTILES.map(|quartile| column(&format!("{metric}{quartile}"))));
    let number = |row: usize, column: Option<usize>| column.map_or(f64::NAN, |column| table.number(row, column));
    let [runs, completed, failed, no_answer, usable] = COUNTS.map(column);
    let worst = column(&format!("{POOLED_METRIC}_worst"));
    let row = |row: usize| {
        let count = |column| number(row, column) as usize;
        SummaryRow {
            keys: std::array::from_fn(|column| table.text(row, column).to_owned()),
            runs: count(runs),
            completed: count(completed),
            failed: count(failed),
            no_answer: count(no_answer),
            usable: count(usable),
            quartiles: quartiles.map(|metric| metric.map(|column| number(row, column))),
            worst: worst.map(|column| table.number(row, column)),
        }
    };
    Ok((0..table.len()).map(row).collect())
}

impl Digest {
    /// Reads the digest in a folder.
    ///
    /// # Errors
    /// [`Error::File`] if there is none, or if it is damaged.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(DIGEST);
        let text = read_text(&path)?;
        let wrong = |message: String| Error::file(&path, format!("is no digest: {message}: run the experiment again"));
        let digest: Digest =
            toml::from_str(&text).map_err(|error| wrong(said_at(&text, error.span(), error.message())))?;
        let is_sum = |sum: &String| sum.len() == 64 && sum.bytes().all(|byte| byte.is_ascii_hexdigit());
        let sums = [&digest.runs_sha256, &digest.summary_sha256, &digest.plan_sha256].into_iter();
        if let Some(sum) = sums.into_iter().find(|sum| !is_sum(sum)) {
            return Err(wrong(format!("`{sum}` is no SHA-256")));
        }
        Ok(digest)
    }

    /// Reads the digest in a folder, which must be that of the summary beside it, and of this program's numerics.
    ///
    /// # Errors
    /// [`Error::File`] if one of the two is missing or damaged, or of another numerics version.
    pub fn of_this_version(folder: &Path) -> Result<Self> {
        let digest = Self::read(folder)?;
        let path = folder.join(SUMMARY);
        if sha256_of_file(&path).as_ref() != Some(&digest.summary_sha256) {
            return Err(Error::file(&path, format!("is not that of {DIGEST} beside it: run the experiment again")));
        }
        if digest.numerics_version != NUMERICS_VERSION {
            let message = format!(
                "is of numerics version {}, this program of {NUMERICS_VERSION}: run the experiment again",
                digest.numerics_version
            );
            return Err(Error::file(folder.join(DIGEST), message));
        }
        Ok(digest)
    }

    /// Checks that it is of a plan, of so many runs and with this checksum.
    ///
    /// # Errors
    /// [`Error::File`] if it is of another.
    pub fn check_plan(&self, folder: &Path, runs: usize, plan_sha256: &str) -> Result<()> {
        let other = match (self.rows == runs, self.plan_sha256 == plan_sha256) {
            (true, true) => return Ok(()),
            (true, false) => "is not of the runs that the experiment has: a setting or a label is another".to_owned(),
            (false, _) => format!("is of {} runs, and the experiment has {runs}", self.rows),
        };
        Err(Error::file(folder.join(DIGEST), format!("{other}: run the experiment again")))
    }

    /// Checks that the `runs.csv` in a folder is the one of this digest.
    ///
    /// # Errors
    /// [`Error::File`] if it is another, or not there.
    pub fn check_rows(&self, folder: &Path) -> Result<()> {
        let path = folder.join("runs.csv");
        match sha256_of_file(&path) {
            None => Err(Error::file(&path, "is missing")),
            Some(found) if found != self.runs_sha256 => {
                Err(Error::file(&path, format!("is not that of {DIGEST} beside it: run the experiment again")))
            }
            Some(_) => Ok(()),
        }
    }
}
