//! How the schemes of an experiment compare: one row per case, scheme and macro step, failures counted.

use rimbench_cases::runs::Finding;
use rimbench_core::error::Result;
use rimbench_results::run_table::RunTable;
use rimbench_results::selection::Runs;
use std::collections::BTreeMap;

/// Metrics whose medians are compared, with their headings and units; an error without a unit is a share of the peak.
pub const MEDIANS: [(&str, &str, &str); 3] = [
    ("force_error_rms_of_peak", "force", "-"),
    ("position_error_rms_m", "position", "m"),
    ("interface_residual_j", "energy", "J"),
];

/// What became of one scheme row at one macro step of one case, over phases and tolerances.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonRow {
    /// Case by name, and its parameters that the experiment sets, as in the column `set` of `runs.csv`.
    pub problem: [String; 2],
    /// Label of the scheme row.
    pub label: String,
    /// H, s.
    pub macro_step_s: f64,
    /// Runs planned, those skipped included.
    pub runs: usize,
    /// Runs that came to their end within bounds.
    pub completed: usize,
    /// Those that did not, by outcome.
    pub failures: BTreeMap<&'static str, usize>,
    /// Medians of [`MEDIANS`] over the completed runs; none without such a run.
    pub medians: [Option<f64>; 3],
}

/// The rows in the order of the plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// One per case, set of parameters, label and macro step: survivors at other macro steps are no rivals.
    pub rows: Vec<ComparisonRow>,
}

impl Comparison {
    /// Compares the rows of a table.
    ///
    /// # Errors
    /// A column that is not there.
    pub fn of(table: &RunTable) -> Result<Self> {
        let metrics = MEDIANS.iter().map(|(name, ..)| Finding::named(name)).collect::<Result<Vec<_>>>()?;
        metrics.iter().try_for_each(|metric| table.check(*metric))?;
        let row = |(([case, set], label, macro_step), runs): (([&str; 2], &str, u64), Runs<'_>)| {
            let (completed, mut failures) = (runs.completed(), BTreeMap::new());
            let failed = runs.rows().iter().filter(|&&row| !runs.is_completed(row));
            failed.for_each(|&row| *failures.entry(runs.run(row).found.outcome.name()).or_default() += 1);
            ComparisonRow {
                problem: [case, set].map(str::to_owned),
                label: label.to_owned(),
                macro_step_s: f64::from_bits(macro_step),
                runs: runs.rows().len(),
                completed: completed.rows().len(),
                failures,
                medians: std::array::from_fn(|of| completed.pool(|row| runs.value(row, metrics[of])).median()),
            }
        };
        let groups = Runs::of(table).by_key(|run| (run.problem(), &*run.label, run.macro_step_s.to_bits()));
        Ok(Comparison { rows: groups.into_iter().map(row).collect() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_count_as_runs_and_never_as_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        let header =
            "case,set,label,macro_step_s,outcome,force_error_rms_of_peak,position_error_rms_m,interface_residual_j";
        let rows = "a,,x,1,completed,0.1,,\na,,x,1,diverged,1e9,,\na,,x,1,completed,0.3,,\na,,x,2,diverged,1e9,,\n\
                    a,,y,1,skipped,,,\nb,,x,1,completed,,,\na,m=2,x,1,completed,5.0,,\n";
        let rows = format!("{header}\n{rows}");
        std::fs::write(&path, rows).unwrap();
        let found = Comparison::of(&RunTable::read(&path).unwrap()).unwrap().rows;
        let facts: Vec<_> =
            found.iter().map(|row| (row.label.as_str(), row.runs, row.completed, row.medians[0])).collect();
        // What survives at the short step alone is no rival of what completes at both.
        let of_x = [("x", 3, 2, Some(0.2)), ("x", 1, 0, None)];
        assert_eq!(facts[..2], of_x);
        assert_eq!(facts[2..], [("y", 1, 0, None), ("x", 1, 1, None), ("x", 1, 1, Some(5.0))]);
        assert_eq!(found[0].failures, [("diverged", 1)].into());
    }
}
