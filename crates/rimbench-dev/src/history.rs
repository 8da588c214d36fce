//! Rows of `history.csv`, and how records are named.

use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::results_table::read_table;
use std::collections::HashSet;
use std::iter::once;
use std::path::{Path, PathBuf};

/// One benchmark of one record.
#[derive(Debug, Clone, PartialEq)]
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

/// Columns before the counters; instructions stand behind.
const NAMES: [&str; 9] =
    ["record", "recorded_at_unix_s", "git_revision", "git_dirty", "rustc", "target", "cpu", "benchmark", "status"];

fn header() -> impl Iterator<Item = &'static str> {
    NAMES.into_iter().chain(COUNTERS).chain(once("instructions"))
}

impl Row {
    /// Whether the benchmark gave its answer.
    pub fn is_ok(&self) -> bool {
        self.status == "ok"
    }

    /// Reads the cells under [`header`].
    fn of(mut cells: Vec<String>) -> std::result::Result<Self, String> {
        let whole = |(name, text): (&str, &String)| {
            text.parse::<u64>().map_err(|_| format!("{name} = `{text}` is no whole number from 0 on"))
        };
        let mut numbers = header().zip(&cells).skip(NAMES.len());
        let mut counters = [0; COUNTERS.len()];
        for (counter, cell) in counters.iter_mut().zip(&mut numbers) {
            *counter = whole(cell)?;
        }
        let instructions = numbers.next().filter(|(_, text)| !text.is_empty()).map(whole).transpose()?;
        let recorded_at_unix_s = whole((NAMES[1], &cells[1]))?;
        let mut text = |index: usize| std::mem::take(&mut cells[index]);
        let [record, git_revision, git_dirty, rustc, target, cpu, benchmark, status] =
            [0, 2, 3, 4, 5, 6, 7, 8].map(&mut text);
        if record.is_empty() || benchmark.is_empty() {
            return Err("a record and a benchmark must have names".to_owned());
        }
        Ok(Row {
            record,
            recorded_at_unix_s,
            git_revision,
            git_dirty,
            rustc,
            target,
            cpu,
            benchmark,
            status,
            counters,
            instructions,
        })
    }

    fn cells(&self) -> Vec<String> {
        let [a, b, c] = [&self.record, &self.git_revision, &self.git_dirty].map(String::clone);
        let rest = [&self.rustc, &self.target, &self.cpu, &self.benchmark, &self.status].map(String::clone);
        let counters = self.counters.iter().map(u64::to_string);
        let instructions = self.instructions.map_or_else(String::new, |count| count.to_string());
        [a, self.recorded_at_unix_s.to_string(), b, c]
            .into_iter()
            .chain(rest)
            .chain(counters)
            .chain([instructions])
            .collect()
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
        let table = read_table(path)?;
        let columns = header().map(|name| table.column(name)).collect::<Result<Vec<usize>>>()?;
        let (mut rows, mut seen) = (Vec::new(), HashSet::new());
        for index in 0..table.len() {
            let wrong = |what: &str| Error::file(path, format!("row {}: {what}", index + 1));
            let cells = columns.iter().map(|column| table.text(index, *column).to_owned()).collect();
            let row = Row::of(cells).map_err(|what| wrong(&what))?;
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
        self.rows.extend_from_slice(rows);
        write_atomically(&self.path, |out| {
            let mut writer = csv::Writer::from_writer(out);
            writer.write_record(header())?;
            self.rows.iter().try_for_each(|row| writer.write_record(row.cells()))?;
            writer.flush()
        })
    }

    /// Names of the records, oldest first.
    pub fn records(&self) -> Vec<&str> {
        let mut seen = HashSet::new();
        self.rows.iter().map(|row| row.record.as_str()).filter(|record| seen.insert(*record)).collect()
    }

    /// Rows of the record that a selector names: `latest`, `previous`, or the start of a record or of a git revision (its newest record).
    ///
    /// # Errors
    /// [`Error::InvalidValue`] naming the records there are.
    pub fn select(&self, selector: &str) -> Result<Vec<Row>> {
        let records = self.records();
        // A full revision is longer than what is recorded.
        let starts = |name: &str| {
            name.len().min(selector.len()) >= LEAST_DIGITS && (name.starts_with(selector) || selector.starts_with(name))
        };
        let newest = |wanted: fn(&Row) -> &str| self.rows.iter().rev().find(|row| starts(wanted(row)));
        let found = match selector {
            "latest" => records.last().copied(),
            "previous" => records.iter().rev().nth(1).copied(),
            _ => newest(|row| &row.record).or_else(|| newest(|row| &row.git_revision)).map(|row| row.record.as_str()),
        };
        let Some(found) = found else {
            let revision =
                |record: &str| self.rows.iter().find(|row| row.record == record).map(|row| &row.git_revision);
            let known: Vec<String> = records
                .iter()
                .rev()
                .take(MOST_NAMED)
                .map(|record| format!("{record} ({})", revision(record).map_or("", String::as_str)))
                .collect();
            let expected = format!(
                "latest, previous, or at least {LEAST_DIGITS} digits of a record or git revision of {}: {}",
                self.path.display(),
                if known.is_empty() { "it has none".to_owned() } else { known.join(", ") }
            );
            return Err(Error::invalid("record", selector, expected));
        };
        Ok(self.rows.iter().filter(|row| row.record == found).cloned().collect())
    }
}

/// Digits that name a record or revision.
const LEAST_DIGITS: usize = 4;
/// Records an error names.
const MOST_NAMED: usize = 8;
