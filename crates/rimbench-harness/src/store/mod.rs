//! The store of an experiment: one record per run, appended as runs finish, safe against being killed at any instant.
//!
//! ```text
//! <folder>/records/<time>-<process>.log
//!     rimbench-store 4 <experiment> <hash of the reference> <columns of findings> <of costs> <of provenance> <checksum>
//!     <checksum> <run id> TAB <findings> TAB <costs> TAB <provenance> TAB <trace> TAB <wall limit>
//!     …
//! ```
//! Each process appends to a file of its own, so that shards can be run at once; a record is one write and is known by its
//! run id. A record that is cut short or damaged fails its checksum and is computed again, as are all below a damaged first line. Of several records of one run the one
//! that says most stands, whatever their order: a run that came to an end before one that took too long, of those the one that
//! was given most time, and else the newest. What a plan says of a run (its label, its settings) is no part of a record.
//! A log that was written with other columns is read by their names: a metric that came later is an empty cell.
//!
//! All records are held in memory, which an experiment has no more runs than there is room for
//! ([`MOST_RUNS`](super::experiment::MOST_RUNS)).

mod columns;
mod record;

pub use columns::Columns;
pub use record::{Record, TraceMark};
pub(crate) use record::{cells_of, row};

use rayon::prelude::*;
use record::{checksum, line_of};
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums::sha256;
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// First word and version of the layout.
const MAGIC: &str = "rimbench-store";
const LAYOUT: u32 = 4;
/// The same without a checksum of the first line, which is read still.
const WITHOUT_CHECKSUM: &str = "3";

/// No header is longer, bytes.
const LONGEST_HEADER: u64 = 1 << 14;

/// Data reach the disk at least this often, s; against a crash of the program a write is enough.
const SYNC_EVERY_S: f64 = 2.0;

/// The records of one experiment.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    header: String,
    columns: Columns,
    /// What was stored when it was opened, by run id.
    records: HashMap<String, Record>,
    /// Records that were cut short or damaged, and are as good as never written.
    pub damaged: usize,
    log: Mutex<Option<Log>>,
}

#[derive(Debug)]
struct Log {
    file: File,
    path: PathBuf,
    synced: Instant,
}

impl Store {
    /// Opens the store of `experiment` in its results folder and reads what is there. `reference` says what all runs are held against;
    /// records held against something else are another store.
    ///
    /// # Errors
    /// [`Error::File`] if the store belongs to another experiment, or to another version of rimbench.
    pub fn open(folder: &Path, experiment: &str, reference: &str, columns: Columns) -> Result<Self> {
        let records = folder.join("records");
        let (name, reference) = (experiment.replace(char::is_whitespace, "_"), &sha256(reference)[..12]);
        let header = format!("{MAGIC} {LAYOUT} {name} {reference} {columns}");
        let mut store = Store {
            header: format!("{header} {}", checksum(&header)),
            columns,
            folder: records.clone(),
            records: HashMap::new(),
            damaged: 0,
            log: Mutex::new(None),
        };
        let read: Vec<Result<(Vec<Record>, usize)>> =
            logs_in(&records).par_iter().map(|path| store.contents(path)).collect();
        for contents in read {
            let (records, damaged) = contents?;
            store.damaged += damaged;
            store.hold(records);
        }
        Ok(store)
    }

    /// Takes records up into memory, later ones behind earlier ones.
    pub(super) fn hold(&mut self, records: Vec<Record>) {
        for record in records {
            if self.get(&record.run_id).is_none_or(|known| record.allowed_s() >= known.allowed_s()) {
                self.records.insert(record.run_id.clone(), record);
            }
        }
    }

    /// Name of the experiment whose records a results folder holds; none if it holds no record.
    pub fn experiment_in(folder: &Path) -> Option<String> {
        let name_in = |path: PathBuf| {
            let mut line = String::new();
            BufReader::new(File::open(path).ok()?).take(LONGEST_HEADER).read_line(&mut line).ok()?;
            let mut words = line.strip_suffix('\n')?.split(' ');
            (words.next()? == MAGIC).then(|| words.nth(1).map(str::to_owned)).flatten()
        };
        logs_in(&folder.join("records")).into_iter().find_map(name_in)
    }

    /// Removes all records of a results folder.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn clear(folder: &Path) -> Result<()> {
        let records = folder.join("records");
        match std::fs::remove_dir_all(&records) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(Error::file(&records, format!("cannot be removed: {error}")))
            }
            _ => Ok(()),
        }
    }

    /// Returns the number of runs stored.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Tells whether no run is stored.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the record of a run, if it was stored when the store was opened.
    pub fn get(&self, run_id: &str) -> Option<&Record> {
        self.records.get(run_id)
    }

    /// Whether a run is stored that may take so long: one that took too long counts only if it had at least that time.
    pub fn holds(&self, run_id: &str, wall_limit: Option<Duration>) -> bool {
        let wanted_s = wall_limit.map_or(f64::INFINITY, |limit| limit.as_secs_f64());
        self.get(run_id).is_some_and(|record| record.allowed_s() >= wanted_s)
    }

    /// Appends a record to the log with one write; who opens the store next holds it. Safe to call from several threads.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written, for example on a full disk; what was stored before stays.
    pub fn append(&self, record: &Record) -> Result<()> {
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        let log = match &mut *log {
            Some(log) => log,
            empty => empty.insert(self.create_log()?),
        };
        let line = line_of(record);
        let mut write = || {
            log.file.write_all(line.as_bytes())?;
            if log.synced.elapsed().as_secs_f64() > SYNC_EVERY_S {
                log.synced = Instant::now();
                log.file.sync_data()?;
            }
            Ok(())
        };
        write().map_err(|error: std::io::Error| {
            Error::file(&log.path, format!("cannot be written: {error}; what was stored before is kept"))
        })
    }

    /// Makes sure that everything appended has reached the disk.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn sync(&self) -> Result<()> {
        let log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        match &*log {
            Some(log) => log.file.sync_data().map_err(|error| Error::file(&log.path, error)),
            None => Ok(()),
        }
    }

    /// A log file that is this process's alone.
    fn create_log(&self) -> Result<Log> {
        let failed = |error: std::io::Error| Error::file(&self.folder, format!("cannot be written: {error}"));
        std::fs::create_dir_all(&self.folder).map_err(failed)?;
        let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let path = self.folder.join(format!("{:020}-{}.log", since_epoch.as_nanos(), std::process::id()));
        let mut file = OpenOptions::new().append(true).create_new(true).open(&path).map_err(failed)?;
        file.write_all(format!("{}\n", self.header).as_bytes()).map_err(failed)?;
        Ok(Log { file, path, synced: Instant::now() })
    }

    /// Reads a log: its records in its order, and how many are damaged.
    fn contents(&self, path: &Path) -> Result<(Vec<Record>, usize)> {
        let failed = |error: std::io::Error| Error::file(path, format!("cannot be read: {error}"));
        let mut reader = BufReader::with_capacity(1 << 16, File::open(path).map_err(failed)?);
        let (mut line, mut records, mut damaged) = (Vec::new(), Vec::new(), 0);
        reader.read_until(b'\n', &mut line).map_err(failed)?;
        if line.last() != Some(&b'\n') {
            // Killed while the header was written: nothing was stored.
            return Ok((records, damaged));
        }
        let written = self.check_header(path, String::from_utf8_lossy(&line).trim_end())?;
        let places = written.map(|written| self.columns.places_in(&written));
        loop {
            line.clear();
            if reader.read_until(b'\n', &mut line).map_err(failed)? == 0 {
                return Ok((records, damaged));
            }
            let text = std::str::from_utf8(&line).ok().and_then(|line| line.strip_suffix('\n'));
            match text.and_then(Record::parse).and_then(|record| places.as_ref()?.rearrange(record)) {
                Some(record) => records.push(record),
                None => damaged += 1,
            }
        }
    }

    /// The columns that a log was written with; none if its first line is damaged.
    fn check_header(&self, path: &Path, found: &str) -> Result<Option<Columns>> {
        let (own, other): (Vec<&str>, Vec<&str>) = (self.header.split(' ').collect(), found.split(' ').collect());
        let whole = |sum: &[&str]| match sum {
            [] => other[1] == WITHOUT_CHECKSUM,
            [sum] => other[1] == own[1] && found.rsplit_once(' ').is_some_and(|(line, _)| checksum(line) == *sum),
            _ => false,
        };
        let message = match other.as_slice() {
            [magic, layout, experiment, reference, findings, costs, provenance, sum @ ..]
                if [*magic, *experiment, *reference] == [own[0], own[2], own[3]]
                    && [own[1], WITHOUT_CHECKSUM].contains(layout) =>
            {
                let columns = || Columns::of([findings, costs, provenance].map(|names| names.split(',')));
                return Ok(whole(sum).then(columns));
            }
            [magic, layout, ..] if *magic == MAGIC && ![own[1], WITHOUT_CHECKSUM].contains(layout) => {
                format!("was written with store layout {layout}, this is layout {LAYOUT}")
            }
            [magic, _, experiment, ..] if *magic == MAGIC && *experiment != own[2] => {
                format!(
                    "belongs to experiment `{experiment}`, not to `{}`: give each experiment its own folder",
                    own[2]
                )
            }
            [magic, ..] if *magic == MAGIC => "was held against another reference".to_owned(),
            _ => format!("is no record file (it begins `{}`)", found.chars().take(40).collect::<String>()),
        };
        Err(Error::file(path, format!("{message}; use another folder, or --fresh to start again")))
    }
}

/// The logs of a store, in the order in which they were begun.
fn logs_in(records: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(records).into_iter().flatten();
    let mut logs: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    logs.retain(|path| path.extension().is_some_and(|extension| extension == "log") && path.is_file());
    logs.sort();
    logs
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> Columns {
        Columns::of([["outcome", "error"], ["wall_s", "load"], ["run_id", "revision"]])
    }

    fn record(id: &str) -> Record {
        Record {
            run_id: id.to_owned(),
            findings: "completed,1.5".to_owned(),
            costs: "0.01".to_owned(),
            provenance: format!("{id},abc"),
            trace: Some(TraceMark { every_s: 1e-3, sha256: "ab".to_owned() }),
            wall_limit_s: None,
        }
    }

    fn too_long(id: &str, wall_limit_s: f64) -> Record {
        Record { findings: "timeout,".to_owned(), trace: None, wall_limit_s: Some(wall_limit_s), ..record(id) }
    }

    #[test]
    fn a_run_that_took_too_long_counts_only_for_those_who_give_it_no_more_time() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), "test", "", columns()).unwrap();
        store.append(&too_long("aa", 2.0)).unwrap();
        store.append(&record("bb")).unwrap();
        let store = Store::open(folder.path(), "test", "", columns()).unwrap();
        let limit = |seconds: u64| Some(Duration::from_secs(seconds));
        assert_eq!(
            [limit(1), limit(2), limit(3), None].map(|limit| store.holds("aa", limit)),
            [true, true, false, false]
        );
        assert_eq!([limit(1), None].map(|limit| store.holds("bb", limit)), [true, true]);
        assert!(!store.holds("cc", limit(1)));
        assert_eq!(Store::experiment_in(folder.path()).as_deref(), Some("test"));
        assert_eq!(Store::experiment_in(&folder.path().join("records")), None);
    }

    #[test]
    fn records_below_a_damaged_line_of_columns_are_computed_again() {
        let folder = tempfile::tempdir().unwrap();
        let open = || Store::open(folder.path(), "test", "", columns());
        open().unwrap().append(&record("aa")).unwrap();
        let path = logs_in(&folder.path().join("records")).remove(0);
        let whole = std::fs::read_to_string(&path).unwrap();
        for (from, to, held) in [
            ("", "", 1),
            (",error ", ",errer ", 0),
            (" run_id", ",run_id", 0),
            // As it was written before there was a checksum.
            (
                whole.lines().next().unwrap(),
                "rimbench-store 3 test e3b0c44298fc outcome,error wall_s,load run_id,revision",
                1,
            ),
        ] {
            std::fs::write(&path, whole.replacen(from, to, 1)).unwrap();
            let store = open().unwrap();
            assert_eq!([store.len(), store.damaged], [held, 1 - held], "{from} {to}");
        }
    }

    #[test]
    fn a_store_of_something_else_is_refused_with_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        Store::open(folder.path(), "test", "", columns()).unwrap().append(&record("aa")).unwrap();
        let message = |experiment, reference| {
            Store::open(folder.path(), experiment, reference, columns()).unwrap_err().to_string()
        };
        assert!(message("other", "").contains("belongs to experiment `test`"));
        assert!(message("test", "other").contains("another reference"));
        let path = std::fs::read_dir(folder.path().join("records")).unwrap().next().unwrap().unwrap().path();
        std::fs::write(&path, "rimbench-store 0 test abc\n").unwrap();
        assert!(message("test", "").contains("store layout 0"));
        std::fs::write(&path, "something else\n").unwrap();
        assert!(message("test", "").contains("no record file"));
        Store::clear(folder.path()).unwrap();
        assert!(Store::open(folder.path(), "test", "", columns()).unwrap().is_empty());
    }
}
