//! `rimbench perf`: has the program become slower?

use super::number::counted;
use super::screen::Table;
use super::{Format, print, print_json, program};
use anyhow::Context;
use clap::{Args, Subcommand};
use rimbench::BUILD;
use rimbench::atomic_file::{check_writable_file, check_writable_folder};
use rimbench::catalogue::Catalogue;
use rimbench::error::Error;
use rimbench::harness::Experiment;
use rimbench::name::find_by_name;
use rimbench::perf::{
    BENCHMARKS, Benchmark, Build, ChangedFunction, Comparison, Finding, History, Verdict, compare, compare_revisions,
    fence_of, find_valgrind, record,
};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::path::{Path, PathBuf, absolute};
use std::process::ExitCode;

/// Arguments of `perf`.
#[derive(Debug, Args)]
pub struct Perf {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the fixed suite, or that of a file, and append its counters and instructions to the history
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
        /// Where it is not of the fixed suite
        #[arg(long, value_name = "FILE.toml")]
        suite: Option<PathBuf>,
    },
}

impl Perf {
    pub(super) fn run(self, catalogue: &Catalogue, code: Option<&str>) -> anyhow::Result<ExitCode> {
        match self.command {
            Command::Record(command) => command.record(catalogue, code)?,
            Command::Compare(command) => return command.run(),
            Command::Sample { benchmark, repetitions, suite } => {
                let suite = suite_of(suite.as_deref(), catalogue)?;
                let mut repetition = named_in(&suite, &benchmark)?.prepare()?;
                (0..repetitions).try_for_each(|_| repetition().map(drop))?;
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// The runs that a file names, or the fixed suite.
fn suite_of(file: Option<&Path>, catalogue: &Catalogue) -> Result<Cow<'static, [Benchmark]>, Error> {
    let Some(file) = file else { return Ok(BENCHMARKS.into()) };
    let runs = Experiment::read(file)?.measured_runs(catalogue)?;
    Ok(runs.into_iter().map(Benchmark::of_run).collect())
}

fn named_in<'a>(suite: &'a [Benchmark], name: &str) -> Result<&'a Benchmark, Error> {
    find_by_name("benchmark", suite, |entry| &entry.name, name)
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
    /// Runs of your own: those that [perf] of an experiment file names
    #[arg(long, value_name = "FILE.toml")]
    suite: Option<PathBuf>,
    /// Do not count instructions
    #[arg(long)]
    without_instructions: bool,
}

impl Measuring {
    /// The options by which another process of this program has the same suite.
    fn suite_options(&self) -> anyhow::Result<Vec<String>> {
        let file = self.suite.as_deref().map(absolute).transpose().context("the current folder is not known")?;
        Ok(file.map(|file| format!("--suite={}", file.display())).into_iter().collect())
    }

    /// `code` is the digest of what was added to the catalogue, if anything was.
    fn record(self, catalogue: &Catalogue, code: Option<&str>) -> anyhow::Result<()> {
        let options = self.suite_options()?;
        let Measuring { history: path, benchmarks, without_instructions, suite } = self;
        // A damaged history or a place that cannot be written is found before minutes of measuring.
        path.exists().then(|| History::read(&path)).transpose()?;
        check_writable_folder(path.parent().unwrap_or(Path::new(".")))?;
        check_writable_file(&path)?;
        let suite = suite_of(suite.as_deref(), catalogue)?;
        let named = benchmarks.iter().map(|name| named_in(&suite, name)).collect::<Result<Vec<&Benchmark>, Error>>()?;
        let benchmarks = if named.is_empty() { suite.iter().collect() } else { named };
        let program = std::env::current_exe().context("this program cannot find itself")?;
        let counts = !without_instructions && find_valgrind().inspect_err(|note| eprintln!("note: {note}")).is_ok();
        let program = counts.then_some((&*program, &*options));
        let mut rows = record(&benchmarks, program, &BUILD, super::progress::say)?;
        // Two programs of one revision of rimbench, with other code of its user, are two.
        rows.iter_mut().for_each(|row| row.git_revision.extend(code.map(|code| format!("+{code}"))));
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
                let suite = self.measuring.suite_options()?;
                let Measuring { benchmarks, without_instructions, .. } = self.measuring;
                let mut options: Vec<String> = benchmarks.iter().map(|name| format!("--benchmark={name}")).collect();
                options.extend(without_instructions.then(|| "--without-instructions".to_owned()));
                let build = Build {
                    folder: &std::env::current_dir()?,
                    program: program(),
                    depends_on: &format!("{} {}", BUILD.git_revision, BUILD.git_dirty),
                    options: &options,
                    suite: &suite,
                };
                compare_revisions(build, [base, new])?
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
