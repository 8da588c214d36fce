//! One measurement, by a program in a process of its own: this program, or the same suite of another revision.

use super::benchmark::Benchmark;
use super::history::{COUNTERS, Row};
use rimbench_core::error::{Error, Result};
use rimbench_harness::{BuildInfo, Provenance, monotonic_clock};
use rimbench_results::checksums::sha256;
use rimbench_statistics::TimeSummary;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// What `rimbench perf sample` prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// `ok`, or what is wrong with the answer.
    pub status: String,
    /// Compiler that built the program.
    pub rustc: String,
    /// Its target.
    pub target: String,
    /// Counters by name.
    pub counters: Vec<(String, u64)>,
    /// Wall time of the last repetition, s.
    pub wall_s: f64,
}

/// Measures one benchmark here and now, in a program built like this. The first of several repetitions warms up; the last counts.
///
/// # Errors
/// Those of preparing or running the benchmark.
pub fn measure(benchmark: &Benchmark, repetitions: u32, build: &BuildInfo) -> Result<Sample> {
    let mut repetition = benchmark.prepare()?;
    let (status, [rustc, target]) = ("ok".to_owned(), [build.rustc, build.target].map(str::to_owned));
    let mut sample = Sample { status, rustc, target, counters: Vec::new(), wall_s: 0.0 };
    for _ in 0..repetitions {
        let begun = monotonic_clock();
        let work = repetition()?;
        sample.wall_s = (monotonic_clock() - begun).as_secs_f64();
        sample.status = benchmark.fault(work.answer).unwrap_or_else(|| "ok".to_owned());
        let counts = [
            work.macro_steps,
            work.mechanics_micro_steps,
            work.actuator_micro_steps,
            work.eliminations,
            work.lcp.solves,
            work.lcp.pivots,
            work.lcp.factorisations,
            work.lcp.fallbacks,
        ];
        sample.counters = COUNTERS.map(str::to_owned).into_iter().zip(counts).collect();
    }
    Ok(sample)
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
        let text = said(&self.path, Command::new(&self.path).args(arguments))?;
        serde_json::from_slice(&text)
            .map_err(|error| Error::file(&self.path, format!("`{}`: {error}", arguments.join(" "))))
    }
}

/// What a command prints.
fn said(path: &Path, command: &mut Command) -> Result<Vec<u8>> {
    let output = command.output();
    let wrong = |what: &str| {
        let arguments: Vec<_> = command.get_args().map(|word| word.to_string_lossy().into_owned()).collect();
        Error::file(path, format!("`{}`: {what}", arguments.join(" ")))
    };
    let output = output.map_err(|error| wrong(&error.to_string()))?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr);
        return Err(wrong(message.lines().next_back().unwrap_or("failed without a word")));
    }
    Ok(output.stdout)
}

/// Exact counts of instructions by valgrind's callgrind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Instructions(());

impl Instructions {
    /// Tells whether valgrind can be started.
    ///
    /// # Errors
    /// Why not, in words: a note, not a failure.
    pub fn find() -> std::result::Result<Self, String> {
        match Command::new("valgrind").arg("--version").output() {
            Ok(output) if output.status.success() => Ok(Instructions(())),
            Ok(_) => Err("valgrind --version fails: no instruction counts".to_owned()),
            Err(error) => Err(format!("valgrind is not there ({error}): no instruction counts")),
        }
    }

    /// Counts the instructions of one repetition: the process with two repetitions, minus the process with one, so that start,
    /// preparation and first touch drop out.
    fn count(self, program: &Path, benchmark: &str) -> Result<u64> {
        let wrong = |what: &dyn std::fmt::Display| Error::file("valgrind", format!("callgrind of {benchmark}: {what}"));
        let folder = tempfile::tempdir().map_err(|error| wrong(&error))?;
        let out = folder.path().join("callgrind.out");
        let total = |repetitions: &str| {
            let mut command = Command::new("valgrind");
            command.arg("--tool=callgrind").arg(format!("--callgrind-out-file={}", out.display())).arg(program);
            said("valgrind".as_ref(), command.args(["perf", "sample", benchmark, "--repetitions", repetitions]))?;
            let text = std::fs::read_to_string(&out).map_err(|error| wrong(&error))?;
            parse_total(&text).ok_or_else(|| wrong(&"no total in its output"))
        };
        let (one, two) = (total("1")?, total("2")?);
        let count = two.checked_sub(one).filter(|count| *count > 0);
        count.ok_or_else(|| wrong(&format!("{two} instructions with two repetitions, {one} with one")))
    }
}

/// Reads the total from a callgrind output file (`totals:`, in older versions `summary:`).
fn parse_total(text: &str) -> Option<u64> {
    let value = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.trim().parse().ok());
    value("totals:").or_else(|| value("summary:"))
}

/// Measured times of one round, the programs one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Round {
    /// The base.
    pub base: Sample,
    /// What it is compared with, between the two of the base.
    pub new: Sample,
    /// The base again, as if it were another program.
    placebo: Sample,
}

/// Measures a benchmark in interleaved rounds `base, new, base`, every other round in reverse order.
///
/// # Errors
/// Those of the programs.
pub fn measure_rounds(base: &Program, new: &Program, benchmark: &str, rounds: u32) -> Result<Vec<Round>> {
    let one = |round: u32| {
        let (first, new, last) = (base.sample(benchmark)?, new.sample(benchmark)?, base.sample(benchmark)?);
        let (base, placebo) = if round.is_multiple_of(2) { (first, last) } else { (last, first) };
        Ok(Round { base, new, placebo })
    };
    (0..rounds).map(one).collect()
}

impl Round {
    /// Ratio of the times of `new` to the base, whose time is the geometric mean of its two: a linear drift drops out.
    pub fn ratio(rounds: &[Round]) -> Option<TimeSummary> {
        let pair = |round: &Round| (round.new.wall_s, (round.base.wall_s * round.placebo.wall_s).sqrt());
        TimeSummary::of(&rounds.iter().map(pair).collect::<Vec<_>>())
    }

    /// Ratio of the base to itself: the machine's noise.
    pub fn placebo(rounds: &[Round]) -> Option<TimeSummary> {
        TimeSummary::of(&rounds.iter().map(|round| (round.placebo.wall_s, round.base.wall_s)).collect::<Vec<_>>())
    }
}

/// What all rows of a record have in common.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recording {
    record: String,
    recorded_at_unix_s: u64,
    program: Program,
    cpu: String,
    instructions: Option<Instructions>,
}

impl Recording {
    /// Begins a record of a program, here and now.
    pub fn begin(program: &Program, provenance: &Provenance, instructions: Option<Instructions>) -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let cpu = provenance.cpu.clone();
        let key = format!("{}\n{cpu}\n{}\n{}", program.git_revision, now.as_nanos(), std::process::id());
        let record = sha256(&key)[..8].to_owned();
        Recording { record, recorded_at_unix_s: now.as_secs(), program: program.clone(), cpu, instructions }
    }

    /// The row of one benchmark from its sample, with its instructions; a wrong answer has no measurements.
    ///
    /// # Errors
    /// Those of the program under valgrind.
    pub fn row(&self, benchmark: &str, sample: &Sample) -> Result<Row> {
        let count = |name: &str| sample.counters.iter().find(|(known, _)| known == name).map_or(0, |(_, count)| *count);
        let counted = self.instructions.filter(|_| sample.status == "ok");
        Ok(Row {
            record: self.record.clone(),
            recorded_at_unix_s: self.recorded_at_unix_s,
            git_revision: self.program.git_revision.clone(),
            git_dirty: self.program.git_dirty.clone(),
            rustc: sample.rustc.clone(),
            target: sample.target.clone(),
            cpu: self.cpu.clone(),
            benchmark: benchmark.to_owned(),
            status: sample.status.clone(),
            counters: COUNTERS.map(count),
            instructions: counted.map(|valgrind| valgrind.count(&self.program.path, benchmark)).transpose()?,
        })
    }
}

#[test]
fn the_total_is_read_from_either_line() {
    assert_eq!(parse_total("events: Ir\nsummary: 7\nfn=x\n\ntotals: 1234\n"), Some(1234));
    assert_eq!(parse_total("events: Ir\nsummary: 7\n"), Some(7));
    assert_eq!(parse_total("events: Ir\n"), None);
}
