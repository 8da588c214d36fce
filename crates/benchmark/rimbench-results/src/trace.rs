//! The one writer of traces: those of experiments, of single runs and of FMUs have the same columns and digits.

use super::atomic_file::{check_writable_file, write_atomically};
use rimbench_core::cosim::Trajectory;
use rimbench_core::error::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// What every trace begins with.
const BEGINNING: &[u8] = b"time_s";

/// Checks, before anything is computed, that a trace can be written here: where there is nothing, or a trace, or no
/// regular file.
///
/// # Errors
/// [`Error::File`] if it cannot, or if another file would be lost.
pub fn check_place_for_trace(path: &Path) -> Result<()> {
    check_writable_file(path)?;
    if !path.is_file() {
        return Ok(());
    }
    let mut beginning = Vec::new();
    let read = File::open(path).and_then(|file| file.take(BEGINNING.len() as u64).read_to_end(&mut beginning));
    if read.is_ok() && (beginning.is_empty() || beginning == BEGINNING) {
        return Ok(());
    }
    Err(Error::file(path, "is no trace, and would be lost: name another file, or remove it"))
}

/// Writes a trajectory as CSV, thinned to one row per `every_s` seconds if that is given; first and last rows always
/// stand.
///
/// # Errors
/// [`Error::File`] naming the file.
pub fn write_trace(path: &Path, trajectory: &Trajectory, every_s: Option<f64>) -> Result<()> {
    write_atomically(path, |file| {
        let mut table = csv::Writer::from_writer(file);
        table.write_record(trajectory.columns())?;
        let mut next = 0_u64;
        let last = trajectory.len().saturating_sub(1);
        for (index, row) in trajectory.rows().enumerate() {
            if let Some(every) = every_s {
                // Slack for times that are multiples of `every` up to round-off.
                if row[0] + 1e-9 * every < next as f64 * every && index != last {
                    continue;
                }
                next = (row[0] / every + 1e-9).floor() as u64 + 1;
            }
            // Shortest text that reads back to the same bits.
            table.write_record(row.iter().map(|value| format!("{value:?}")))?;
        }
        table.flush()
    })
}
