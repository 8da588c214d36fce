//! `rimbench submit`: what is missing of an experiment, through an engine.

use super::interruption::Interruption;
use super::progress::{Heartbeat, plain_time};
use super::{INTERRUPTED, complain, print};
use anyhow::Context;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{ArgAction, Args};
use rimbench::BUILD;
use rimbench::atomic_file::{check_writable_folder, write_atomically};
use rimbench::catalogue::Catalogue;
use rimbench::error::{Error, Result};
use rimbench::harness::{
    Cache, ChunkLimits, Chunking, Engine, Experiment, Job, Order, Submission, Words, collect_shards, missing_chunks,
    next_place, prepare_folder,
};
use std::collections::VecDeque;
use std::path::{Path, PathBuf, absolute};
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Arguments of `submit`.
#[derive(Debug, Args)]
pub struct Submit {
    /// Experiment file (see experiments/README.md)
    file: PathBuf,
    /// What works through the runs
    #[arg(long, value_parser = PossibleValuesParser::new(Engine::NAMES.map(|(name, _)| name))
        .try_map(|name| name.parse::<Engine>()))]
    engine: Engine,
    /// Only print the files and the commands that it would be
    #[arg(long)]
    dry_run: bool,
    /// Folder for results [default: results/<group>/<name>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How long a chunk should take, s
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    chunk_time: f64,
    /// How long a run is taken to last where the store has none to go by, s
    #[arg(long, value_name = "S", default_value_t = 0.02)]
    run_time: f64,
    /// Threads of a chunk
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    cpus: u16,
    /// Chunks at once [default: what the engine likes; local and parallel: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    at_once: Option<u16>,
    /// A host for GNU parallel, as ssh knows it, with the same file system; may be repeated
    #[arg(long = "host", value_name = "HOST", action = ArgAction::Append)]
    hosts: Vec<String>,
    /// The program where the chunks run [default: this one]
    #[arg(long, value_name = "PATH")]
    program: Option<PathBuf>,
    /// The runs are timed: nothing may run beside one; so is an experiment whose file says `timed = true`
    #[arg(long)]
    exclusive: bool,
    /// Options for the engine's own program
    #[arg(last = true, value_name = "OPTION")]
    extra: Vec<String>,
}

/// How often a process that may have ended is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// Lines of a file that `--dry-run` prints.
const LINES: usize = 8;

impl Submit {
    /// Ends with exit code 1 if the engine has ended and runs are missing.
    ///
    /// `case_files` are those of the cases that the catalogue has besides.
    pub(super) fn run(self, catalogue: &Catalogue, case_files: &[PathBuf]) -> anyhow::Result<ExitCode> {
        for (option, value) in [("--chunk-time", self.chunk_time), ("--run-time", self.run_time)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::invalid(option, value, "a finite time above 0 s").into());
            }
        }
        let experiment = Experiment::read(&self.file)?;
        let folder = self.out.clone().unwrap_or_else(|| experiment.results_folder("results".as_ref()));
        let folder = absolute(&folder).context("the current folder is not known")?;
        let more_files = more_files(case_files)?;
        let cache = Cache::of_user();
        let job = Job::new(&experiment, catalogue, &folder, &cache, &BUILD);
        // On several cores a chunk takes as long as one on one.
        let seconds = self.chunk_time * f64::from(self.cpus);
        let limits = ChunkLimits { seconds, unmeasured_run_s: self.run_time };
        let chunking = missing_chunks(job, limits)?;
        if chunking.missing == 0 {
            let collect = collect_command(&folder, &more_files);
            print(&format!("Nothing is missing: all {} runs are stored. Result files: {collect}", chunking.planned))?;
            return Ok(ExitCode::SUCCESS);
        }
        let place = next_place(&folder);
        let submission = self.submission(&experiment, &more_files, &folder, &place, &chunking)?;
        print(&self.said_of(&chunking))?;
        if self.dry_run {
            print(&text_of(&submission))?;
            return Ok(ExitCode::SUCCESS);
        }
        if let Some(program) = self.engine.program() {
            check_program(self.engine, program)?;
        }
        check_writable_folder(&folder)?;
        prepare_folder(job)?;
        std::fs::create_dir_all(place.parent().unwrap_or(&place))
            .and_then(|()| std::fs::create_dir(&place))
            .map_err(|error| Error::file(&place, format!("cannot be made: {error}")))?;
        for (path, text) in &submission.files {
            write_atomically(path, |file| file.write_all(text.as_bytes()))?;
        }
        if self.engine == Engine::Local {
            if work_through(&submission, &place)? {
                print("Stopped. What is stored is kept; the same command goes on from there.")?;
                return Ok(ExitCode::from(INTERRUPTED));
            }
        } else {
            for command in &submission.commands {
                give(command, self.engine.waits())?;
            }
        }
        if !self.engine.waits() {
            print(&format!("When they are done: {}", collect_command(&folder, &more_files)))?;
            return Ok(ExitCode::SUCCESS);
        }
        // What came of it the records say.
        let (summary, _) = collect_shards(job, &[])?;
        complain(&cache);
        let stored = summary.planned - summary.missing;
        print(&format!("{stored} of {} runs stored in {}", summary.planned, folder.display()))?;
        if summary.missing == 0 {
            return Ok(ExitCode::SUCCESS);
        }
        print(&format!(
            "{} runs are missing: the same command submits them; what the chunks said is in {}",
            summary.missing,
            place.display()
        ))?;
        Ok(ExitCode::FAILURE)
    }

    fn submission(
        &self,
        experiment: &Experiment,
        more_files: &[(&'static str, PathBuf)],
        folder: &Path,
        place: &Path,
        chunking: &Chunking,
    ) -> anyhow::Result<Submission> {
        let program = match &self.program {
            Some(program) => program.clone(),
            None => std::env::current_exe().context("where this program lies is not known: say it with --program")?,
        };
        let file = absolute(&self.file).context("the current folder is not known")?;
        let cache = std::env::var_os("RIMBENCH_CACHE").map(absolute).transpose().context("RIMBENCH_CACHE")?;
        Ok(self.engine.submission(&Order {
            name: &experiment.name(),
            program: &program,
            file: &file,
            more_files,
            folder,
            place,
            cache: cache.as_deref(),
            chunks: &chunking.chunks,
            cpus: self.cpus.into(),
            at_once: self.at_once.map(usize::from),
            exclusive: self.exclusive || experiment.timed,
            hosts: &self.hosts,
            extra: &self.extra,
        })?)
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

/// Files of cases, absolute, with the option that reads them.
fn more_files(cases: &[PathBuf]) -> anyhow::Result<Vec<(&'static str, PathBuf)>> {
    cases
        .iter()
        .map(|file| Ok(("--case-file", absolute(file)?)))
        .collect::<std::io::Result<_>>()
        .context("the current folder is not known")
}

/// The command that writes the result files.
fn collect_command(folder: &Path, more_files: &[(&'static str, PathBuf)]) -> String {
    let mut words = Words::of("rimbench");
    words.extend(["collect".to_owned(), folder.display().to_string()]);
    more_files.iter().for_each(|(option, file)| words.option(option, file.display()));
    words.to_string()
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
    let commands: Vec<String> = submission.commands.iter().map(Words::to_string).collect();
    text + &commands.join("\n")
}

/// Refuses an engine whose program is not on the path.
fn check_program(engine: Engine, program: &str) -> Result<()> {
    let on_path = |program: &str| {
        let path = std::env::var_os("PATH").unwrap_or_default();
        std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
    };
    if on_path(program) {
        return Ok(());
    }
    let here = Engine::NAMES.iter().filter(|(_, engine)| engine.program().is_none_or(on_path)).map(|(name, _)| *name);
    let here: Vec<&str> = here.collect();
    let expected = format!(
        "an engine whose program is on the path: {}; `{program}` was looked for and is not. --dry-run needs none",
        here.join(", ")
    );
    Err(Error::invalid("--engine", engine, expected))
}

/// Gives a command to its program. One that waits for the chunks may end as it likes: what came of them is in the records.
fn give(command: &Words, waits: bool) -> anyhow::Result<()> {
    let words = command.words();
    let status = Command::new(&words[0]).args(&words[1..]).status();
    let status = status.with_context(|| format!("`{}` cannot be started", words[0]))?;
    if !waits && !status.success() {
        anyhow::bail!("`{}` did not take the chunks ({status}): {command}", words[0]);
    }
    Ok(())
}

/// Works through the commands of a submission as processes of this machine, and says whether somebody stopped it.
fn work_through(submission: &Submission, place: &Path) -> anyhow::Result<bool> {
    let interruption = Interruption::listen();
    let total = submission.commands.len();
    let ended = Arc::new(AtomicUsize::new(0));
    let seen = Arc::clone(&ended);
    let heartbeat = Heartbeat::lines(move |elapsed| {
        format!("submit: {} of {total} chunks ended, {} elapsed", seen.load(Ordering::Relaxed), plain_time(elapsed))
    });
    let mut waiting: VecDeque<(usize, &Words)> = submission.commands.iter().enumerate().collect();
    let mut at_work: Vec<Child> = Vec::new();
    while !at_work.is_empty() || !waiting.is_empty() {
        if interruption.is_asked() {
            // Those under way have been asked as well: they are of the same group.
            waiting.clear();
        }
        let free = submission.at_once - at_work.len();
        for (number, command) in waiting.drain(..free.min(waiting.len())) {
            at_work.push(begin(command, &place.join(format!("{}.out", number + 1)))?);
        }
        let before = at_work.len();
        let mut still = Vec::with_capacity(before);
        for mut child in at_work {
            if child.try_wait().context("a chunk cannot be waited for")?.is_none() {
                still.push(child);
            }
        }
        at_work = still;
        ended.fetch_add(before - at_work.len(), Ordering::Relaxed);
        if at_work.len() == before {
            std::thread::sleep(LOOK_EVERY);
        }
    }
    drop(heartbeat);
    Ok(interruption.is_asked())
}

/// Starts a process whose words go to a file.
fn begin(command: &Words, said: &Path) -> anyhow::Result<Child> {
    let words = command.words();
    let opened = std::fs::File::create(said).and_then(|file| Ok((file.try_clone()?, file)));
    let (out, err) = opened.map_err(|error| Error::file(said, format!("cannot be written: {error}")))?;
    let mut process = Command::new(&words[0]);
    process.args(&words[1..]).stdin(Stdio::null()).stdout(out).stderr(err);
    process.spawn().with_context(|| format!("`{}` cannot be started", words[0]))
}
