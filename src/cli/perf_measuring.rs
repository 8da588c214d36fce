//! How to measure, and where the history of measurements is.

use clap::Args;
use rimbench::error::Error;
use rimbench::perf::{Plan, callgrind};
use std::path::PathBuf;

/// How to measure, shared by `record` and `compare --rev`.
#[derive(Debug, Args)]
pub(super) struct Measuring {
    /// Only this benchmark; may be repeated
    #[arg(long = "benchmark", value_name = "NAME")]
    benchmarks: Vec<String>,
    /// Rounds of the wall times; 0 measures none
    #[arg(long, value_name = "N", default_value = "12")]
    pub(super) rounds: u32,
    /// Program that counts instructions
    #[arg(long, value_name = "FILE", default_value = "valgrind")]
    valgrind: PathBuf,
    /// Do not count instructions
    #[arg(long)]
    without_instructions: bool,
}

impl Measuring {
    /// The plan, from the benchmarks there are. Says so if valgrind is missing.
    pub(super) fn plan(&self, known: &[String]) -> anyhow::Result<Plan> {
        for name in &self.benchmarks {
            if !known.contains(name) {
                return Err(Error::unknown("benchmark", name, known.iter().map(String::as_str)).into());
            }
        }
        if self.rounds == 1 {
            return Err(Error::invalid("--rounds", self.rounds, "0, or at least 2: one round has no spread").into());
        }
        let benchmarks = if self.benchmarks.is_empty() { known.to_vec() } else { self.benchmarks.clone() };
        let valgrind = match callgrind::find(&self.valgrind) {
            _ if self.without_instructions => None,
            Ok(()) => Some(self.valgrind.clone()),
            Err(note) => {
                eprintln!("note: {note}");
                None
            }
        };
        Ok(Plan { benchmarks, rounds: self.rounds, valgrind })
    }
}

/// Where the history is kept, below the current folder.
pub(super) const HISTORY: &str = "results/perf/history.csv";
