//! `rimbench perf`: has the program become slower?

use super::perf_compare::Compare;
use super::perf_measuring::{HISTORY, Measuring};
use super::screen::Table;
use super::{Format, print, print_json};
use anyhow::Context;
use clap::{Args, Subcommand};
use rimbench::BUILD;
use rimbench::atomic_file::{check_writable_file, check_writable_folder};
use rimbench::harness::Provenance;
use rimbench::perf::{self, BENCHMARKS, History, PerStep, Program, Row, benchmark_by_name, history_steps};
use rimbench::statistics::quantile;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `perf`.
#[derive(Debug, Args)]
pub struct Perf {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the fixed suite and append its counters, instructions and times to the history
    Record(Record),
    /// Compare two records, or two git revisions (--rev A --rev B); exit code 1 on a regression
    Compare(Compare),
    /// Show a record: instructions, time, and time per macro and micro step
    Show(Show),
    /// List all steps of the history in words, each with the revisions that it lies between
    Steps(Steps),
    /// Measure one benchmark in this process
    #[command(hide = true)]
    Sample(Sample),
}

impl Perf {
    pub(super) fn run(self) -> anyhow::Result<ExitCode> {
        match self.command {
            Command::Record(command) => command.run()?,
            Command::Compare(command) => return command.run(),
            Command::Show(command) => command.run()?,
            Command::Steps(command) => command.run()?,
            Command::Sample(command) => command.run()?,
        }
        Ok(ExitCode::SUCCESS)
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
        let names: Vec<String> = BENCHMARKS.iter().map(|benchmark| benchmark.name.to_owned()).collect();
        let plan = self.measuring.plan(&names)?;
        let provenance = Provenance::collect(&BUILD);
        let program = Program {
            path: std::env::current_exe().context("this program cannot find itself")?,
            git_revision: BUILD.git_revision.to_owned(),
            git_dirty: BUILD.git_dirty.to_owned(),
        };
        let rows = perf::record(&program, &provenance, &plan, &mut |benchmark| eprintln!("{benchmark}"))?;
        history.append(&rows)?;
        print(&steps_table(&rows.iter().collect::<Vec<_>>()))?;
        for row in rows.iter().filter(|row| !row.is_ok()) {
            eprintln!("note: {}: {}", row.benchmark, row.status);
        }
        let uneven: Vec<f64> =
            rows.iter().filter_map(|row| row.placebo().map(|[low, high]| (high / low).sqrt() - 1.0)).collect();
        if !uneven.is_empty() {
            let (median, worst) = (quantile(&uneven, 0.5), quantile(&uneven, 1.0));
            print(&format!(
                "placebo: this machine tells times apart to {:.1} % (median), {:.1} % (worst benchmark)",
                100.0 * median,
                100.0 * worst
            ))?;
        }
        let record = rows.first().map_or("nothing", |row| &row.record);
        print(&format!("record {record}: {} rows appended to {}", rows.len(), path.display()))
    }
}

/// Arguments of `perf show`.
#[derive(Debug, Args)]
struct Show {
    /// latest, previous, or digits of a record or git revision
    #[arg(value_name = "RECORD", default_value = "latest")]
    record: String,
    /// The history
    #[arg(long, value_name = "FILE", default_value = HISTORY)]
    history: PathBuf,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

impl Show {
    fn run(self) -> anyhow::Result<()> {
        let history = History::read(&self.history)?;
        let rows = history.of_record(history.select(&self.record)?);
        let [first, ..] = rows.as_slice() else { unreachable!("a record has rows") };
        if self.format == Format::Json {
            return print_json(&rows);
        }
        print(&format!(
            "record {}, revision {}, {}, {}, {}",
            first.record, first.git_revision, first.rustc, first.target, first.cpu
        ))?;
        print(&steps_table(&rows))
    }
}

/// Times per step of the rows that have times, instructions of all.
fn steps_table(rows: &[&Row]) -> String {
    let mut table = Table::new(&[
        "benchmark",
        "instructions",
        "time, ms",
        "ns per macro step",
        "ns per micro step",
        "est. flops per ns",
    ]);
    for row in rows {
        let per_step = PerStep::of(row);
        let number = |of: fn(&PerStep) -> Option<f64>, digits: usize| {
            per_step.as_ref().and_then(of).map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"))
        };
        table.add_row([
            row.benchmark.clone(),
            row.instructions.map_or_else(|| "–".to_owned(), |count| count.to_string()),
            row.wall_s.map_or_else(|| row.status.clone(), |wall| format!("{:.3}", 1e3 * wall)),
            number(|row| row.macro_step_ns, 0),
            number(|row| row.micro_step_ns, 0),
            number(|row| row.flops_per_ns, 2),
        ]);
    }
    table.to_string()
}

/// Arguments of `perf steps`.
#[derive(Debug, Args)]
struct Steps {
    /// The history
    #[arg(long, value_name = "FILE", default_value = HISTORY)]
    history: PathBuf,
}

impl Steps {
    fn run(self) -> anyhow::Result<()> {
        let found = history_steps(&History::read(&self.history)?);
        let mut table = Table::new(&["from revision", "to revision", "record", "benchmark", "of", "ratio"]);
        for step in &found {
            let ratio = format!("{:.4}", step.ratio);
            table.add_row([&step.before, &step.revision, &step.record, &step.benchmark, step.quantity, &ratio]);
        }
        print(&format!("{table}\n{} steps in {}", found.len(), self.history.display()))
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
    /// Without clock and yardstick, for counting instructions
    #[arg(long)]
    untimed: bool,
}

impl Sample {
    fn run(self) -> anyhow::Result<()> {
        let Some(name) = self.benchmark.filter(|_| !self.list) else {
            let names: Vec<&str> = BENCHMARKS.iter().map(|benchmark| benchmark.name).collect();
            return print(&serde_json::to_string(&names)?);
        };
        let sample = perf::measure(benchmark_by_name(&name)?, self.repetitions, !self.untimed, &BUILD)?;
        print(&serde_json::to_string(&sample)?)
    }
}
