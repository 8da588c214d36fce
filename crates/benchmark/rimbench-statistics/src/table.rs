//! A table of results, read by column name.

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
    /// Makes a table of rows that are as long as the header; `path` is what errors name.
    pub fn of(path: &Path, header: Vec<String>, rows: Vec<Vec<String>>) -> Self {
        ResultsTable { path: path.to_owned(), header, rows }
    }

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

    /// Tells whether a column has one of these names.
    pub fn is_named(&self, column: usize, names: &[&str]) -> bool {
        names.contains(&self.header[column].as_str())
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

    /// Pairs of two columns.
    ///
    /// # Errors
    /// [`Error::File`] for a column that is not there.
    pub fn pairs(&self, x: &str, y: &str) -> Result<Vec<(f64, f64)>> {
        let (x, y) = (self.column(x)?, self.column(y)?);
        Ok((0..self.len()).map(|row| (self.number(row, x), self.number(row, y))).collect())
    }
}
