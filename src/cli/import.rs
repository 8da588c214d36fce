//! `rimbench import`: checks a data package, and computes some of its runs once more.

use super::{complain, print};
use clap::Args;
use rimbench::BUILD;
use rimbench::catalogue::Catalogue;
use rimbench::harness::{Cache, Job, Package, Rerun, rerun_sample};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `import`.
#[derive(Debug, Args)]
pub struct Import {
    /// Folder of the package
    #[arg(value_name = "DIR")]
    package: PathBuf,
    /// Keep its results folder here: empty or not there yet
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How many runs to compute once more: those with the smallest ids
    #[arg(long, value_name = "N", default_value_t = 3)]
    sample: usize,
}

/// Cells that are named one by one.
const NAMED: usize = 5;

impl Import {
    /// Ends with exit code 1 if a run comes out differently.
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        let package = Package::read(&self.package, catalogue)?;
        let scratch = tempfile::tempdir()?;
        let folder = self.out.unwrap_or_else(|| scratch.path().join("results"));
        package.unpack(catalogue, &folder)?;
        print(&format!(
            "{}: {} runs, every file as it was written{}",
            package.experiment.name(),
            package.planned.len(),
            if package.quick { " (the quick plan)" } else { "" }
        ))?;
        if self.sample == 0 {
            return Ok(ExitCode::SUCCESS);
        }
        let (cache, again) = (Cache::of_user(), scratch.path().join("again"));
        let quick = package.quick;
        let job = Job { quick, ..Job::new(&package.experiment, catalogue, &again, &cache, &BUILD) };
        let reruns = rerun_sample(job, &package.planned, &folder, self.sample)?;
        complain(&cache);
        reruns.iter().try_for_each(say)?;
        let differ = reruns.iter().filter(|rerun| !rerun.differing.is_empty()).count();
        print(&format!(
            "{} runs computed once more: {} equal to the digit, {differ} not",
            reruns.len(),
            reruns.len() - differ
        ))?;
        Ok(if differ == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}

fn say(rerun: &Rerun) -> anyhow::Result<()> {
    let of = format!("{} {} at H = {} ms", rerun.run_id, rerun.label, rerun.macro_step_s * 1e3);
    if rerun.differing.is_empty() {
        return print(&format!("{of}: equal"));
    }
    for cell in rerun.differing.iter().take(NAMED) {
        print(&format!("{of}: {} is {} here, {} in the package", cell.column, said(&cell.found), said(&cell.stored)))?;
    }
    let more = rerun.differing.len().saturating_sub(NAMED);
    if more > 0 { print(&format!("{of}: and {more} more cells")) } else { Ok(()) }
}

/// A cell that may be empty.
fn said(cell: &str) -> &str {
    if cell.is_empty() { "nothing" } else { cell }
}
