//! Reads CSV files of results.

use crate::input::check_regular;
use rimbench_core::error::{Error, Result};
pub use rimbench_statistics::ResultsTable;
use std::path::Path;

/// Reads a CSV file with a header.
///
/// # Errors
/// [`Error::File`] if it is missing or not rectangular.
pub fn read_table(path: &Path) -> Result<ResultsTable> {
    check_regular(path)?;
    let wrong = |error: csv::Error| Error::file(path, error);
    let mut reader = csv::Reader::from_path(path).map_err(wrong)?;
    let header = reader.headers().map_err(wrong)?.iter().map(str::to_owned).collect();
    let rows = reader.records().map(|record| Ok(record?.iter().map(str::to_owned).collect()));
    Ok(ResultsTable::of(path, header, rows.collect::<csv::Result<_>>().map_err(wrong)?))
}
