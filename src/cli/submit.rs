//! `rimbench run --slurm`: what is missing of an experiment, as a job array of Slurm.

use super::progress::plain_time;
use super::run_options::seconds;
use super::{print, program};
use anyhow::Context;
use clap::Args;
use rimbench::BUILD;
use rimbench::atomic_file::write_atomically;
use rimbench::catalogue::Catalogue;
use rimbench::error::{Error, Result};
use rimbench::harness::{
    Cache, ChunkLimits, Chunking, Experiment, Job, SBATCH, SlurmArray, Submission, in_shell, missing_chunks,
    next_place, prepare_folder,
};
use std::path::{Path, PathBuf, absolute};
use std::process::Command;

/// Options of `run` that hand runs to Slurm.
/// What goes not with `--slurm`, nor with what needs it: clap asks for nothing that conflicts with what is given.
const NOT_SLURM: [&str; 5] = ["jobs", "shard", "places", "fresh", "collect"];

#[derive(Debug, Args)]
#[command(next_help_heading = "On a cluster")]
pub(super) struct Submit {
    /// Hand what is missing to Slurm, in chunks
    #[arg(long, conflicts_with_all = NOT_SLURM)]
    pub(super) slurm: bool,
    /// How long a chunk should take, s
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = seconds, requires = "slurm", conflicts_with_all = NOT_SLURM)]
    chunk_time: f64,
    /// How long a run is taken to last where the store has none to go by, s
    #[arg(long, value_name = "TIME", default_value = "20ms", value_parser = seconds, requires = "slurm", conflicts_with_all = NOT_SLURM)]
    run_time: f64,
    /// Threads of a chunk
    #[arg(long, value_name = "N", default_value_t = 1, requires = "slurm", conflicts_with_all = NOT_SLURM, value_parser = clap::value_parser!(u16).range(1..=1024))]
    cpus: u16,
    /// Chunks at once [default: what Slurm likes]
    #[arg(long, value_name = "N", requires = "slurm", conflicts_with_all = NOT_SLURM, value_parser = clap::value_parser!(u16).range(1..))]
    at_once: Option<u16>,
    /// The program where the chunks run [default: this one]
    #[arg(long, value_name = "PATH", requires = "slurm", conflicts_with_all = NOT_SLURM)]
    program: Option<PathBuf>,
    /// The runs are timed: nothing may run beside one; also an experiment whose file says `timed = true`
    #[arg(long, requires = "slurm", conflicts_with_all = NOT_SLURM)]
    exclusive: bool,
    /// Options for `sbatch`
    #[arg(last = true, value_name = "OPTION", requires = "slurm", conflicts_with_all = NOT_SLURM)]
    extra: Vec<String>,
}

/// Lines of a file that `--dry-run` prints.
const LINES: usize = 8;

impl Submit {
    /// Hands over what is missing; with `dry_run` only says so. `files` are those of the cases and schemes that the
    /// catalogue has besides.
    pub(super) fn submit(
        &self,
        (experiment, catalogue, folder): (&Experiment, &Catalogue, &Path),
        files: &[(&'static str, PathBuf)],
        dry_run: bool,
    ) -> anyhow::Result<()> {
        for (option, value) in [("--chunk-time", self.chunk_time), ("--run-time", self.run_time)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::invalid(option, value, "a finite time above 0 s").into());
            }
        }
        let file = absolute(experiment.path()).context("the current folder is not known")?;
        let folder = absolute(folder).context("the current folder is not known")?;
        let more_files =
            files.iter().map(|(option, file)| Ok((*option, absolute(file)?))).collect::<std::io::Result<Vec<_>>>();
        let more_files = more_files.context("the current folder is not known")?;
        let cache = Cache::of_user();
        let job = Job::new(experiment, catalogue, &folder, &cache, &BUILD);
        // On several cores a chunk takes as long as one on one.
        let seconds = self.chunk_time * f64::from(self.cpus);
        let chunking = missing_chunks(job, ChunkLimits { seconds, unmeasured_run_s: self.run_time })?;
        let collect = collect_command(&file, &folder, &more_files);
        if chunking.missing == 0 {
            return print(&format!(
                "Nothing is missing: all {} runs are stored. Result files: {collect}",
                chunking.planned
            ));
        }
        let place = next_place(&folder);
        let submission = self.submission(experiment, (&file, &more_files), (&folder, &place), &chunking)?;
        print(&self.said_of(&chunking))?;
        if dry_run {
            return print(&text_of(&submission));
        }
        check_program()?;
        prepare_folder(job)?;
        std::fs::create_dir_all(place.parent().unwrap_or(&place))
            .and_then(|()| std::fs::create_dir(&place))
            .map_err(|error| Error::file(&place, format!("cannot be made: {error}")))?;
        for (path, text) in &submission.files {
            write_atomically(path, |file| file.write_all(text.as_bytes()))?;
        }
        submission.commands.iter().try_for_each(|command| give(command))?;
        print(&format!("When they are done: {collect}"))
    }

    fn submission(
        &self,
        experiment: &Experiment,
        (file, more_files): (&Path, &[(&'static str, PathBuf)]),
        (folder, place): (&Path, &Path),
        chunking: &Chunking,
    ) -> anyhow::Result<Submission> {
        let program = match &self.program {
            Some(program) => program.clone(),
            None => std::env::current_exe().context("where this program lies is not known: say it with --program")?,
        };
        let array = SlurmArray {
            name: &experiment.name(),
            program: &program,
            file,
            more_files,
            folder,
            place,
            chunks: &chunking.chunks,
            cpus: self.cpus.into(),
            at_once: self.at_once.map(usize::from),
            exclusive: self.exclusive || experiment.timed,
            extra: &self.extra,
        };
        Ok(array.submission()?)
    }

    fn said_of(&self, chunking: &Chunking) -> String {
        let Chunking { planned, missing, measured, ref chunks } = *chunking;
        let by = match (measured, missing - measured) {
            (0, _) => format!("at {} s per run: none is measured yet", self.run_time),
            (_, 0) => "by the times of stored runs".to_owned(),
            (_, guessed) => {
                format!("by the times of stored runs; {guessed} of them at {} s, none being near", self.run_time)
            }
        };
        let time = plain_time(chunking.seconds());
        format!(
            "{missing} of {planned} runs are missing; in chunks: {}; on one core in all: {time} ({by})",
            chunks.len()
        )
    }
}

/// The command that writes the result files.
fn collect_command(file: &Path, folder: &Path, more_files: &[(&'static str, PathBuf)]) -> String {
    let shown = |path: &Path| path.display().to_string();
    let mut words = vec![program().to_owned(), "run".to_owned(), shown(file)];
    more_files.iter().for_each(|(option, file)| words.extend([(*option).to_owned(), shown(file)]));
    words.extend(["--out".to_owned(), shown(folder), "--collect".to_owned()]);
    in_shell(&words)
}

/// Files and commands of a submission, for reading.
fn text_of(submission: &Submission) -> String {
    let mut text = String::new();
    for (path, content) in &submission.files {
        text += &format!("\n# {}\n", path.display());
        let count = content.lines().count();
        let shown = if count <= LINES + 1 { count } else { LINES };
        content.lines().take(shown).for_each(|line| text += &format!("{line}\n"));
        if shown < count {
            text += &format!("… and {} lines more\n", count - shown);
        }
    }
    text += "\n# commands\n";
    let commands: Vec<String> = submission.commands.iter().map(|command| in_shell(command)).collect();
    text + &commands.join("\n")
}

/// Refuses Slurm where its program is not on the path.
fn check_program() -> Result<()> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    if std::env::split_paths(&path).any(|folder| folder.join(SBATCH).is_file()) {
        return Ok(());
    }
    Err(Error::Incompatible(format!("--slurm needs `{SBATCH}` on the path, and it is not there. --dry-run needs none")))
}

/// Gives a command to its program.
fn give(command: &[String]) -> anyhow::Result<()> {
    let (program, arguments) = command.split_first().context("a command has a program")?;
    let status = Command::new(program).args(arguments).status();
    let status = status.with_context(|| format!("`{program}` cannot be started"))?;
    if !status.success() {
        anyhow::bail!("`{program}` did not take the chunks ({status}): {}", in_shell(command));
    }
    Ok(())
}
