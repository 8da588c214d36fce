//! `rimbench reproduce`: the main job. Experiments, results, figures, claims, report, from nothing.

use super::progress::progress_bar;
use super::{claims_table, complain, print};
use clap::Args;
use rayon::prelude::*;
use rimbench::BUILD;
use rimbench::atomic_file::check_writable_folder;
use rimbench::catalogue::Catalogue;
use rimbench::cosim::StopFlag;
use rimbench::error::{Error, Result};
use rimbench::figures::style::Styles;
use rimbench::figures::{FigureList, write_report};
use rimbench::harness::{Cache, CheckedClaim, Experiment, Job, Store, check_claims, run_job, write_claims};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The group of experiments that this command runs.
const GROUP: &str = "paper";

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
pub struct Reproduce {
    /// Folder for results [default: results, or results/quick with --quick]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Fewer phases and macro steps
    #[arg(long)]
    quick: bool,
}

impl Reproduce {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let started = Instant::now();
        let default = if self.quick { "results/quick" } else { "results" };
        let out = self.out.unwrap_or_else(|| PathBuf::from(default));
        let home = home()?;
        let experiments = experiments(&home.join("experiments").join(GROUP))?;
        let figures = FigureList::read(&home.join("paper/figures.toml"))?;
        let runs = experiments.iter().map(|experiment| Ok(experiment.plan(catalogue, self.quick)?.len()));
        let total: usize = runs.sum::<Result<usize>>()?;
        check_writable_folder(&out)?;

        let bar = progress_bar(total);
        let group = out.join(GROUP);
        let cache = Cache::of_user();
        let mut claims: Vec<CheckedClaim> = Vec::new();
        let mut not_completed = 0;
        for experiment in &experiments {
            bar.set_message(experiment.name());
            let folder = group.join(experiment.name());
            let job = Job {
                experiment,
                catalogue,
                folder: &folder,
                quick: self.quick,
                fresh: true,
                shard: None,
                cache: &cache,
                build: &BUILD,
            };
            let summary = run_job(job, &|_| bar.inc(1), StopFlag::never())?;
            not_completed += summary.not_completed;
            if bar.is_hidden() {
                eprintln!("{}: {} runs", experiment.name(), summary.computed);
            }
            claims.extend(check_claims(experiment, catalogue, &folder)?);
            // All is exported; what is to be resumed is for `run`.
            Store::clear(&folder)?;
        }
        bar.set_message("drawing figures");
        write_claims(&group.join("claims.csv"), &claims)?;
        let styles = Styles::of(catalogue.schemes().iter().map(|scheme| &**scheme));
        figures.of_group(Some(GROUP)).par_iter().try_for_each(|figure| figure.make(&out, &styles).map(drop))?;
        write_report(&home.join("paper/report.md"), &out, GROUP, &figures)?;
        bar.finish_and_clear();
        complain(&cache);

        print(&claims_table(&claims))?;
        print(&format!(
            "{total} runs ({not_completed} of them did not complete, as data) in {:.1} s. Report: {}",
            started.elapsed().as_secs_f64(),
            group.join("report.html").display()
        ))
    }
}

/// The folder with `experiments` and `paper`: here, or where this program was built.
pub(super) fn home() -> Result<PathBuf> {
    let candidates = [PathBuf::from("."), PathBuf::from(env!("CARGO_MANIFEST_DIR"))];
    let found = candidates.into_iter().find(|folder| folder.join("experiments").join(GROUP).is_dir());
    found.ok_or_else(|| Error::file("experiments/paper", "not found: run this from the project's folder"))
}

fn experiments(folder: &Path) -> Result<Vec<Experiment>> {
    let entries = std::fs::read_dir(folder).map_err(|error| Error::file(folder, format!("cannot be read: {error}")))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    if files.is_empty() {
        return Err(Error::file(folder, "holds no experiment (*.toml)"));
    }
    files.iter().map(|path| Experiment::read(path)).collect()
}
