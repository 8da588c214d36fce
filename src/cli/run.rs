//! `rimbench run`: what is missing of an experiment.

use super::collect::collect;
use super::interruption::Interruption;
use super::plan;
use super::progress::Progress;
use super::project::Project;
use super::screen::{Mood, verdict};
use super::submit::Submit;
use super::summary::not_completed;
use super::{Format, INTERRUPTED, claims_list, damaged_lines, print, probe_lines, program, warn_of_cache};
use anyhow::Context;
use clap::Args;
use rimbench::BUILD;
use rimbench::catalogue::Catalogue;
use rimbench::error::{Error, Result};
use rimbench::fmi::import::SideNotes;
use rimbench::harness::{Cache, Job, Shard, Step, check_fresh_claims, in_shell, run_job_until};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct Run {
    /// Experiment file (see experiments/README.md), of 1000000 runs at most; above 100000 run in parts
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
    /// Number of the first shard: some job arrays count from 0
    #[arg(long, value_name = "0|1", default_value_t = 1, requires = "shard", conflicts_with_all = ["places", "collect", "dry_run", "slurm"], value_parser = clap::value_parser!(u8).range(0..=1))]
    first_shard: u8,
    /// Only the runs at these places of the plan, from 0: the task of a job array, after which --collect writes the
    /// result files
    #[arg(long, value_name = "FIRST-LAST", conflicts_with_all = ["shard", "fresh"])]
    places: Option<String>,
    /// Forget what is stored and start again
    #[arg(long)]
    fresh: bool,
    /// Run nothing: merge these shards, results folders of the same experiment, list what is missing, and write the
    /// result files if nothing is
    #[arg(long, value_name = "DIR", num_args = 0.., conflicts_with_all = ["jobs", "shard", "places", "fresh"])]
    collect: Option<Vec<PathBuf>>,
    /// Run nothing: print the runs, or with --slurm its files and commands
    #[arg(long, conflicts_with_all = ["jobs", "shard", "places", "fresh", "collect"])]
    dry_run: bool,
    /// With --dry-run: all runs, however many
    #[arg(long, requires = "dry_run", conflicts_with_all = ["slurm", "jobs", "shard", "places", "fresh", "collect"])]
    all: bool,
    /// How to print a dry run; JSON has all runs
    #[arg(long, value_enum, default_value_t = Format::Table, requires = "dry_run",
        conflicts_with_all = ["slurm", "jobs", "shard", "places", "fresh", "collect"])]
    format: Format,
    #[command(flatten)]
    submit: Submit,
}

impl Run {
    /// `files` are those of the cases and schemes that the catalogue has besides. Exit code 1 if shards were merged and
    /// runs are missing.
    pub(super) fn run(
        self,
        catalogue: &Catalogue,
        notes: &SideNotes,
        files: &[(&'static str, PathBuf)],
    ) -> anyhow::Result<ExitCode> {
        let experiment = Project::experiment(&self.file)?;
        let folder = self.out.clone().unwrap_or_else(|| experiment.results_folder("results".as_ref()));
        if self.submit.slurm {
            self.submit.submit((&experiment, catalogue, &folder), files, self.dry_run)?;
            return Ok(ExitCode::SUCCESS);
        }
        if self.dry_run {
            plan::show(&experiment, catalogue, self.all, self.format)?;
            return Ok(ExitCode::SUCCESS);
        }
        if let Some(shards) = &self.collect {
            return collect(&experiment, catalogue, &folder, shards);
        }
        // Before anything runs on all of them: a plan is laid out by threads as well.
        use_threads(self.jobs)?;
        let shard = match (&self.shard, &self.places) {
            (Some(text), _) => Some(parse_shard(text, self.first_shard.into())?),
            (None, Some(text)) => Some(parse_places(text)?),
            (None, None) => None,
        };
        for note in experiment.notes(catalogue, false)? {
            eprintln!("note: {note}");
        }
        let interruption = Interruption::listen(true);
        // How many there are is told when the plan is laid out.
        let progress = Progress::begin("run", Some(0));
        let cache = Cache::of_user();
        let job = Job { fresh: self.fresh, shard, ..Job::new(&experiment, catalogue, &folder, &cache, &BUILD) };
        let told = |step: Step| match step {
            Step::ToDo(count) => progress.to_do(count),
            step => progress.after(step),
        };
        let summary = match run_job_until(job, &told, interruption.flags()) {
            Err(Error::Stopped) => {
                print("Stopped. All runs are stored; the same command writes the result files.")?;
                return Ok(ExitCode::from(INTERRUPTED));
            }
            summary => summary?,
        };
        progress.end();
        if summary.renewed > 0 {
            print(&format!(
                "{} of those computed had been stored, but took too long for the limit they had, or lacked the trace asked for",
                summary.renewed
            ))?;
        }
        warn_of_cache(&cache);
        // Those of references are among them.
        probe_lines(&notes.probed()).iter().try_for_each(|line| print(line))?;
        damaged_lines(&summary.damaged).iter().try_for_each(|line| print(line))?;
        if interruption.is_asked() && summary.missing > 0 {
            print("Stopped. What is stored is kept; the same command goes on from there.")?;
            return Ok(ExitCode::from(INTERRUPTED));
        }
        if summary.in_parts || matches!(shard, Some(Shard::Places { .. })) {
            // Whether that was all is for --collect to find out, where there are not too many runs for tables.
        } else if summary.missing > 0 {
            print(&format!("{} runs are missing: run the other shards, then --collect them", summary.missing))?;
        } else {
            if let Some(remark) = not_completed(&experiment, &folder)? {
                print(&remark)?;
            }
            print(&super::summary::summary(&folder)?)?;
            if !experiment.claims().is_empty() {
                print(&claims_list(&check_fresh_claims(&experiment, catalogue, &folder)?))?;
            }
        }
        let (done, mood) = match summary.missing {
            0 => ("", Mood::Good),
            _ => (" · some are missing", Mood::Open),
        };
        print(&verdict(
            &format!(
                "{} of {} runs stored: {} computed now ({} did not complete), {} were there{done}",
                summary.planned - summary.missing,
                summary.planned,
                summary.computed,
                summary.not_completed,
                summary.reused,
            ),
            mood,
        ))?;
        let quoted = in_shell(&[folder.display().to_string()]);
        let folder = folder.display();
        print(&match summary.missing {
            0 if summary.in_parts => format!("{folder}/records: rows of more runs than result files have"),
            0 => format!("{folder}/runs.csv · `{} report {quoted}` writes a page", program()),
            _ => format!("in {folder}"),
        })?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Lets so many threads work, if a number is given.
pub(super) fn use_threads(jobs: Option<usize>) -> anyhow::Result<()> {
    let Some(jobs) = jobs else { return Ok(()) };
    if !(1..=1024).contains(&jobs) {
        return Err(Error::invalid("--jobs", jobs, "a whole number from 1 to 1024").into());
    }
    rayon::ThreadPoolBuilder::new().num_threads(jobs).build_global().context("cannot start threads")
}

fn parse_shard(text: &str, first: usize) -> Result<Shard> {
    let (part, of) = two_numbers(text, '/').unwrap_or_default();
    if part >= first && part - first < of {
        return Ok(Shard::Every { part: part + 1 - first, of });
    }
    Err(Error::invalid(
        "--shard",
        text,
        format!("i/n with {first} ≤ i {} n, for example 2/4", if first == 0 { "<" } else { "≤" }),
    ))
}

fn parse_places(text: &str) -> Result<Shard> {
    let places = two_numbers(text, '-').filter(|(first, last)| first <= last);
    let (first, last) = places.ok_or_else(|| Error::invalid("--places", text, "first-last, for example 0-99"))?;
    Ok(Shard::Places { first, last })
}

fn two_numbers(text: &str, between: char) -> Option<(usize, usize)> {
    let (one, other) = text.split_once(between)?;
    Some((one.parse().ok()?, other.parse().ok()?))
}
