//! `rimbench perf`: has the program become slower?

use super::perf_compare::Compare;
use super::perf_measuring::{HISTORY, Measuring};
use super::print;
use super::screen::Table;
use anyhow::Context;
use clap::{Args, Subcommand};
use rimbench::BUILD;
use rimbench::atomic_file::{check_writable_file, check_writable_folder};
use rimbench::harness::Provenance;
use rimbench::perf::{self, BENCHMARKS, History, Program, Row, benchmark_by_name};
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
        print(&rows_table(&rows))?;
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

/// Times of the rows that have them, instructions of all.
fn rows_table(rows: &[Row]) -> String {
    let mut table = Table::new(&["benchmark", "instructions", "time, ms"]);
    for row in rows {
        table.add_row([
            row.benchmark.clone(),
            row.instructions.map_or_else(|| "–".to_owned(), |count| count.to_string()),
            row.wall_s.map_or_else(|| row.status.clone(), |wall| format!("{:.3}", 1e3 * wall)),
        ]);
    }
    table.to_string()
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
    /// Without clock and fixed work, for counting instructions
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
