//! Reading records, one or many.

use super::Store;
use super::index::Place;
use super::record::Line;
use rimbench_core::error::{Error, Result};
use std::fs::File;
use std::io::{BufReader, Read};

/// A log that is read from.
#[derive(Debug, Default)]
pub(super) struct Reading {
    /// Number of the log, the log, and how far it has been read.
    log: Option<(u32, BufReader<File>, u64)>,
}

impl Reading {
    /// Appends the bytes of a record to some.
    pub(super) fn read(&mut self, store: &Store, place: &Place, bytes: &mut Vec<u8>) -> Result<()> {
        let path = &store.files[place.file as usize];
        let from = bytes.len();
        let mut read = |log: &mut Option<(u32, BufReader<File>, u64)>| -> std::io::Result<()> {
            let (_, file, at) = match log {
                Some(log) if log.0 == place.file => log,
                other => other.insert((place.file, BufReader::with_capacity(1 << 16, File::open(path)?), 0)),
            };
            // What lies near is in the buffer already.
            file.seek_relative(place.offset as i64 - *at as i64)?;
            bytes.resize(from + place.length as usize, 0);
            *at = place.offset;
            file.read_exact(&mut bytes[from..])?;
            *at += u64::from(place.length);
            Ok(())
        };
        read(&mut self.log).map_err(|error| {
            // Nobody knows where it stands now.
            self.log = None;
            Error::file(path, format!("cannot be read: {error}"))
        })
    }
}

/// The records of some runs, in the order in which they were asked for.
#[derive(Debug, Default)]
pub(crate) struct Lines {
    bytes: Vec<u8>,
    /// Where in the bytes; none of a run that is not stored.
    spans: Vec<Option<(usize, usize)>>,
}

impl Lines {
    /// The record of the run that was asked for at this place; none if it is not stored, or has been damaged since.
    pub(crate) fn get(&self, nth: usize) -> Option<Line<'_>> {
        let (from, to) = (*self.spans.get(nth)?)?;
        Line::parse(std::str::from_utf8(&self.bytes[from..to]).ok()?)
    }
}

impl Store {
    /// Reads the records of some runs, log by log: shards that take every n-th run lie in as many logs, and no log is opened more than
    /// once for this.
    ///
    /// # Errors
    /// [`Error::File`] if a log has gone since the store was opened.
    pub(crate) fn read_many<'a>(&self, run_ids: impl Iterator<Item = &'a str>) -> Result<Lines> {
        let places: Vec<Option<Place>> = run_ids.map(|id| self.index.get(id).copied()).collect();
        let mut order: Vec<(u32, u64, usize)> = places
            .iter()
            .enumerate()
            .filter_map(|(nth, place)| place.map(|place| (place.file, place.offset, nth)))
            .collect();
        order.sort_unstable();
        let bytes = places.iter().flatten().map(|place| place.length as usize).sum();
        let mut lines = Lines { bytes: Vec::with_capacity(bytes), spans: vec![None; places.len()] };
        let mut reading = Reading::default();
        for (_, _, nth) in order {
            let Some(place) = &places[nth] else { continue };
            let from = lines.bytes.len();
            reading.read(self, place, &mut lines.bytes)?;
            lines.spans[nth] = Some((from, lines.bytes.len()));
        }
        Ok(lines)
    }
}
