//! Rows of `history.csv`, and how records are named.

use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::input::read_text;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::path::Path;

/// One benchmark of one record; its fields are the columns.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
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
    /// Processor.
    pub cpu: String,
    /// Name in the suite.
    pub benchmark: String,
    /// `ok`, or what was wrong; then there are no measurements.
    pub status: String,
    /// Work of one repetition, as in [`COUNTERS`].
    pub counters: [u64; COUNTERS.len()],
    /// Instructions of one repetition.
    pub instructions: Option<u64>,
    /// Settings of the build; older histories do not have them.
    #[serde(default)]
    pub build: String,
}

/// Counters that are compared exactly.
pub const COUNTERS: [&str; 8] = [
    "macro_steps",
    "mechanics_micro_steps",
    "actuator_micro_steps",
    "eliminations",
    "lcp_solves",
    "lcp_pivots",
    "lcp_factorisations",
    "lcp_fallbacks",
];

fn header() -> Vec<&'static str> {
    let before =
        ["record", "recorded_at_unix_s", "git_revision", "git_dirty", "rustc", "target", "cpu", "benchmark", "status"];
    [&before[..], &COUNTERS, &["instructions", "build"]].concat()
}

impl Row {
    /// Whether the benchmark gave its answer.
    pub fn is_ok(&self) -> bool {
        self.status == "ok"
    }
}

/// All rows of a file, oldest record first.
#[derive(Debug, Clone, Default)]
pub struct History {
    /// Rows in the order of the file.
    pub rows: Vec<Row>,
}

impl History {
    /// Reads a history.
    ///
    /// # Errors
    /// [`Error::File`] with the row, if the file is missing, not a history, or damaged.
    pub fn read(path: &Path) -> Result<Self> {
        let text = read_text(path)?;
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let columns = reader.headers().cloned().unwrap_or_default();
        let wanted = header();
        if !(columns == wanted || columns == wanted[..wanted.len() - 1]) {
            return Err(Error::file(path, format!("is no history; valid columns: {}", wanted.join(", "))));
        }
        let (mut rows, mut seen) = (Vec::<Row>::new(), HashSet::new());
        for (index, record) in reader.records().enumerate() {
            let wrong = |what: String| Error::file(path, format!("row {}: {what}", index + 1));
            let row: Row = record.and_then(|row| row.deserialize(None)).map_err(|error| wrong(error.to_string()))?;
            if row.record.is_empty() || !seen.insert((row.record.clone(), row.benchmark.clone())) {
                return Err(wrong(format!("benchmark `{}` of record `{}` is there twice", row.benchmark, row.record)));
            }
            rows.push(row);
        }
        Ok(History { rows })
    }

    /// Adds the rows of a record to a file as it is by now, or begins one, and writes it anew, whole or not at all.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read or written.
    pub fn append(path: &Path, rows: &[Row]) -> Result<()> {
        let before = if path.exists() { Self::read(path)?.rows } else { Vec::new() };
        write_atomically(path, |out| {
            let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(out);
            writer.write_record(header())?;
            before.iter().chain(rows).try_for_each(|row| writer.serialize(row))?;
            writer.flush()
        })
    }

    /// Rows of the record that a selector names: `latest`, `previous`, or the start of a record or of a git revision
    /// (its newest record).
    ///
    /// # Errors
    /// [`Error::InvalidValue`] naming the newest records.
    pub fn select(&self, selector: &str) -> Result<Vec<Row>> {
        // Newest first.
        let mut records: Vec<&Row> = self.rows.iter().rev().collect();
        records.dedup_by_key(|row| &row.record);
        // A full revision is longer than what is recorded.
        let starts = |name: &str| {
            name.len().min(selector.len()) >= 4 && (name.starts_with(selector) || selector.starts_with(name))
        };
        let newest = |wanted: fn(&Row) -> &str| records.iter().find(|row| starts(wanted(row)));
        let found = match selector {
            "latest" => records.first(),
            "previous" => records.get(1),
            _ => newest(|row| &row.record).or_else(|| newest(|row| &row.git_revision)),
        };
        if selector == "previous" && records.len() == 1 {
            return Err(Error::invalid("record", selector, "latest: the history has one record"));
        }
        let Some(found) = found else {
            let known = records.iter().take(8).map(|row| format!("{} ({})", row.record, row.git_revision));
            let known = known.collect::<Vec<_>>().join(", ");
            let expected = format!("latest, previous, or at least 4 digits of a record or git revision: {known}");
            return Err(Error::invalid("record", selector, expected));
        };
        Ok(self.rows.iter().filter(|row| row.record == found.record).cloned().collect())
    }
}
