//! One measurement, by a program in a process of its own: this program, or the same suite of another revision.

use super::benchmark::Benchmark;
use super::fixed_work::fixed_work;
use rimbench_core::error::{Error, Result};
use rimbench_harness::BuildInfo;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

/// What `rimbench perf sample` prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// `ok`, or what is wrong with the answer.
    pub status: String,
    /// Compiler that built the program.
    pub rustc: String,
    /// Its target.
    pub target: String,
    /// Counters by name, the flop estimate last.
    pub counters: Vec<(String, u64)>,
    /// Wall time of the last repetition, s; 0 without repetitions.
    pub wall_s: f64,
    /// Mean wall time of the fixed work before and after, s; 0 if it was left out.
    pub fixed_work_s: f64,
}

/// Measures one benchmark here and now, in a program built like this.
///
/// The first of several repetitions warms up; the last is timed, between two pieces of fixed work.
///
/// # Errors
/// Those of preparing or running the benchmark.
pub fn measure(benchmark: &Benchmark, repetitions: u32, timed: bool, build: &BuildInfo) -> Result<Sample> {
    let mut repetition = (benchmark.prepare)()?;
    let mut sample = Sample {
        status: "ok".to_owned(),
        rustc: build.rustc.to_owned(),
        target: build.target.to_owned(),
        counters: Vec::new(),
        wall_s: 0.0,
        fixed_work_s: 0.0,
    };
    for number in 1..=repetitions {
        let last = timed && number == repetitions;
        let before = if last { time(|| Ok(fixed_work()))?.1 } else { 0.0 };
        let (work, wall) = time(&mut repetition)?;
        let after = if last { time(|| Ok(fixed_work()))?.1 } else { 0.0 };
        (sample.wall_s, sample.fixed_work_s) = (wall, 0.5 * (before + after));
        sample.status = benchmark.fault(work.answer).unwrap_or_else(|| "ok".to_owned());
        let counters = [
            ("macro_steps", work.macro_steps),
            ("mechanics_micro_steps", work.mechanics_micro_steps),
            ("actuator_micro_steps", work.actuator_micro_steps),
            ("eliminations", work.eliminations),
            ("lcp_solves", work.lcp.solves),
            ("lcp_pivots", work.lcp.pivots),
            ("lcp_factorisations", work.lcp.factorisations),
            ("lcp_fallbacks", work.lcp.fallbacks),
            ("flops_estimate", work.flops_estimate),
        ];
        sample.counters = counters.map(|(name, count)| (name.to_owned(), count)).to_vec();
    }
    Ok(sample)
}

fn time<T>(work: impl FnOnce() -> Result<T>) -> Result<(T, f64)> {
    let started = Instant::now();
    let done = work()?;
    Ok((done, started.elapsed().as_secs_f64()))
}

impl Sample {
    /// A counter by name; 0 if the program did not know it.
    pub fn counter(&self, name: &str) -> u64 {
        self.counters.iter().find(|(known, _)| known == name).map_or(0, |(_, count)| *count)
    }
}

/// A program that holds the suite.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Program {
    /// Where it is.
    pub path: PathBuf,
    /// Git revision it was built from.
    pub git_revision: String,
    /// Whether that is all of its source.
    pub git_dirty: String,
}

impl Program {
    /// Names of its benchmarks.
    ///
    /// # Errors
    /// [`Error::File`] if the program cannot be started or is too old to have a suite.
    pub fn benchmarks(&self) -> Result<Vec<String>> {
        self.json(&["perf", "sample", "--list"])
    }

    /// Lets it measure one benchmark: once to warm up, once timed.
    ///
    /// # Errors
    /// [`Error::File`] if it fails.
    pub fn sample(&self, benchmark: &str) -> Result<Sample> {
        self.json(&["perf", "sample", benchmark, "--repetitions", "2"])
    }

    fn json<T: for<'a> Deserialize<'a>>(&self, arguments: &[&str]) -> Result<T> {
        let wrong = |what: &str| {
            let revision = &self.git_revision;
            Error::file(&self.path, format!("`{}` of revision {revision}: {what}", arguments.join(" ")))
        };
        let output = Command::new(&self.path).args(arguments).output().map_err(|error| wrong(&error.to_string()))?;
        if !output.status.success() {
            let message = String::from_utf8_lossy(&output.stderr);
            return Err(wrong(message.lines().next().unwrap_or("failed without a word")));
        }
        serde_json::from_slice(&output.stdout).map_err(|error| wrong(&error.to_string()))
    }
}
