//! A CSV file of results, read back by column name.

use crate::input::check_regular;
use rimbench_core::error::{Error, Result};
use std::path::{Path, PathBuf};

/// Names the column of `runs.csv` that says how far the reference of an error may be off; none for what is no error of force or position.
/// An error no larger than that says only that it is small.
pub fn uncertainty_of(metric: &str) -> Option<&'static str> {
    match metric {
        "force_error_rms_n" | "force_error_inside_rms_n" | "force_error_l1_n" | "force_error_max_n" => {
            Some("reference_force_uncertainty_n")
        }
        "position_error_rms_m" | "position_error_inside_rms_m" | "position_error_end_m" => {
            Some("reference_position_uncertainty_m")
        }
        _ => None,
    }
}

/// Rows of text under named columns.
#[derive(Debug, Clone)]
pub struct ResultsTable {
    path: PathBuf,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl ResultsTable {
    /// Reads a CSV file with a header.
    ///
    /// # Errors
    /// [`Error::File`] if it is missing or not rectangular.
    pub fn read(path: &Path) -> Result<Self> {
        check_regular(path)?;
        let wrong = |error: csv::Error| Error::file(path, error);
        let mut reader = csv::Reader::from_path(path).map_err(wrong)?;
        let header = reader.headers().map_err(wrong)?.iter().map(str::to_owned).collect();
        let rows: csv::Result<Vec<Vec<String>>> =
            reader.records().map(|record| Ok(record?.iter().map(str::to_owned).collect())).collect();
        Ok(ResultsTable { path: path.to_owned(), header, rows: rows.map_err(wrong)? })
    }

    /// Says where it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Takes some of the rows, in the order asked for.
    pub fn with_rows(&self, rows: &[usize]) -> Self {
        let rows = rows.iter().map(|&row| self.rows[row].clone()).collect();
        ResultsTable { path: self.path.clone(), header: self.header.clone(), rows }
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

    /// Returns the position of the last column of a name: counters stand behind the settings and may share a name with
    /// one.
    ///
    /// # Errors
    /// [`Error::File`] naming the file and its columns.
    pub fn last_column(&self, name: &str) -> Result<usize> {
        self.header.iter().rposition(|column| column == name).map_or_else(|| self.column(name), Ok)
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
