//! `rimbench run`: what is missing of an experiment.

use super::progress::progress_bar;
use super::{claims_table, complain, print};
use anyhow::Context;
use clap::Args;
use rimbench::BUILD;
use rimbench::atomic_file::check_writable_folder;
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{Outcome, StopFlag};
use rimbench::error::{Error, Result};
use rimbench::harness::{Cache, Experiment, Job, check_claims, run_job};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Exit code after Ctrl-C, as shells have it.
const INTERRUPTED: u8 = 130;

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct Run {
    /// Experiment file (see experiments/README.md)
    file: PathBuf,
    /// Folder for results [default: results/<group>/<name>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// Only part i of n, for several processes or machines
    #[arg(long, value_name = "I/N")]
    shard: Option<String>,
    /// Forget what is stored and start anew
    #[arg(long)]
    fresh: bool,
}

impl Run {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        let experiment = Experiment::read(&self.file)?;
        let total = experiment.plan(catalogue, false)?.len();
        let shard = self.shard.as_deref().map(parse_shard).transpose()?;
        if let Some(jobs) = self.jobs {
            if !(1..=1024).contains(&jobs) {
                return Err(Error::invalid("--jobs", jobs, "a whole number from 1 to 1024").into());
            }
            rayon::ThreadPoolBuilder::new().num_threads(jobs).build_global().context("cannot start threads")?;
        }
        let folder = self.out.unwrap_or_else(|| experiment.results_folder("results".as_ref()));
        check_writable_folder(&folder)?;
        let stop = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stop);
        ctrlc::set_handler(move || asked.store(true, Ordering::Relaxed)).context("cannot listen for Ctrl-C")?;

        let bar = progress_bar(total);
        let failures = AtomicUsize::new(0);
        let cache = Cache::of_user();
        let job = Job {
            experiment: &experiment,
            catalogue,
            folder: &folder,
            quick: false,
            fresh: self.fresh,
            shard,
            cache: &cache,
            build: &BUILD,
        };
        let progress = |outcome: &Outcome| {
            bar.inc(1);
            if *outcome != Outcome::Completed {
                let count = failures.fetch_add(1, Ordering::Relaxed) + 1;
                bar.set_message(format!("{count} did not complete"));
            }
        };
        let summary = run_job(job, &progress, StopFlag::new(&stop))?;
        bar.finish_and_clear();
        print(&format!(
            "{} of {} runs stored in {}: {} computed now ({} of them did not complete, as data), {} were there",
            summary.planned - summary.missing,
            summary.planned,
            folder.display(),
            summary.computed,
            summary.not_completed,
            summary.reused,
        ))?;
        if summary.renewed > 0 {
            print(&format!(
                "{} of those computed had been stored, but took too long for the limit they had, or lacked the trace asked for",
                summary.renewed
            ))?;
        }
        complain(&cache);
        if summary.damaged > 0 {
            print(&format!(
                "{} damaged records were left out and computed again where they belong here",
                summary.damaged
            ))?;
        }
        if stop.load(Ordering::Relaxed) {
            print("Stopped. What is stored is kept; the same command goes on from there.")?;
            return Ok(ExitCode::from(INTERRUPTED));
        }
        if summary.missing > 0 {
            print(&format!("{} runs are missing: run the other shards, then `rimbench collect`", summary.missing))?;
        } else if !experiment.claims().is_empty() {
            print(&claims_table(&check_claims(&experiment, catalogue, &folder)?))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn parse_shard(text: &str) -> Result<(usize, usize)> {
    let parsed = text.split_once('/').and_then(|(part, parts)| Some((part.parse().ok()?, parts.parse().ok()?)));
    parsed
        .filter(|(part, parts)| (1..=*parts).contains(part))
        .ok_or_else(|| Error::invalid("--shard", text, "i/n with 1 ≤ i ≤ n, for example 2/4"))
}
