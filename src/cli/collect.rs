//! `rimbench run --collect`: merges shards.

use super::{claims_list, damaged_lines, print, warn_of_cache};
use rimbench::BUILD;
use rimbench::catalogue::Catalogue;
use rimbench::error::Error;
use rimbench::harness::{Cache, Experiment, Job, check_fresh_claims, collect_shards};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Merges the results of other folders into one. Exit code 1 if runs are missing: what there is has been merged.
pub(super) fn collect(
    experiment: &Experiment,
    catalogue: &Catalogue,
    folder: &Path,
    others: &[PathBuf],
) -> anyhow::Result<ExitCode> {
    for other in others {
        if !Experiment::read_from_results(other)?.is_same_as(experiment) {
            let message = format!("holds results of another experiment than {}", experiment.path().display());
            return Err(Error::file(other, message).into());
        }
    }
    let cache = Cache::of_user();
    let job = Job::new(experiment, catalogue, folder, &cache, &BUILD);
    let others: Vec<&Path> = others.iter().map(PathBuf::as_path).collect();
    let (summary, first_missing) = collect_shards(job, &others)?;
    warn_of_cache(&cache);
    print(&format!(
        "{} of {} runs in {}: {} taken over, {} damaged rows left out",
        summary.planned - summary.missing,
        summary.planned,
        folder.display(),
        summary.computed,
        summary.damaged.len(),
    ))?;
    damaged_lines(&summary.damaged).iter().try_for_each(|line| print(line))?;
    if summary.missing > 0 && summary.unplanned > 0 {
        let count = summary.unplanned;
        print(&format!("rows of other runs: {count}; has a case file changed, or the experiment?"))?;
    }
    for run in &first_missing {
        let (step, phase) = (run.spec.macro_step * 1e3, run.spec.phase);
        print(&format!("missing: {} {} at H = {step} ms, phase {phase}", run.label, run.spec.parameters.given()))?;
    }
    if summary.missing > first_missing.len() {
        print(&format!("… and {} more", summary.missing - first_missing.len()))?;
    }
    if summary.missing == 0 && !experiment.claims().is_empty() {
        print(&claims_list(&check_fresh_claims(experiment, catalogue, folder)?))?;
    }
    Ok(if summary.missing == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
