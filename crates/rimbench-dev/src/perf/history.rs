//! Rows of `history.csv`, and how records are named.

use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use rimbench_statistics::TimeSummary;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// One benchmark of one record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the record, 8 hexadecimal digits; the same in all rows of a record.
    pub record: String,
    /// When, seconds since 1970.
    pub recorded_at_unix_s: u64,
    /// Git revision of the source, 12 digits, or `unknown`.
    pub git_revision: String,
    /// Whether the source had changes that are not in that revision.
    pub git_dirty: String,
    /// Compiler.
    pub rustc: String,
    /// Target triple.
    pub target: String,
    /// Hash of the lock file.
    pub lock_hash: String,
    /// Hash that tells machines apart.
    pub machine: String,
    /// Processor.
    pub cpu: String,
    /// Name in the suite.
    pub benchmark: String,
    /// `ok`, or what was wrong; then there are no measurements.
    pub status: String,
    /// Macro steps.
    pub macro_steps: u64,
    /// Micro steps of the mechanics.
    pub mechanics_micro_steps: u64,
    /// Micro steps of the actuator.
    pub actuator_micro_steps: u64,
    /// Eliminations.
    pub eliminations: u64,
    /// Complementarity problems.
    pub lcp_solves: u64,
    /// Pivots.
    pub lcp_pivots: u64,
    /// Factorisations from scratch.
    pub lcp_factorisations: u64,
    /// Problems given to the fallback.
    pub lcp_fallbacks: u64,
    /// Floating-point operations, estimated from the counters.
    pub flops_estimate: u64,
    /// Instructions of one repetition.
    pub instructions: Option<u64>,
    /// Median wall time of one repetition, s.
    pub wall_s: Option<f64>,
    /// Geometric mean of wall time over that of the fixed work.
    pub time_ratio: Option<f64>,
    /// Standard deviation of the logarithm of that ratio.
    pub time_log_sd: Option<f64>,
    /// Number of ratios.
    pub time_samples: Option<u32>,
    /// Placebo: ratio of times of the same program, measured as if it were two.
    pub placebo_ratio: Option<f64>,
    /// Lower end of its 95 % interval.
    pub placebo_low: Option<f64>,
    /// Upper end.
    pub placebo_high: Option<f64>,
}

/// A counter of a row.
pub type Counter = fn(&Row) -> u64;

/// Counters that are compared exactly. The flop estimate follows from them.
pub const COUNTERS: [(&str, Counter); 8] = [
    ("macro_steps", |row| row.macro_steps),
    ("mechanics_micro_steps", |row| row.mechanics_micro_steps),
    ("actuator_micro_steps", |row| row.actuator_micro_steps),
    ("eliminations", |row| row.eliminations),
    ("lcp_solves", |row| row.lcp_solves),
    ("lcp_pivots", |row| row.lcp_pivots),
    ("lcp_factorisations", |row| row.lcp_factorisations),
    ("lcp_fallbacks", |row| row.lcp_fallbacks),
];

impl Row {
    /// Whether the benchmark gave its answer.
    pub fn is_ok(&self) -> bool {
        self.status == "ok"
    }

    /// Wall time over fixed work, where it was measured.
    pub fn time(&self) -> Option<TimeSummary> {
        Some(TimeSummary { ratio: self.time_ratio?, log_sd: self.time_log_sd?, samples: self.time_samples? })
    }

    /// What the placebo said: the interval that must hold 1.
    pub fn placebo(&self) -> Option<[f64; 2]> {
        Some([self.placebo_low?, self.placebo_high?])
    }

    /// What is impossible about the row, if anything.
    fn fault(&self) -> Option<String> {
        let positive = |value: Option<f64>| value.is_none_or(|value| value.is_finite() && value > 0.0);
        let times = [self.wall_s, self.time_ratio, self.placebo_ratio, self.placebo_low, self.placebo_high];
        if self.record.is_empty() || self.benchmark.is_empty() {
            return Some("a record and a benchmark must have names".to_owned());
        }
        if !times.into_iter().all(positive) {
            return Some("times and their ratios must be finite and above 0".to_owned());
        }
        if self.time_log_sd.is_some_and(|sd| !(sd.is_finite() && sd >= 0.0)) {
            return Some("time_log_sd must be finite and at least 0".to_owned());
        }
        (self.time_samples.is_some_and(|samples| samples < 2)).then(|| "time_samples must be at least 2".to_owned())
    }
}

/// All rows of a file, oldest record first.
#[derive(Debug, Clone, Default)]
pub struct History {
    /// Where it came from.
    pub path: PathBuf,
    /// Rows in the order of the file.
    pub rows: Vec<Row>,
}

impl History {
    /// Reads a history.
    ///
    /// # Errors
    /// [`Error::File`] with the line, if the file is missing, not a history, or damaged.
    pub fn read(path: &Path) -> Result<Self> {
        // Reading a pipe would wait for somebody who writes.
        if path.exists() && !path.is_file() {
            return Err(Error::file(path, "is no regular file, so no history"));
        }
        let mut reader = csv::Reader::from_path(path).map_err(|error| Error::file(path, error))?;
        // Without rows nothing else would show that it is something else, and the next record would replace it.
        let header = reader.headers().map_err(|error| Error::file(path, error))?;
        if !header.is_empty() && !NAMES.iter().all(|name| header.iter().any(|column| column == *name)) {
            return Err(Error::file(path, format!("is no history: it lacks a column {}", NAMES.join(" or "))));
        }
        let mut rows: Vec<Row> = Vec::new();
        let mut seen = HashSet::new();
        for (index, row) in reader.deserialize().enumerate() {
            let row: Row = row.map_err(|error| Error::file(path, error))?;
            let wrong = |what: &str| Error::file(path, format!("row {}: {what}", index + 1));
            if let Some(fault) = row.fault() {
                return Err(wrong(&fault));
            }
            if !seen.insert((row.record.clone(), row.benchmark.clone())) {
                return Err(wrong(&format!("benchmark {} stands twice in record {}", row.benchmark, row.record)));
            }
            rows.push(row);
        }
        Ok(History { path: path.to_owned(), rows })
    }

    /// Reads a history, or begins one if there is no file.
    ///
    /// # Errors
    /// Those of [`History::read`] for a file that exists.
    pub fn read_or_begin(path: &Path) -> Result<Self> {
        if path.exists() { Self::read(path) } else { Ok(History { path: path.to_owned(), rows: Vec::new() }) }
    }

    /// Adds the rows of a record to the file as it is by now, and writes it anew, whole or not at all. What others have
    /// recorded since it was read stays, unless they write at the very same moment.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read or written.
    pub fn append(&mut self, rows: &[Row]) -> Result<()> {
        self.rows = Self::read_or_begin(&self.path)?.rows;
        let all: Vec<&Row> = self.rows.iter().chain(rows).collect();
        write_atomically(&self.path, |out| {
            let mut writer = csv::Writer::from_writer(out);
            all.iter().try_for_each(|row| writer.serialize(row))?;
            writer.flush()
        })?;
        self.rows.extend_from_slice(rows);
        Ok(())
    }

    /// Names of the records, oldest first.
    pub fn records(&self) -> Vec<&str> {
        let mut records: Vec<&str> = Vec::new();
        for row in &self.rows {
            if !records.contains(&row.record.as_str()) {
                records.push(&row.record);
            }
        }
        records
    }

    /// Rows of one record.
    pub fn of_record(&self, record: &str) -> Vec<&Row> {
        self.rows.iter().filter(|row| row.record == record).collect()
    }

    /// The record that a selector names: `latest`, `previous`, a record or the start of one, or a git revision or the
    /// start of one (its newest record).
    ///
    /// # Errors
    /// [`Error::InvalidValue`] naming the records there are.
    pub fn select(&self, selector: &str) -> Result<&str> {
        let records = self.records();
        let newest = |wanted: fn(&Row) -> &str| {
            (selector.len() >= LEAST_DIGITS)
                .then(|| self.rows.iter().rev().find(|row| wanted(row).starts_with(selector)))
                .flatten()
                .map(|row| row.record.as_str())
        };
        // A full revision is longer than what is recorded.
        let longer = |row: &&Row| row.git_revision.len() >= LEAST_DIGITS && selector.starts_with(&row.git_revision);
        let found = match selector {
            "latest" => records.last().copied(),
            "previous" => records.len().checked_sub(2).map(|index| records[index]),
            _ => newest(|row| &row.record)
                .or_else(|| newest(|row| &row.git_revision))
                .or_else(|| self.rows.iter().rev().find(longer).map(|row| row.record.as_str())),
        };
        found.ok_or_else(|| {
            let name = |record: &&str| format!("{record} ({})", self.of_record(record)[0].git_revision);
            let known: Vec<String> = records.iter().rev().take(MOST_NAMED).map(name).collect();
            let expected = format!(
                "latest, previous, or at least {LEAST_DIGITS} digits of a record or git revision of {}: {}",
                self.path.display(),
                if known.is_empty() { "it has none".to_owned() } else { known.join(", ") }
            );
            Error::invalid("record", selector, expected)
        })
    }
}

/// Columns that every history has had.
const NAMES: [&str; 2] = ["record", "benchmark"];
/// Digits that name a record or revision.
const LEAST_DIGITS: usize = 4;
/// Records an error names.
const MOST_NAMED: usize = 8;
