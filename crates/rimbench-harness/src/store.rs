//! The store of an experiment: one record per run, appended as runs finish, safe against being killed at any instant.
//!
//! ```text
//! <folder>/records/<time>-<process>.log
//!     rimbench-store 1 <experiment> <hash of the column names>
//!     <checksum> <row of runs.csv> TAB <row of cost.csv> TAB <row of provenance.csv>
//!     …
//! ```
//! Each process appends to a file of its own, so that shards can be run at once; a record is one write and is known by its
//! run id, so its order does not matter. A record that is cut short or damaged fails its checksum and is computed again.

use super::cache::hex;
use rimbench_core::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// First word and version of the layout.
const MAGIC: &str = "rimbench-store";
const LAYOUT: u32 = 1;

/// Data reach the disk at least this often, s; against a crash of the program a write is enough.
const SYNC_EVERY_S: f64 = 2.0;

/// One finished run: its rows of the three files, without line ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Record {
    /// Row of `runs.csv`, beginning with the run id.
    pub run: String,
    /// Row of `cost.csv`.
    pub cost: String,
    /// Row of `provenance.csv`.
    pub provenance: String,
}

/// Where a record lies.
#[derive(Debug, Clone, Copy)]
struct Place {
    file: u32,
    length: u32,
    offset: u64,
}

/// The records of one experiment.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    header: String,
    files: Vec<PathBuf>,
    index: HashMap<String, Place>,
    /// Records that were cut short or damaged, and are as good as never written.
    pub damaged: usize,
    log: Mutex<Option<Log>>,
    /// The file read last: records are mostly read in the order in which they were written.
    open: Mutex<Option<(u32, File)>>,
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
        let records = folder.join("records");
        let columns_hash = &hex(&Sha256::digest(columns))[..12];
        let mut store = Store {
            header: format!("{MAGIC} {LAYOUT} {} {columns_hash}", experiment.replace(char::is_whitespace, "_")),
            folder: records.clone(),
            files: Vec::new(),
            index: HashMap::new(),
            damaged: 0,
            log: Mutex::new(None),
            open: Mutex::new(None),
        };
        let Ok(entries) = std::fs::read_dir(&records) else { return Ok(store) };
        let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        files.retain(|path| path.extension().is_some_and(|extension| extension == "log"));
        files.sort();
        for path in files {
            store.read_log(path)?;
        }
        Ok(store)
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

    /// Number of runs stored.
    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// True if no run is stored.
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// Whether a run is stored.
    pub fn contains(&self, run_id: &str) -> bool {
        self.index.contains_key(run_id)
    }

    /// Reads a record.
    ///
    /// # Errors
    /// [`Error::File`] if the file has gone since the store was opened.
    pub fn read(&self, run_id: &str) -> Result<Option<Record>> {
        let Some(place) = self.index.get(run_id) else { return Ok(None) };
        let path = &self.files[place.file as usize];
        let read = || -> std::io::Result<String> {
            let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
            let file = match &mut *open {
                Some((number, file)) if *number == place.file => file,
                other => &mut other.insert((place.file, File::open(path)?)).1,
            };
            file.seek(SeekFrom::Start(place.offset))?;
            let mut line = vec![0; place.length as usize];
            file.read_exact(&mut line)?;
            Ok(String::from_utf8_lossy(&line).into_owned())
        };
        let line = read().map_err(|error| Error::file(path, format!("cannot be read: {error}")))?;
        Ok(parse(&line))
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
        let payload = format!("{}\t{}\t{}", record.run, record.cost, record.provenance);
        let line = format!("{} {payload}\n", checksum(&payload));
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

    fn read_log(&mut self, path: PathBuf) -> Result<()> {
        let failed = |error: std::io::Error| Error::file(&path, format!("cannot be read: {error}"));
        let mut reader = BufReader::with_capacity(1 << 16, File::open(&path).map_err(failed)?);
        let mut line = Vec::new();
        let mut offset = reader.read_until(b'\n', &mut line).map_err(failed)? as u64;
        if line.last() != Some(&b'\n') {
            // Killed while the header was written: nothing was stored.
            return Ok(());
        }
        self.check_header(&path, String::from_utf8_lossy(&line).trim_end())?;
        let file = self.files.len() as u32;
        loop {
            line.clear();
            let length = reader.read_until(b'\n', &mut line).map_err(failed)?;
            if length == 0 {
                break;
            }
            match std::str::from_utf8(&line).ok().and_then(|line| line.strip_suffix('\n')).and_then(run_id_of) {
                Some(run_id) => {
                    let place = Place { file, length: length as u32 - 1, offset };
                    self.index.entry(run_id.to_owned()).or_insert(place);
                }
                None => self.damaged += 1,
            }
            offset += length as u64;
        }
        self.files.push(path);
        Ok(())
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

fn checksum(payload: &str) -> String {
    hex(&Sha256::digest(payload))[..16].to_owned()
}

/// The run id of a line that is whole.
fn run_id_of(line: &str) -> Option<&str> {
    let (sum, payload) = line.split_once(' ')?;
    (checksum(payload) == sum).then(|| payload.split(',').next()).flatten()
}

fn parse(line: &str) -> Option<Record> {
    let (sum, payload) = line.split_once(' ')?;
    let mut parts = payload.split('\t');
    let record =
        Record { run: parts.next()?.to_owned(), cost: parts.next()?.to_owned(), provenance: parts.next()?.to_owned() };
    (checksum(payload) == sum && parts.next().is_none()).then_some(record)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(id: &str) -> Record {
        Record { run: format!("{id},wedge-box,1.5"), cost: format!("{id},0.01"), provenance: format!("{id},abc") }
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
