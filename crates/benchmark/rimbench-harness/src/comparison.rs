//! How the schemes of an experiment compare: one row per case and scheme, failures counted.

use super::build_info::BuildInfo;
use super::cache::Cache;
use super::execution::run_job;
use super::experiment::Experiment;
use super::job::Job;
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::runs::Finding;
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::Result;
use rimbench_results::run_table::RunTable;
use rimbench_results::selection::Runs;
use std::fmt;
use std::path::Path;

/// The metric that is compared.
const METRIC: &str = "force_error_rms_of_peak";

/// What became of one scheme row in one case, over macro steps and phases.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonRow {
    /// Case by name.
    pub case: String,
    /// Its parameters that the experiment sets, as in the column `set` of `runs.csv`.
    pub set: String,
    /// Label of the scheme row.
    pub label: String,
    /// Runs planned, those skipped included.
    pub runs: usize,
    /// Runs that came to their end within bounds.
    pub completed: usize,
    /// Median of the rms force error over the reference's peak, over the completed runs; none without such a run.
    pub force_error: Option<f64>,
}

/// The rows in the order of the plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// One per case, set of parameters and label.
    pub rows: Vec<ComparisonRow>,
}

/// Runs what is missing of an experiment into its folder below `results`, and compares its schemes; `build` is the
/// program's own.
///
/// References are kept in `results` too: of a case under development none may survive in the user's cache.
///
/// # Errors
/// Bad input; a disk that is full. A run that fails is counted.
pub fn compare(
    experiment: &Experiment,
    catalogue: &Catalogue,
    results: &Path,
    quick: bool,
    build: &BuildInfo,
) -> Result<Comparison> {
    let (folder, cache) = (experiment.results_folder(results), Cache::in_folder(results.join("references")));
    let job = Job { quick, ..Job::new(experiment, catalogue, &folder, &cache, build) };
    run_job(job, &|_| {}, StopFlag::never())?;
    Comparison::read(&folder.join("runs.csv"))
}

impl Comparison {
    fn read(runs: &Path) -> Result<Self> {
        let (table, metric) = (RunTable::read(runs)?, Finding::named(METRIC)?);
        table.check(metric)?;
        let row = |(([case, set], label), runs): (([&str; 2], &str), Runs<'_>)| {
            let ([case, set, label], completed) = ([case, set, label].map(str::to_owned), runs.completed());
            ComparisonRow {
                case,
                set,
                label,
                runs: runs.rows().len(),
                completed: completed.rows().len(),
                force_error: completed.pool(|row| runs.value(row, metric)).median(),
            }
        };
        let groups = Runs::of(&table).by_key(|run| (run.problem(), &*run.label));
        Ok(Comparison { rows: groups.into_iter().map(row).collect() })
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<20} {:<40} {:>9}  {METRIC}, median of completed", "case", "scheme", "completed")?;
        for row in &self.rows {
            let completed = format!("{}/{}", row.completed, row.runs);
            let error = row.force_error.map_or("–".to_owned(), |error| format!("{error:.3e}"));
            let set = if row.set.is_empty() { String::new() } else { format!("  ({})", row.set) };
            writeln!(f, "{:<20} {:<40} {completed:>9}  {error}{set}", row.case, row.label)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_count_as_runs_and_never_as_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        let rows = "case,set,label,macro_step_s,outcome,force_error_rms_of_peak\na,,x,1,completed,0.1\na,,x,1,diverged,1e9\n\
                    a,,x,1,completed,0.3\na,,y,1,skipped,\nb,,x,1,completed,\na,m=2,x,1,completed,5.0\n";
        std::fs::write(&path, rows).unwrap();
        let found = Comparison::read(&path).unwrap().rows;
        let facts: Vec<_> =
            found.iter().map(|row| (row.label.as_str(), row.runs, row.completed, row.force_error)).collect();
        assert_eq!(facts, [("x", 3, 2, Some(0.2)), ("y", 1, 0, None), ("x", 1, 1, None), ("x", 1, 1, Some(5.0))]);
    }
}
