//! The store of an experiment: one record per run, appended as runs finish, safe against being killed at any instant.
//!
//! ```text
//! <folder>/records/<time>-<process>.log
//!     rimbench-store 2 <experiment> <hash of the column names>
//!     <checksum> <run id> TAB <findings> TAB <costs> TAB <provenance> TAB <trace> TAB <wall limit>
//!     …
//! ```
//! Each process appends to a file of its own, so that shards can be run at once; a record is one write and is known by its
//! run id. A record that is cut short or damaged fails its checksum and is computed again. Of several records of one run the one
//! that says most stands, whatever their order: a run that came to an end before one that took too long, of those the one that
//! was given most time, and else the newest. What a plan says of a run (its label, its settings) is no part of a record.

use super::cache::hex;
use rayon::prelude::*;
use rimbench_core::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::collections::{HashMap, HashSet};
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// First word and version of the layout.
const MAGIC: &str = "rimbench-store";
const LAYOUT: u32 = 2;

/// No header is longer, bytes.
const LONGEST_HEADER: u64 = 1 << 12;

/// Data reach the disk at least this often, s; against a crash of the program a write is enough.
const SYNC_EVERY_S: f64 = 2.0;

/// Logs that are read before what was read of them is taken over.
const LOGS_AT_ONCE: usize = 16;

/// Digits of a checksum.
const CHECKSUM: usize = 16;

/// One finished run: what was found, as cells of the three files, without line ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// [`RunSpec::id`](rimbench_cases::runs::RunSpec::id).
    pub run_id: String,
    /// Cells of `runs.csv` behind the settings.
    pub findings: String,
    /// Cells of `cost.csv` behind the settings.
    pub costs: String,
    /// Row of `provenance.csv`.
    pub provenance: String,
    /// The trace that was written with it.
    pub trace: Option<TraceMark>,
    /// Wall time that the run was given and that was not enough, s; none for a run that came to an end.
    pub wall_limit_s: Option<f64>,
}

/// A record as it stands in its line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<'a> {
    pub(super) run_id: &'a str,
    pub(super) findings: &'a str,
    pub(super) costs: &'a str,
    pub(super) provenance: &'a str,
    /// Distance of the rows of the trace, s, and its SHA-256.
    pub(super) trace: Option<(f64, &'a str)>,
    pub(super) wall_limit_s: Option<f64>,
}

impl Line<'_> {
    fn to_record(self) -> Record {
        let Line { run_id, findings, costs, provenance, trace, wall_limit_s } = self;
        let [run_id, findings, costs, provenance] = [run_id, findings, costs, provenance].map(str::to_owned);
        let trace = trace.map(|(every_s, sha256)| TraceMark { every_s, sha256: sha256.to_owned() });
        Record { run_id, findings, costs, provenance, trace, wall_limit_s }
    }
}

/// A run id, filled up with zeros: an index of a million runs is to take little.
type Key = [u8; 16];

/// The key of a run id; none of a text that is none, being longer.
fn key(run_id: &str) -> Option<Key> {
    let mut key = Key::default();
    key.get_mut(..run_id.len())?.copy_from_slice(run_id.as_bytes());
    Some(key)
}

/// By what a trace is known again.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceMark {
    /// Distance of its rows, s.
    pub every_s: f64,
    /// SHA-256 of the file.
    pub sha256: String,
}

/// Where a record lies.
#[derive(Debug, Clone, Copy)]
struct Place {
    file: u32,
    length: u32,
    offset: u64,
    /// Wall time after which the run was ended, s; infinite if it came to an end.
    allowed_s: f64,
}

/// The records of one experiment.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    header: String,
    files: Vec<PathBuf>,
    index: HashMap<Key, Place>,
    /// Records that were cut short or damaged, and are as good as never written.
    pub damaged: usize,
    log: Mutex<Option<Log>>,
    /// Where was read last: records are mostly read in the order in which they were written.
    reading: Mutex<Reading>,
}

/// A log that is read from.
#[derive(Debug, Default)]
struct Reading {
    /// Number of the log, the log, and how far it has been read.
    log: Option<(u32, BufReader<File>, u64)>,
    /// The line read last.
    line: Vec<u8>,
}

/// Reads records one after the other, by itself: each thread may have one.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    store: &'a Store,
    reading: Reading,
}

impl Reader<'_> {
    /// Reads a record.
    ///
    /// # Errors
    /// Those of [`Store::read`].
    pub(super) fn read(&mut self, run_id: &str) -> Result<Option<Line<'_>>> {
        self.store.read_line(run_id, &mut self.reading)
    }
}

#[derive(Debug)]
struct Log {
    file: File,
    path: PathBuf,
    synced: Instant,
}

impl Store {
    /// Opens the store of `experiment` in its results folder and reads which runs are there. `columns` are the names of
    /// all columns, which a record must have been written with.
    ///
    /// # Errors
    /// [`Error::File`] if the store belongs to another experiment, or to another version of rimbench.
    pub fn open(folder: &Path, experiment: &str, columns: &str) -> Result<Self> {
        Self::open_of(folder, experiment, columns, None)
    }

    /// The same, of some runs only: others are as if they were not there, damaged ones included.
    ///
    /// # Errors
    /// Those of [`open`](Self::open).
    pub(super) fn open_for<'a>(
        folder: &Path,
        experiment: &str,
        columns: &str,
        run_ids: impl Iterator<Item = &'a str>,
    ) -> Result<Self> {
        Self::open_of(folder, experiment, columns, Some(&run_ids.filter_map(key).collect()))
    }

    fn open_of(folder: &Path, experiment: &str, columns: &str, wanted: Option<&HashSet<Key>>) -> Result<Self> {
        let records = folder.join("records");
        let columns_hash = &hex(&Sha256::digest(columns))[..12];
        let mut store = Store {
            header: format!("{MAGIC} {LAYOUT} {} {columns_hash}", experiment.replace(char::is_whitespace, "_")),
            folder: records.clone(),
            files: Vec::new(),
            index: HashMap::new(),
            damaged: 0,
            log: Mutex::new(None),
            reading: Mutex::default(),
        };
        let logs = logs_in(&records);
        for logs in logs.chunks(LOGS_AT_ONCE) {
            let read: Vec<Result<Contents>> = logs.par_iter().map(|path| store.contents(path, wanted)).collect();
            for (path, contents) in logs.iter().zip(read) {
                store.take_over(path, contents?);
            }
        }
        Ok(store)
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
        self.index.len()
    }

    /// Tells whether no run is stored.
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// Wall time that a stored run was given before it was ended, s; infinite if it came to an end, none if it is not stored.
    pub fn allowed_s(&self, run_id: &str) -> Option<f64> {
        self.index.get(&key(run_id)?).map(|place| place.allowed_s)
    }

    /// Whether a run is stored that may take so long: one that took too long counts only if it had at least that time.
    pub fn holds(&self, run_id: &str, wall_limit: Option<Duration>) -> bool {
        let wanted_s = wall_limit.map_or(f64::INFINITY, |limit| limit.as_secs_f64());
        self.allowed_s(run_id).is_some_and(|allowed_s| allowed_s >= wanted_s)
    }

    /// Reads a record.
    ///
    /// # Errors
    /// [`Error::File`] if the file has gone since the store was opened.
    pub fn read(&self, run_id: &str) -> Result<Option<Record>> {
        let mut reading = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(self.read_line(run_id, &mut reading)?.map(Line::to_record))
    }

    /// A way to read many.
    pub(super) fn reader(&self) -> Reader<'_> {
        Reader { store: self, reading: Reading::default() }
    }

    fn read_line<'r>(&self, run_id: &str, reading: &'r mut Reading) -> Result<Option<Line<'r>>> {
        let Some(place) = key(run_id).and_then(|key| self.index.get(&key)) else { return Ok(None) };
        let path = &self.files[place.file as usize];
        let Reading { log, line } = reading;
        let read = |log: &mut Option<(u32, BufReader<File>, u64)>, line: &mut Vec<u8>| -> std::io::Result<()> {
            let (_, file, at) = match log {
                Some(log) if log.0 == place.file => log,
                other => other.insert((place.file, BufReader::with_capacity(1 << 16, File::open(path)?), 0)),
            };
            // What lies near is in the buffer already.
            file.seek_relative(place.offset as i64 - *at as i64)?;
            line.resize(place.length as usize, 0);
            *at = place.offset;
            file.read_exact(line)?;
            *at += u64::from(place.length);
            Ok(())
        };
        if let Err(error) = read(log, line) {
            // Nobody knows where it stands now.
            *log = None;
            return Err(Error::file(path, format!("cannot be read: {error}")));
        }
        Ok(std::str::from_utf8(line).ok().and_then(parse))
    }

    /// Appends a record with one write. Safe to call from several threads.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written, for example on a full disk; what was stored before stays.
    pub fn append(&self, record: &Record) -> Result<()> {
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        let log = match &mut *log {
            Some(log) => log,
            empty => empty.insert(self.create_log()?),
        };
        let payload = payload(record);
        let line = format!("{} {payload}\n", String::from_utf8_lossy(&checksum(&payload)));
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

    /// Reads a log: where its records lie, in its order.
    fn contents(&self, path: &Path, wanted: Option<&HashSet<Key>>) -> Result<Contents> {
        let failed = |error: std::io::Error| Error::file(path, format!("cannot be read: {error}"));
        let mut reader = BufReader::with_capacity(1 << 16, File::open(path).map_err(failed)?);
        let (mut line, mut contents) = (Vec::new(), Contents::default());
        let mut offset = reader.read_until(b'\n', &mut line).map_err(failed)? as u64;
        if line.last() != Some(&b'\n') {
            // Killed while the header was written: nothing was stored.
            return Ok(contents);
        }
        self.check_header(path, String::from_utf8_lossy(&line).trim_end())?;
        loop {
            line.clear();
            let length = reader.read_until(b'\n', &mut line).map_err(failed)?;
            if length == 0 {
                return Ok(contents);
            }
            let text = std::str::from_utf8(&line).ok().and_then(|line| line.strip_suffix('\n'));
            // Before it is known to be whole: of what nobody wants that need not be found out.
            let id = |text: &str| key(text.get(CHECKSUM + 1..)?.split('\t').next()?);
            if wanted.is_none_or(|wanted| text.and_then(id).is_some_and(|id| wanted.contains(&id))) {
                match text.and_then(parse).and_then(|record| Some((key(record.run_id)?, record.wall_limit_s))) {
                    Some((key, limit)) => {
                        contents.records.push((key, offset, length as u32 - 1, limit.unwrap_or(f64::INFINITY)));
                    }
                    None => contents.damaged += 1,
                }
            }
            offset += length as u64;
        }
    }

    /// Takes over what was read of a log, the logs in their order.
    fn take_over(&mut self, path: &Path, contents: Contents) {
        let file = self.files.len() as u32;
        self.files.push(path.to_owned());
        self.damaged += contents.damaged;
        self.index.reserve(contents.records.len());
        for (key, offset, length, allowed_s) in contents.records {
            let place = Place { file, length, offset, allowed_s };
            let known = self.index.entry(key).or_insert(place);
            if allowed_s >= known.allowed_s {
                *known = place;
            }
        }
    }

    fn check_header(&self, path: &Path, found: &str) -> Result<()> {
        if found == self.header {
            return Ok(());
        }
        let (own, other): (Vec<&str>, Vec<&str>) = (self.header.split(' ').collect(), found.split(' ').collect());
        let message = match other.as_slice() {
            [magic, layout, ..] if *magic == MAGIC && *layout != own[1] => {
                format!("was written with store layout {layout}, this is layout {LAYOUT}")
            }
            [magic, _, experiment, _] if *magic == MAGIC && *experiment != own[2] => {
                format!(
                    "belongs to experiment `{experiment}`, not to `{}`: give each experiment its own folder",
                    own[2]
                )
            }
            [magic, ..] if *magic == MAGIC => "was written with other metrics, counters or reference".to_owned(),
            _ => format!("is no record file (it begins `{}`)", found.chars().take(40).collect::<String>()),
        };
        Err(Error::file(path, format!("{message}; use another folder, or --fresh to start anew")))
    }
}

/// What was read of a log.
#[derive(Debug, Default)]
struct Contents {
    /// Key, offset, length, and the wall time after which the run was ended (s).
    records: Vec<(Key, u64, u32, f64)>,
    damaged: usize,
}

/// The logs of a store, in the order in which they were begun.
fn logs_in(records: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(records).into_iter().flatten();
    let mut logs: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    logs.retain(|path| path.extension().is_some_and(|extension| extension == "log") && path.is_file());
    logs.sort();
    logs
}

/// The first half of the digits of the SHA-256.
fn checksum(payload: &str) -> [u8; CHECKSUM] {
    let digest = Sha256::digest(payload);
    std::array::from_fn(|place| {
        let half = digest[place / 2] >> (4 * ((place + 1) % 2)) & 15;
        b"0123456789abcdef"[usize::from(half)]
    })
}

/// A record as text, without its checksum.
fn payload(record: &Record) -> String {
    let Record { run_id, findings, costs, provenance, trace, wall_limit_s } = record;
    let trace = trace.as_ref().map(|trace| format!("{:?} {}", trace.every_s, trace.sha256)).unwrap_or_default();
    let limit = wall_limit_s.map(|limit| format!("{limit:?}")).unwrap_or_default();
    [run_id, findings, costs, provenance, trace.as_str(), limit.as_str()].join("\t")
}

/// The record of a line that is whole.
fn parse(line: &str) -> Option<Line<'_>> {
    let (sum, payload) = line.split_once(' ')?;
    if checksum(payload) != sum.as_bytes() {
        return None;
    }
    let mut parts = payload.split('\t');
    let mut next = || parts.next();
    let [run_id, findings, costs, provenance, trace, limit] = [next()?, next()?, next()?, next()?, next()?, next()?];
    if next().is_some() {
        return None;
    }
    let trace = match trace.split_once(' ') {
        None if trace.is_empty() => None,
        None => return None,
        Some((every_s, sha256)) => Some((every_s.parse().ok()?, sha256)),
    };
    let wall_limit_s = if limit.is_empty() { None } else { Some(limit.parse().ok()?) };
    Some(Line { run_id, findings, costs, provenance, trace, wall_limit_s })
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn of_several_records_of_one_run_the_one_that_says_most_stands_in_every_order() {
        let records = [record("aa"), too_long("aa", 1.0), too_long("aa", 60.0)];
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let folder = tempfile::tempdir().unwrap();
            for (count, &index) in order.iter().enumerate() {
                let store = Store::open(folder.path(), "test", "columns").unwrap();
                store.append(&records[index]).unwrap();
                drop(store);
                let store = Store::open(folder.path(), "test", "columns").unwrap();
                let best = order[..=count].iter().copied().min_by_key(|&k| [0, 2, 1][k]).unwrap();
                assert_eq!(store.read("aa").unwrap().as_ref(), Some(&records[best]), "{order:?} {count}");
            }
        }
    }

    #[test]
    fn a_run_that_took_too_long_counts_only_for_those_who_give_it_no_more_time() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), "test", "columns").unwrap();
        store.append(&too_long("aa", 2.0)).unwrap();
        store.append(&record("bb")).unwrap();
        let store = Store::open(folder.path(), "test", "columns").unwrap();
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

    fn log_files(folder: &Path) -> Vec<PathBuf> {
        std::fs::read_dir(folder.join("records")).unwrap().map(|entry| entry.unwrap().path()).collect()
    }

    #[test]
    fn records_come_back_whatever_the_order_and_the_process() {
        let folder = tempfile::tempdir().unwrap();
        for ids in [["aa", "bb"], ["cc", "aa"]] {
            let store = Store::open(folder.path(), "test", "columns").unwrap();
            ids.iter().for_each(|id| store.append(&record(id)).unwrap());
            store.sync().unwrap();
        }
        let store = Store::open(folder.path(), "test", "columns").unwrap();
        assert_eq!((store.len(), store.damaged), (3, 0));
        for id in ["aa", "bb", "cc"] {
            assert_eq!(store.read(id).unwrap(), Some(record(id)));
        }
        assert_eq!(store.read("dd").unwrap(), None);
    }

    #[test]
    fn a_log_cut_anywhere_loses_at_most_the_record_that_was_cut() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), "test", "columns").unwrap();
        for id in ["aa", "bb", "cc"] {
            store.append(&record(id)).unwrap();
        }
        let path = log_files(folder.path()).remove(0);
        let whole = std::fs::read(&path).unwrap();
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            let store = Store::open(folder.path(), "test", "columns").unwrap();
            let lines = whole[..length].iter().filter(|byte| **byte == b'\n').count();
            assert_eq!(store.len(), lines.saturating_sub(1), "cut at {length}");
        }
        // A byte that has flipped in the middle costs its own record only.
        let mut damaged = whole.clone();
        let middle = whole.len() / 2 + 8;
        damaged[middle] ^= 1;
        std::fs::write(&path, damaged).unwrap();
        let store = Store::open(folder.path(), "test", "columns").unwrap();
        assert_eq!((store.len(), store.damaged), (2, 1));
    }

    #[test]
    fn a_store_of_something_else_is_refused_with_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        Store::open(folder.path(), "test", "columns").unwrap().append(&record("aa")).unwrap();
        let message = |experiment, columns| Store::open(folder.path(), experiment, columns).unwrap_err().to_string();
        assert!(message("other", "columns").contains("belongs to experiment `test`"));
        assert!(message("test", "other columns").contains("other metrics"));
        let path = log_files(folder.path()).remove(0);
        std::fs::write(&path, "rimbench-store 0 test abc\n").unwrap();
        assert!(message("test", "columns").contains("store layout 0"));
        std::fs::write(&path, "something else\n").unwrap();
        assert!(message("test", "columns").contains("no record file"));
        Store::clear(folder.path()).unwrap();
        assert!(Store::open(folder.path(), "test", "columns").unwrap().is_empty());
    }
}
