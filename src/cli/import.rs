//! `rimbench import`: checks a data package, and computes some of its runs once more.

use super::{complain, print};
use clap::Args;
use rimbench::BUILD;
use rimbench::catalogue::Catalogue;
use rimbench::cosim::StopFlag;
use rimbench::harness::{Cache, Job, Package, Rerun, rerun_sample};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{SystemTime, UNIX_EPOCH};

/// Arguments of `import`.
#[derive(Debug, Args)]
pub struct Import {
    /// Folder of the package
    #[arg(value_name = "DIR")]
    package: PathBuf,
    /// Keep its results folder here: empty or not there yet
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How many runs to compute once more
    #[arg(long, value_name = "N", default_value_t = 3)]
    sample: usize,
    /// Chooses which; if not given, as the clock says
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

/// Cells that are named one by one.
const NAMED: usize = 5;

impl Import {
    /// Ends with exit code 1 if a run or a file comes out differently, or if no run could be compared.
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        let package = Package::read(&self.package, catalogue)?;
        let scratch = tempfile::tempdir()?;
        let folder = scratch.path().join("results");
        package.unpack_named(catalogue, &folder)?;
        if let Some(out) = &self.out {
            package.unpack(catalogue, out)?;
        }
        print(&format!(
            "{}: {} runs, every file as it was written{}",
            package.experiment.name(),
            package.planned.len(),
            if package.quick { " (the quick plan)" } else { "" }
        ))?;
        let changed = package.not_as_exported(catalogue, &folder, &scratch.path().join("anew"))?;
        if !changed.is_empty() {
            print(&format!("not as this program writes them from these results: {}", changed.join(", ")))?;
        }
        let as_exported = if changed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
        if self.sample == 0 {
            return Ok(as_exported);
        }
        let seed = self.seed.unwrap_or_else(seed_of_clock);
        let (cache, again) = (Cache::of_user(), scratch.path().join("again"));
        let job = Job { quick: package.quick, ..Job::new(&package.experiment, catalogue, &again, &cache, &BUILD) };
        let reruns = rerun_sample(job, &package.planned, |_| true, &folder, (self.sample, seed), StopFlag::never())?;
        complain(&cache);
        reruns.iter().try_for_each(say)?;
        let differ = reruns.iter().filter(|rerun| !rerun.differing.is_empty()).count();
        let equal = reruns.len() - differ;
        print(&format!(
            "{} runs computed once more (--seed {seed}): {equal} equal to the digit, {differ} not",
            reruns.len()
        ))?;
        Ok(if equal > 0 && differ == 0 { as_exported } else { ExitCode::FAILURE })
    }
}

/// A seed that nobody could know when the package was written.
pub(super) fn seed_of_clock() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |now| u64::from(now.subsec_nanos()))
}

/// Says of a run what came out differently.
pub(super) fn say(rerun: &Rerun) -> anyhow::Result<()> {
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
