//! `rimbench perf`: has the program become slower?

use super::screen::Table;
use super::{print, print_json};
use anyhow::Context;
use clap::{Args, Subcommand, ValueEnum};
use rimbench::BUILD;
use rimbench::atomic_file::{check_writable_file, check_writable_folder};
use rimbench::error::Error;
use rimbench::harness::Provenance;
use rimbench::perf::{
    BENCHMARKS, Comparison, Fence, History, Instructions, Paired, Program, Recording, Repository, Round, Row, Verdict,
    benchmark_by_name, compare, measure, measure_rounds,
};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Where the history is kept, below the current folder.
const HISTORY: &str = "results/perf/history.csv";

/// Arguments of `perf`.
#[derive(Debug, Args)]
pub struct Perf {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the fixed suite and append its counters and instructions to the history
    Record(Record),
    /// Compare two records, or two git revisions (--rev A --rev B); exit code 1 on a regression
    Compare(Compare),
    /// Measure one benchmark in this process
    #[command(hide = true)]
    Sample(Sample),
}

impl Perf {
    pub(super) fn run(self) -> anyhow::Result<ExitCode> {
        match self.command {
            Command::Record(command) => command.run()?,
            Command::Compare(command) => return command.run(),
            Command::Sample(command) => command.run()?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// What to measure, shared by `record` and `compare --rev`.
#[derive(Debug, Args)]
struct Measuring {
    /// Only this benchmark; may be repeated
    #[arg(long = "benchmark", value_name = "NAME")]
    benchmarks: Vec<String>,
    /// Do not count instructions
    #[arg(long)]
    without_instructions: bool,
}

impl Measuring {
    /// The benchmarks to measure, of those there are.
    fn names(&self, known: Vec<String>) -> anyhow::Result<Vec<String>> {
        if let Some(name) = self.benchmarks.iter().find(|name| !known.contains(name)) {
            return Err(Error::unknown("benchmark", name, known.iter().map(String::as_str)).into());
        }
        Ok(if self.benchmarks.is_empty() { known } else { self.benchmarks.clone() })
    }

    /// What counts instructions, if it is wanted and there.
    fn instructions(&self) -> Option<Instructions> {
        let found = (!self.without_instructions).then(Instructions::find)?;
        found.inspect_err(|note| eprintln!("note: {note}")).ok()
    }
}

/// Arguments of `perf record`.
#[derive(Debug, Args)]
struct Record {
    /// The history
    #[arg(long, value_name = "FILE", default_value = HISTORY)]
    history: PathBuf,
    #[command(flatten)]
    measuring: Measuring,
}

impl Record {
    fn run(self) -> anyhow::Result<()> {
        let path = self.history;
        // A damaged history or a place that cannot be written is found before minutes of measuring.
        let mut history = History::read_or_begin(&path)?;
        check_writable_folder(path.parent().unwrap_or(Path::new(".")))?;
        check_writable_file(&path)?;
        let names = self.measuring.names(BENCHMARKS.iter().map(|benchmark| benchmark.name.to_owned()).collect())?;
        let program = Program {
            path: std::env::current_exe().context("this program cannot find itself")?,
            git_revision: BUILD.git_revision.to_owned(),
            git_dirty: BUILD.git_dirty.to_owned(),
        };
        let recording = Recording::begin(&program, &Provenance::collect(&BUILD), self.measuring.instructions());
        let mut table = Table::new(&["benchmark", "instructions", "status"]);
        let mut rows = Vec::new();
        for name in &names {
            eprintln!("{name}");
            let row = recording.row(name, &program.sample(name)?)?;
            let count = row.instructions.map_or_else(|| "–".to_owned(), |count| count.to_string());
            table.add_row([name.as_str(), &count, &row.status]);
            rows.push(row);
        }
        history.append(&rows)?;
        print(&table.to_string())?;
        print(&format!("record {}: {} rows appended to {}", rows[0].record, rows.len(), path.display()))
    }
}

/// Arguments of `perf compare`.
#[derive(Debug, Args)]
struct Compare {
    /// latest, previous, or the first digits of a record or git revision of the history
    #[arg(value_name = "BASE", required_unless_present = "rev", conflicts_with = "rev")]
    base: Option<String>,
    /// Likewise
    #[arg(value_name = "NEW", required_unless_present = "rev", conflicts_with = "rev")]
    new: Option<String>,
    /// A git revision to build and measure; given twice, first the base
    #[arg(long, value_name = "REV")]
    rev: Vec<String>,
    /// The history
    #[arg(long, value_name = "FILE", default_value = HISTORY)]
    history: PathBuf,
    /// Rounds of the wall times of revisions; 0 measures none
    #[arg(long, value_name = "N", default_value = "12")]
    rounds: u32,
    /// How to print
    #[arg(long, value_enum, default_value = "markdown")]
    format: Output,
    #[command(flatten)]
    measuring: Measuring,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Output {
    /// For reading, and for a comment on a change.
    Markdown,
    /// For programs.
    Json,
}

impl Compare {
    fn run(self) -> anyhow::Result<ExitCode> {
        let comparison = match (&self.base, &self.new) {
            (Some(base), Some(new)) => {
                let history = History::read(&self.history)?;
                compare(&history.select(base)?, &history.select(new)?, Fence::Repeated, &[])
            }
            _ => self.revisions()?,
        };
        let regressions = comparison.regressions();
        match self.format {
            Output::Markdown => print(&comparison.markdown())?,
            Output::Json => {
                let mut object = serde_json::to_value(&comparison)?;
                object["regressions"] = regressions.clone().into();
                print_json(&object)?;
            }
        }
        Ok(if regressions.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }

    /// Builds both revisions, measures them in turn, and measures again what looks slower.
    fn revisions(&self) -> anyhow::Result<Comparison> {
        let [base, new] = self.rev.as_slice() else {
            return Err(Error::invalid("--rev", self.rev.join(" "), "two revisions: --rev BASE --rev NEW").into());
        };
        if self.rounds == 1 {
            return Err(Error::invalid("--rounds", self.rounds, "0, or at least 2: one round has no spread").into());
        }
        // Interrupted, the compiler ends by itself, and what was checked out is removed.
        let _ = ctrlc::set_handler(|| {});
        let repository = Repository::around(&std::env::current_dir()?)?;
        let commits = [repository.resolve(base)?, repository.resolve(new)?];
        let folder = tempfile::tempdir().context("no temporary folder")?;
        let target = folder.path().join("target");
        let base_folder = repository.check_out(&commits[0], folder.path())?;
        let base = base_folder.build(&target)?;
        // Cargo takes files for built that are older than what it has built.
        let new_folder = repository.check_out(&commits[1], folder.path())?;
        self.measure(&base, &new_folder.build(&target)?)
    }

    fn measure(&self, base: &Program, new: &Program) -> anyhow::Result<Comparison> {
        let (known, offered) = (base.benchmarks()?, new.benchmarks()?);
        let (common, added): (Vec<String>, _) = offered.into_iter().partition(|name| known.contains(name));
        let lost = known.into_iter().filter(|name| !common.contains(name));
        let others: Vec<String> = lost.chain(added).collect();
        let instructions = self.measuring.instructions();
        let provenance = Provenance::collect(&BUILD);
        let records = [base, new].map(|program| Recording::begin(program, &provenance, instructions));
        let (mut rows, mut paired): ([Vec<Row>; 2], Vec<Paired>) = Default::default();
        for benchmark in self.measuring.names(common)? {
            eprintln!("{benchmark}");
            let rounds = measure_rounds(base, new, &benchmark, self.rounds.max(1))?;
            for (rows, (record, sample)) in rows.iter_mut().zip(records.iter().zip([&rounds[0].base, &rounds[0].new])) {
                rows.push(record.row(&benchmark, sample)?);
            }
            if let Some((ratio, placebo)) = Round::ratio(&rounds).zip(Round::placebo(&rounds)) {
                let mut pair = Paired { benchmark, ratio, placebo, second: None };
                if pair.decide() == Verdict::Suspected || ratio.interval()[1] < 1.0 {
                    pair.second = Round::ratio(&measure_rounds(base, new, &pair.benchmark, self.rounds)?);
                }
                paired.push(pair);
            }
        }
        let mut comparison = compare(&rows[0], &rows[1], Fence::Rebuilt, &paired);
        if !others.is_empty() {
            comparison.notes.push(format!("not in both revisions: {}", others.join(", ")));
        }
        Ok(comparison)
    }
}

/// Arguments of `perf sample`.
#[derive(Debug, Args)]
struct Sample {
    /// Name in the suite
    #[arg(required_unless_present = "list")]
    benchmark: Option<String>,
    /// Names of the suite
    #[arg(long)]
    list: bool,
    /// How often; the last one is timed
    #[arg(long, default_value = "2")]
    repetitions: u32,
}

impl Sample {
    fn run(self) -> anyhow::Result<()> {
        let Some(name) = self.benchmark.filter(|_| !self.list) else {
            let names: Vec<&str> = BENCHMARKS.iter().map(|benchmark| benchmark.name).collect();
            return print(&serde_json::to_string(&names)?);
        };
        print(&serde_json::to_string(&measure(benchmark_by_name(&name)?, self.repetitions, &BUILD)?)?)
    }
}
