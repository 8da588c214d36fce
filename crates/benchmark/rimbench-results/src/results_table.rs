//! CSV files of results that are read by column name: traces, parameters, summaries for pages.

use crate::input::check_regular;
use rimbench_core::error::{Error, Result};
use std::path::{Path, PathBuf};

/// Rows of text under named columns.
#[derive(Debug, Clone)]
pub struct ResultsTable {
    path: PathBuf,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl ResultsTable {
    /// Says where it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Tells whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Returns the names of the columns.
    pub fn names(&self) -> &[String] {
        &self.header
    }

    /// Returns the position of a column.
    ///
    /// # Errors
    /// [`Error::File`] naming the file and its columns.
    pub fn column(&self, name: &str) -> Result<usize> {
        let found = self.header.iter().position(|column| column == name);
        found.ok_or_else(|| {
            Error::file(&self.path, Error::unknown("column", name, self.header.iter().map(String::as_str)))
        })
    }

    /// Returns the text of one cell.
    pub fn text(&self, row: usize, column: usize) -> &str {
        &self.rows[row][column]
    }

    /// Returns the number in one cell; NaN where there is none.
    pub fn number(&self, row: usize, column: usize) -> f64 {
        self.rows[row][column].parse().unwrap_or(f64::NAN)
    }

    /// Returns the rows whose cell in `column` is `text`.
    pub fn rows_where(&self, column: usize, text: &str) -> Vec<usize> {
        (0..self.len()).filter(|&row| self.text(row, column) == text).collect()
    }

    /// Appends the rows of a table with the same columns.
    ///
    /// # Errors
    /// [`Error::File`] naming the other table if its columns are others.
    pub fn append(&mut self, other: Self) -> Result<()> {
        if other.header != self.header {
            let message = format!("has other columns than {}: make it anew", self.path.display());
            return Err(Error::file(other.path, message));
        }
        self.rows.extend(other.rows);
        Ok(())
    }

    /// Pairs of two columns.
    ///
    /// # Errors
    /// [`Error::File`] for a column that is not there.
    pub fn pairs(&self, x: &str, y: &str) -> Result<Vec<(f64, f64)>> {
        let (x, y) = (self.column(x)?, self.column(y)?);
        Ok((0..self.len()).map(|row| (self.number(row, x), self.number(row, y))).collect())
    }
}

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
    Ok(ResultsTable { path: path.to_owned(), header, rows: rows.collect::<csv::Result<_>>().map_err(wrong)? })
}
