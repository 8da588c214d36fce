//! The cost of runs: columns of `cost.csv` joined to the rows of `runs.csv` by run id, and exact counters.

use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::{ResultsTable, read_table};
use rimbench_statistics::{Run, Runs};
use std::collections::HashMap;
use std::path::Path;

/// `cost.csv` in the order of `runs.csv`.
pub struct Cost {
    table: ResultsTable,
    /// Row of cost of each run.
    rows: Vec<usize>,
}

impl Cost {
    /// Reads `cost.csv` of an experiment's folder.
    ///
    /// # Errors
    /// [`Error::File`] if it is not there or lacks a run.
    pub fn read(folder: &Path, runs: &Runs<'_>) -> Result<Self> {
        let path = folder.join("cost.csv");
        let table = read_table(&path)?;
        let own = table.column("run_id")?;
        let of_id: HashMap<&str, usize> = (0..table.len()).map(|row| (table.text(row, own), row)).collect();
        let lacks = |id: &str| Error::file(&path, format!("has no row for run {id}"));
        let row_of = |run: &Run<'_>| of_id.get(run.id).copied().ok_or_else(|| lacks(run.id));
        let rows = runs.iter().map(row_of).collect::<Result<_>>()?;
        Ok(Cost { table, rows })
    }

    /// A column of `cost.csv`, one value per run.
    ///
    /// # Errors
    /// [`Error::File`] naming the file and its columns.
    pub fn column(&self, name: &str) -> Result<Vec<f64>> {
        let column = self.table.column(name)?;
        Ok(self.rows.iter().map(|&row| self.table.number(row, column)).collect())
    }

    /// A column of `cost.csv`, or the sum of counters of `runs.csv` joined by `+`; one value per run.
    ///
    /// # Errors
    /// [`Error::File`] naming the file and its columns.
    pub fn of_runs(&self, cost: &str, runs: &ResultsTable) -> Result<Vec<f64>> {
        if let Ok(column) = self.column(cost) {
            return Ok(column);
        }
        let counters = cost.split('+').map(|name| runs.column(name.trim())).collect::<Result<Vec<usize>>>()?;
        let total = |row: usize| counters.iter().map(|&counter| runs.number(row, counter)).sum();
        Ok((0..runs.len()).map(total).collect())
    }
}
