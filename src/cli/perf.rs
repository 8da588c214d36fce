//! `rimbench perf`: has the program become slower?

use super::number::counted;
use super::screen::Table;
use super::{Format, print, print_json};
use anyhow::Context;
use clap::{Args, Subcommand};
use rimbench::BUILD;
use rimbench::atomic_file::{check_writable_file, check_writable_folder};
use rimbench::error::Error;
use rimbench::perf::{
    BENCHMARKS, Benchmark, ChangedFunction, Comparison, Finding, History, Verdict, benchmark_by_name, compare,
    compare_revisions, fence_of, find_valgrind, record,
};
use serde_json::{Value, json};
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
    /// Run the fixed suite and append its counters and instructions to the history
    Record(Measuring),
    /// Compare two records, or two git revisions (--rev A --rev B); exit code 1 on a regression
    Compare(Compare),
    /// Do one benchmark in this process
    #[command(hide = true)]
    Sample {
        /// Name in the suite
        benchmark: String,
        /// How often
        #[arg(long, default_value = "1")]
        repetitions: u32,
    },
}

impl Perf {
    pub(super) fn run(self) -> anyhow::Result<ExitCode> {
        match self.command {
            Command::Record(command) => command.record()?,
            Command::Compare(command) => return command.run(),
            Command::Sample { benchmark, repetitions } => {
                let mut repetition = benchmark_by_name(&benchmark)?.prepare()?;
                (0..repetitions).try_for_each(|_| repetition().map(drop))?;
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// What to measure, and where it is kept.
#[derive(Debug, Args)]
struct Measuring {
    /// The history
    #[arg(long, value_name = "FILE", default_value = "results/perf/history.csv")]
    history: PathBuf,
    /// Only this benchmark; may be repeated
    #[arg(long = "benchmark", value_name = "NAME")]
    benchmarks: Vec<String>,
    /// Do not count instructions
    #[arg(long)]
    without_instructions: bool,
}

impl Measuring {
    fn record(self) -> anyhow::Result<()> {
        let Measuring { history: path, benchmarks, without_instructions } = self;
        // A damaged history or a place that cannot be written is found before minutes of measuring.
        path.exists().then(|| History::read(&path)).transpose()?;
        check_writable_folder(path.parent().unwrap_or(Path::new(".")))?;
        check_writable_file(&path)?;
        let named =
            benchmarks.iter().map(|name| benchmark_by_name(name)).collect::<Result<Vec<&Benchmark>, Error>>()?;
        let benchmarks = if named.is_empty() { BENCHMARKS.iter().collect() } else { named };
        let program = std::env::current_exe().context("this program cannot find itself")?;
        let counts = !without_instructions && find_valgrind().inspect_err(|note| eprintln!("note: {note}")).is_ok();
        let rows = record(&benchmarks, counts.then_some(&*program), &BUILD, super::progress::say)?;
        History::append(&path, &rows)?;
        let mut table = Table::new(&["benchmark", "instructions", "status"]);
        for row in &rows {
            let count = row.instructions.map_or_else(|| "–".to_owned(), |count| count.to_string());
            table.add_row([&row.benchmark, &count, &row.status]);
        }
        print(&table.to_string())?;
        print(&format!("record {}: {} appended to {}", rows[0].record, counted(rows.len(), "row"), path.display()))
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
    /// A git revision to build and record; given twice, first the base
    #[arg(long, value_name = "REV")]
    rev: Vec<String>,
    /// How to print; JSON has every quantity that was compared
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    #[command(flatten)]
    measuring: Measuring,
}

impl Compare {
    fn run(self) -> anyhow::Result<ExitCode> {
        let comparison = match (&self.base, &self.new, self.rev.as_slice()) {
            (Some(base), Some(new), _) => {
                let history = History::read(&self.measuring.history)?;
                let (base, new) = (history.select(base)?, history.select(new)?);
                compare(&base, &new, fence_of(&base, &new))?
            }
            (.., [base, new]) => {
                // Interrupted, the compiler ends by itself, and what was checked out is removed.
                let _ = ctrlc::set_handler(|| {});
                let Measuring { benchmarks, without_instructions, .. } = self.measuring;
                let mut options: Vec<String> = benchmarks.iter().map(|name| format!("--benchmark={name}")).collect();
                options.extend(without_instructions.then(|| "--without-instructions".to_owned()));
                compare_revisions(&std::env::current_dir()?, [base, new], &options)?
            }
            _ => return Err(Error::invalid("--rev", self.rev.join(" "), "two revisions: --rev BASE --rev NEW").into()),
        };
        match self.format {
            Format::Table => print(&comparison.to_string())?,
            Format::Json => print_json(&facts(&comparison))?,
        }
        Ok(if comparison.regressions().is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}

fn facts(comparison: &Comparison) -> Value {
    let finding = |Finding { benchmark, quantity, counts: [base, new], verdict }: &Finding| {
        let verdict = match verdict {
            Verdict::Same => "same",
            Verdict::Improved => "improved",
            Verdict::Regressed => "regressed",
            Verdict::Traded => "traded",
        };
        json!({ "benchmark": benchmark, "quantity": quantity, "base": base, "new": new, "verdict": verdict })
    };
    let function = |(benchmark, ChangedFunction { name, counts: [base, new] }): &(String, ChangedFunction)| json!({ "benchmark": benchmark, "function": name, "base": base, "new": new });
    json!({
        "base": comparison.records[0],
        "new": comparison.records[1],
        "findings": comparison.findings.iter().map(finding).collect::<Vec<_>>(),
        "functions": comparison.functions.iter().map(function).collect::<Vec<_>>(),
        "notes": comparison.notes,
        "regressions": comparison.regressions(),
    })
}
