//! `rimbench reproduce`: the main job. Experiments, results, figures, claims, report, from nothing.

use super::{print, table};
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;
use rimbench::error::{Error, Result};
use rimbench::harness::{
    Cache, CheckedClaim, Executed, Experiment, Provenance, check_claims, check_writable_folder, execute, write_claims,
    write_results,
};
use rimbench::report::{FigureList, write_report};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

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
    pub(super) fn run(self) -> anyhow::Result<()> {
        let started = Instant::now();
        let default = if self.quick { "results/quick" } else { "results" };
        let out = self.out.unwrap_or_else(|| PathBuf::from(default));
        let home = home()?;
        let experiments = experiments(&home.join("experiments").join(GROUP))?;
        let figures = FigureList::read(&home.join("paper/figures.toml"))?;
        let runs = experiments.iter().map(|experiment| Ok(experiment.plan(self.quick)?.len()));
        let total: usize = runs.sum::<Result<usize>>()?;
        check_writable_folder(&out)?;

        let bar = progress_bar(total);
        let executed = run_all(&experiments, self.quick, &bar)?;
        bar.set_message("writing results and figures");
        let provenance = Provenance::collect();
        let mut claims: Vec<CheckedClaim> = Vec::new();
        for executed in &executed {
            write_results(&out.join(GROUP).join(executed.experiment.name()), executed, &provenance)?;
            claims.extend(check_claims(executed)?);
        }
        let group = out.join(GROUP);
        write_claims(&group.join("claims.csv"), &claims)?;
        figures.figures.par_iter().try_for_each(|figure| figure.make(&out).map(drop))?;
        write_report(&home.join("paper/report.md"), &out, GROUP, &figures)?;
        bar.finish_and_clear();

        print(&claims_table(&claims))?;
        let diverged = executed.iter().flat_map(|executed| &executed.runs);
        let diverged = diverged.filter(|run| run.evaluated.outcome.name() == "diverged").count();
        print(&format!(
            "{total} runs ({diverged} diverged, as data) in {:.1} s. Report: {}",
            started.elapsed().as_secs_f64(),
            group.join("report.html").display()
        ))
    }
}

/// The folder with `experiments` and `paper`: here, or where this program was built.
fn home() -> Result<PathBuf> {
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

fn run_all(experiments: &[Experiment], quick: bool, bar: &ProgressBar) -> Result<Vec<Executed>> {
    let cache = Cache::of_user();
    let mut executed = Vec::new();
    for experiment in experiments {
        bar.set_message(experiment.name());
        let done = execute(experiment, quick, &cache, &|_| bar.inc(1))?;
        if bar.is_hidden() {
            eprintln!("{}: {} runs", experiment.name(), done.runs.len());
        }
        executed.push(done);
    }
    Ok(executed)
}

/// A bar on a terminal; nothing but a line per experiment elsewhere.
fn progress_bar(total: usize) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(total as u64), ProgressDrawTarget::stderr());
    let style = "{bar:40} {pos}/{len} runs, {elapsed} elapsed, {eta} left  {msg}";
    if let Ok(style) = ProgressStyle::with_template(style) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

fn claims_table(claims: &[CheckedClaim]) -> String {
    let mut table = table(&["claim", "by", "measured", "expected", "verdict"]);
    for claim in claims {
        let measured = claim.measured.map_or("–".to_owned(), |value| format!("{value:.4}"));
        let changed = if claim.verdict == claim.finding { "" } else { " (differs from the recorded finding)" };
        let by = format!("{:?}", claim.by).to_lowercase();
        let verdict = format!("{}{changed}", claim.verdict);
        table.add_row([format!("{}: {}", claim.text, claim.quantity), by, measured, claim.expected.clone(), verdict]);
    }
    table.to_string()
}
