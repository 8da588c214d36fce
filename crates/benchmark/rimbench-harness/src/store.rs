//! The store of an experiment: one row per run, appended as runs finish, safe against being killed at any instant.
//!
//! ```text
//! <folder>/records/<time>-<process>.csv
//!     # rimbench-store 5 <checksum of what follows and of the next line> <hash of the reference> <experiment file>
//!     run_id,…,outcome,…,wall_s,…,git_revision,…,checksum
//!     0123456789abcdef,…,completed,…,0.01,…,abc,…,<checksum of the line before it>
//!     …
//! ```
//! Each process appends to a table of its own, so that shards can be run at once; a row is one write and is known by
//! its run id. The first line says whose the folder is. Tables are read by the names of their columns: a metric that
//! came later is an empty cell. A row that is cut short or damaged fails its checksum, is named by its place and
//! computed again, as are all below a damaged head. Of several rows of one run and [what was asked of it](Asked) the
//! one that says most stands, whatever their order: one that came to an end before one that took too long, of those the
//! one that was given most time, and else the newest.
//!
//! All rows are held in memory, which an experiment has no more runs than there is room for
//! ([`MOST_RUNS`](super::grid::MOST_RUNS)).

use super::run_row::{Asked, RunRow, line_of};
use rayon::prelude::*;
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums::sha256;
use rimbench_runs::names_of;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// First words and version of the layout; before 5 there was no `#`.
const MAGIC: &str = "rimbench-store";
const LAYOUT: &str = "5";

/// No first line is longer, bytes.
const LONGEST_HEAD: u64 = 1 << 14;

/// Data reach the disk at least this often, s; against a crash of the program a write is enough.
const SYNC_EVERY_S: f64 = 2.0;

/// The rows of one experiment.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    /// The experiment file.
    file: String,
    /// Hash of what all runs are held against.
    reference: String,
    /// What was stored when it was opened, by what was asked and by run id.
    rows: BTreeMap<Asked, HashMap<Arc<str>, RunRow>>,
    /// The tables that were read, with their lengths in bytes.
    read: Vec<(PathBuf, u64)>,
    /// The experiment file that the newest table is of.
    pub(super) last_file: Option<PathBuf>,
    /// Rows that were cut short or damaged, and are as good as never written.
    pub damaged: Vec<Damaged>,
    log: Mutex<Option<Log>>,
}

/// The place of a row, or of all rows below a head, that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damaged {
    /// The table.
    pub file: PathBuf,
    /// Line in it, from 1.
    pub line: usize,
}

impl fmt::Display for Damaged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, line {}", self.file.display(), self.line)
    }
}

#[derive(Debug)]
struct Log {
    file: File,
    path: PathBuf,
    synced: Instant,
}

/// What stands in one table.
#[derive(Default)]
struct Contents {
    rows: Vec<RunRow>,
    damaged: Vec<Damaged>,
    /// The experiment file that it is of.
    file: Option<PathBuf>,
}

impl Store {
    /// Opens the store of the experiment in `file` in its results folder and reads what is there. `reference` says what
    /// all runs are held against; rows held against something else are another store.
    ///
    /// # Errors
    /// [`Error::File`] if the store belongs to another experiment, or to another version of rimbench.
    pub fn open(folder: &Path, file: &Path, reference: &str) -> Result<Self> {
        let records = folder.join("records");
        // An experiment that is part of the program has no file.
        let file = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        let mut store = Store {
            folder: records.clone(),
            file: file.to_string_lossy().replace(char::is_control, " "),
            reference: sha256(reference)[..12].to_owned(),
            rows: BTreeMap::new(),
            read: tables_in(&records),
            last_file: None,
            damaged: Vec::new(),
            log: Mutex::new(None),
        };
        let read: Vec<Result<Contents>> = store.read.par_iter().map(|(path, _)| store.contents(path)).collect();
        for contents in read {
            let Contents { rows, damaged, file } = contents?;
            store.damaged.extend(damaged);
            store.last_file = file.or(store.last_file);
            for row in rows {
                let known = store.rows.entry(row.asked).or_default();
                if known.get(&row.run_id).is_none_or(|known| row.replaces(known)) {
                    known.insert(row.run_id.clone(), row);
                }
            }
        }
        Ok(store)
    }

    /// Whether it holds all that is stored by now.
    pub(super) fn is_up_to_date(&self) -> bool {
        tables_in(&self.folder) == self.read
    }

    /// Finds the name of the experiment whose rows a results folder holds; none if it holds no row.
    pub fn experiment_in(folder: &Path) -> Option<String> {
        let name_in = |path: PathBuf| {
            let mut line = String::new();
            BufReader::new(File::open(path).ok()?).take(LONGEST_HEAD).read_line(&mut line).ok()?;
            Some(name_of(Path::new(Head::of(line.strip_suffix('\n')?)?.file)))
        };
        tables_in(&folder.join("records")).into_iter().rev().find_map(|(path, _)| name_in(path))
    }

    /// Removes all rows of a results folder.
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

    /// Lists the runs that were stored when the store was opened.
    pub fn run_ids(&self) -> HashSet<&str> {
        self.rows.values().flat_map(HashMap::keys).map(|id| &**id).collect()
    }

    /// Returns the rows of a run that were stored when the store was opened, one for each thing that was asked of it.
    pub fn rows_of(&self, run_id: &str) -> impl Iterator<Item = &RunRow> {
        self.rows.values().filter_map(move |rows| rows.get(run_id))
    }

    /// Returns a row of a run, if one was stored when the store was opened.
    pub fn get(&self, run_id: &str) -> Option<&RunRow> {
        self.rows_of(run_id).next()
    }

    /// Appends a row to this process's table with one write; what opens the store next holds it. Safe to call from
    /// several threads.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written, for example on a full disk; what was stored before stays.
    pub fn append(&self, mut row: RunRow) -> Result<()> {
        let line = sealed(line_of(|each| row.columns(each)));
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        let log = match &mut *log {
            Some(log) => log,
            empty => empty.insert(self.create_log()?),
        };
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

    /// A table that is this process's alone.
    fn create_log(&self) -> Result<Log> {
        let failed = |error: std::io::Error| Error::file(&self.folder, format!("cannot be written: {error}"));
        std::fs::create_dir_all(&self.folder).map_err(failed)?;
        let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let path = self.folder.join(format!("{:020}-{}.csv", since_epoch.as_nanos(), std::process::id()));
        let mut file = OpenOptions::new().append(true).create_new(true).open(&path).map_err(failed)?;
        let own = format!("{} {}\n{}", self.reference, self.file, columns().join(","));
        let head = format!("# {MAGIC} {LAYOUT} {} {own},checksum\n", checksum(&own));
        file.write_all(head.as_bytes()).map_err(failed)?;
        Ok(Log { file, path, synced: Instant::now() })
    }

    /// Reads a table.
    fn contents(&self, path: &Path) -> Result<Contents> {
        let failed = |error: std::io::Error| Error::file(path, format!("cannot be read: {error}"));
        let mut reader = BufReader::with_capacity(1 << 16, File::open(path).map_err(failed)?);
        let mut contents = Contents::default();
        let mut head = [Vec::new(), Vec::new()];
        for line in &mut head {
            reader.read_until(b'\n', line).map_err(failed)?;
        }
        let whole = |line: &Vec<u8>| line.last() == Some(&b'\n');
        if !whole(&head[0]) {
            // Killed while the head was written: nothing was stored.
            return Ok(contents);
        }
        let [first, names] = head.each_ref().map(|line| String::from_utf8_lossy(line));
        let first = self.checked_head(path, first.trim_end_matches('\n'))?;
        if !whole(&head[1]) {
            return Ok(contents);
        }
        let places = first.places(names.trim_end_matches('\n'));
        contents.file = places.is_some().then(|| PathBuf::from(first.file));
        // What a row has in common with the one before it is held once.
        let (mut line, mut row) = (Vec::new(), RunRow::blank(""));
        for number in 3.. {
            line.clear();
            if reader.read_until(b'\n', &mut line).map_err(failed)? == 0 {
                break;
            }
            let read = std::str::from_utf8(&line).ok().zip(places.as_ref());
            match read.and_then(|(line, places)| read_row(&mut row, line, places)) {
                Some(()) => contents.rows.push(row.clone()),
                None => contents.damaged.push(Damaged { file: path.to_owned(), line: number }),
            }
        }
        Ok(contents)
    }

    /// The first line of a table of this store.
    fn checked_head<'a>(&self, path: &Path, first: &'a str) -> Result<Head<'a>> {
        let message = match Head::of(first) {
            Some(head) => {
                let [experiment, own] = [head.file, &self.file].map(|file| name_of(Path::new(file)));
                if experiment != own {
                    format!("belongs to experiment `{experiment}`, not to `{own}`: give each experiment its own folder")
                } else if head.reference != self.reference {
                    "was held against another reference".to_owned()
                } else {
                    return Ok(head);
                }
            }
            None => match first.trim_start_matches("# ").split(' ').collect::<Vec<_>>()[..] {
                [MAGIC, layout, ..] => format!("was written with store layout {layout}, this is layout {LAYOUT}"),
                _ => format!("is no table of runs (it begins `{}`)", first.chars().take(40).collect::<String>()),
            },
        };
        let message =
            format!("{message}; use another folder, or `rimbench run {} --fresh` to make its runs again", self.file);
        Err(Error::file(path, message))
    }
}

/// The first line of a table.
struct Head<'a> {
    sum: &'a str,
    /// What the sum is of, with the second line.
    own: &'a str,
    reference: &'a str,
    file: &'a str,
}

impl<'a> Head<'a> {
    /// Takes it apart; none of what is no such line, or of another layout.
    fn of(line: &'a str) -> Option<Self> {
        let words = line.strip_prefix("# ")?.strip_prefix(MAGIC)?.strip_prefix(' ')?;
        let (sum, own) = words.strip_prefix(LAYOUT)?.strip_prefix(' ')?.split_once(' ')?;
        let (reference, file) = own.split_once(' ')?;
        Some(Head { sum, own, reference, file })
    }

    /// Where the columns of now stand in the table; none if one of its first two lines is damaged.
    fn places(&self, names: &str) -> Option<Places> {
        let names = names.strip_suffix(",checksum")?;
        if checksum(&format!("{}\n{names}", self.own)) != self.sum {
            return None;
        }
        let written: Vec<&str> = names.split(',').collect();
        let place = |name: &str| written.iter().position(|own| *own == name);
        Some(Places { written: written.len(), of: columns().into_iter().map(place).collect() })
    }
}

/// How many cells were written, and where each column of now stands among them.
struct Places {
    written: usize,
    of: Vec<Option<usize>>,
}

/// Reads the row of a line that is whole, every column of it; none of one that is not.
fn read_row(row: &mut RunRow, line: &str, places: &Places) -> Option<()> {
    let (line, sum) = line.strip_suffix('\n')?.rsplit_once(',')?;
    if checksum(line) != sum {
        return None;
    }
    let mut fill = |cells: &[&str]| {
        let (mut places_left, mut whole) = (places.of.iter(), cells.len() == places.written);
        row.columns(&mut |_, cell| {
            let place = places_left.next().copied().flatten();
            whole = whole && cell.read(place.map_or("", |place| cells[place]));
        });
        whole.then_some(())
    };
    if !line.contains('"') {
        return fill(&line.split(',').collect::<Vec<_>>());
    }
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
    fill(&reader.records().next()?.ok()?.iter().collect::<Vec<_>>())
}

/// Names of the columns of a table, but for the checksum.
fn columns() -> Vec<&'static str> {
    names_of(|each| RunRow::blank("").columns(each))
}

/// The name of the experiment in a file.
fn name_of(file: &Path) -> String {
    file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

/// A line with its checksum and its end.
fn sealed(line: String) -> String {
    let sum = checksum(&line);
    line + "," + &sum + "\n"
}

/// The first half of the digits of the SHA-256.
fn checksum(text: &str) -> String {
    sha256(text)[..16].to_owned()
}

/// The tables of a store with their lengths, in the order in which they were begun; those of an older layout are logs.
fn tables_in(records: &Path) -> Vec<(PathBuf, u64)> {
    let entries = std::fs::read_dir(records).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let tables = entries.filter(|path| path.extension().is_some_and(|own| own == "csv" || own == "log"));
    let length = |path: &PathBuf| path.metadata().ok().filter(|found| found.is_file()).map(|found| found.len());
    let mut tables: Vec<_> =
        tables.filter_map(|path| Some((length(&path)?, path))).map(|(n, path)| (path, n)).collect();
    tables.sort();
    tables
}
