//! One file per subcommand.

mod collect;
mod corpus;
mod figures;
mod limit;
mod list;
mod perf;
mod perf_compare;
mod plan;
mod progress;
mod reproduce;
mod run;
mod run_options;
mod simulate;
mod solvers;
mod verify;

use clap::{Parser, Subcommand, ValueEnum};
use rimbench::everything;
use rimbench::harness::{Cache, CheckedClaim, Verdict};
use rimbench::runs::FactValue;
use std::process::ExitCode;

/// Benchmark of non-iterative co-simulation of mechanical systems with contact.
#[derive(Debug, Parser)]
#[command(name = "rimbench", version, about, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Reproduce the source paper's figures and claims, from nothing
    Reproduce(reproduce::Reproduce),
    /// Draw all figures whose results exist, and name the others
    Figures(figures::Figures),
    /// Run one co-simulation and print its outcome, metrics and counters
    Simulate(simulate::Simulate),
    /// Print the runs of an experiment file without running them
    Plan(plan::Plan),
    /// Run what is missing of an experiment
    Run(run::Run),
    /// Merge the shards of an experiment, and list what is missing
    Collect(collect::Collect),
    /// Check the claims of experiments against their stored results
    Verify(verify::Verify),
    /// Find the largest stable macro step of a scheme on a case
    Limit(limit::Limit),
    /// Record the program's own performance, and compare records or git revisions
    Perf(perf::Perf),
    /// List what there is, by name
    List(list::List),
    /// Harvest the contact problems of actual runs into a file
    Corpus(corpus::CorpusCommand),
    /// Give the corpus of contact problems to every solver and compare
    Solvers(solvers::Solvers),
}

/// Width of the printed table of claims, characters.
const TABLE_WIDTH: u16 = 120;

/// How to print.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For reading.
    Table,
    /// For programs.
    Json,
}

impl Cli {
    /// Runs the chosen command and says with which code to exit.
    ///
    /// # Errors
    /// Bad input, or a place that cannot be written.
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let catalogue = &everything()?;
        match self.command {
            Command::Reproduce(command) => command.run(catalogue)?,
            Command::Simulate(command) => command.run(catalogue)?,
            Command::Plan(command) => command.run(catalogue)?,
            Command::Run(command) => return command.run(catalogue),
            Command::Collect(command) => command.run(catalogue)?,
            Command::Verify(command) => return command.run(catalogue),
            Command::Limit(command) => command.run(catalogue)?,
            Command::Figures(command) => command.run(catalogue)?,
            Command::Perf(command) => return command.run(),
            Command::List(command) => command.run(catalogue)?,
            Command::Corpus(command) => command.run()?,
            Command::Solvers(command) => command.run(catalogue)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// A number for JSON, which knows no infinities: those become the text `inf`, `-inf` or `nan`.
fn json_number(value: f64) -> serde_json::Value {
    serde_json::Number::from_f64(value).map_or_else(|| format!("{value}").to_lowercase().into(), Into::into)
}

/// What a fact says, for JSON.
fn json_fact(value: Option<&FactValue>) -> serde_json::Value {
    match value {
        None => serde_json::Value::Null,
        Some(FactValue::Text(text)) => text.as_str().into(),
        Some(FactValue::Number(number)) => json_number(*number),
        Some(FactValue::Count(count)) => (*count).into(),
    }
}

/// Prints to standard output; a reader that closed the pipe early is no error.
fn print(text: &str) -> anyhow::Result<()> {
    use std::io::{ErrorKind, Write};
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => Ok(result?),
    }
}

/// Says what is wrong with the cache of references, if anything is: without it every command computes them anew.
fn complain(cache: &Cache) {
    if let Some(error) = cache.complaint() {
        eprintln!("note: the cache of references is of no use here: {error}");
    }
}

/// An empty table in the style of all tables.
fn table(header: &[&str]) -> comfy_table::Table {
    let mut table = comfy_table::Table::new();
    table
        .load_preset(comfy_table::presets::UTF8_HORIZONTAL_ONLY)
        .remove_style(comfy_table::TableComponent::HorizontalLines)
        .remove_style(comfy_table::TableComponent::MiddleIntersections)
        .set_header(header.iter().copied());
    table
}

/// Claims with what was measured.
fn claims_table(claims: &[CheckedClaim]) -> String {
    let mut table = table(&["claim", "by", "measured", "expected", "verdict"]);
    for claim in claims {
        let measured = claim.measured.map_or("–".to_owned(), |value| format!("{value:.4}"));
        let changed = match claim.finding {
            _ if claim.differs() => " (differs from the recorded finding)",
            Verdict::NotMeasured if claim.verdict != Verdict::NotMeasured => " (no finding is recorded yet)",
            _ => "",
        };
        let by = format!("{:?}", claim.by).to_lowercase();
        let verdict = format!("{}{changed}", claim.verdict);
        table.add_row([format!("{}: {}", claim.text, claim.quantity), by, measured, claim.expected.clone(), verdict]);
    }
    table.set_content_arrangement(comfy_table::ContentArrangement::Dynamic).set_width(TABLE_WIDTH);
    table.to_string()
}
