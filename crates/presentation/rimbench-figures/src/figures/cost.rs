//! The cost of runs: a column of `cost.csv` joined to the runs by their ids, or exact counters.

use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::read_table;
use rimbench_results::run_table::{Run, RunTable};
use rimbench_runs::{Costs, Finding, names_of};
use serde::Deserialize;
use std::collections::HashMap;
use std::path::Path;

/// What a figure takes for the cost of a run.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub enum Cost {
    /// A column of `cost.csv`.
    Measured(String),
    /// The sum of counters, joined by `+` in the file.
    Counted(Vec<Finding>),
}

impl TryFrom<String> for Cost {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let measured = names_of(|each| Costs::default().columns(each));
        if measured.contains(&text.as_str()) {
            return Ok(Cost::Measured(text));
        }
        let valid = || measured.iter().copied().chain(Finding::counters().map(Finding::name));
        let counter = |name: &str| {
            let found = Finding::counters().find(|counter| counter.name() == name.trim());
            found.ok_or_else(|| Error::unknown("cost", name.trim(), valid()).to_string())
        };
        text.split('+').map(counter).collect::<Result<_, _>>().map(Cost::Counted)
    }
}

impl Cost {
    /// What it is called in the file.
    pub fn name(&self) -> String {
        match self {
            Cost::Measured(name) => name.clone(),
            Cost::Counted(counters) => counters.iter().map(|counter| counter.name()).collect::<Vec<_>>().join(" + "),
        }
    }

    /// One value per run of a table, with `cost.csv` beside it in an experiment's folder.
    ///
    /// # Errors
    /// [`Error::File`] for a file, a column or a run that is not there.
    pub fn of_runs(&self, folder: &Path, table: &RunTable) -> Result<Vec<f64>> {
        match self {
            Cost::Measured(name) => {
                let path = folder.join("cost.csv");
                let costs = read_table(&path)?;
                let (own, column) = (costs.column("run_id")?, costs.column(name)?);
                let of_id: HashMap<&str, usize> = (0..costs.len()).map(|row| (costs.text(row, own), row)).collect();
                let lacks = |run: &Run| Error::file(&path, format!("has no row for run {}", run.id));
                let cost = |run: &Run| of_id.get(&*run.id).map(|&row| costs.number(row, column));
                table.runs().iter().map(|run| cost(run).ok_or_else(|| lacks(run))).collect()
            }
            Cost::Counted(counters) => {
                counters.iter().try_for_each(|counter| table.check(*counter))?;
                let total = |run: &Run| counters.iter().map(|counter| run.found.value(*counter)).sum();
                Ok(table.runs().iter().map(total).collect())
            }
        }
    }
}
