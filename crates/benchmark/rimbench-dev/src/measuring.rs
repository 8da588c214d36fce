//! A record of this program: counters by running the suite here, instructions by running it under callgrind.

use super::benchmark::Benchmark;
use super::history::{COUNTERS, Row};
use rimbench_core::error::{Error, Result};
use rimbench_harness::{BuildInfo, Provenance};
use rimbench_results::checksums::sha256;
use std::path::Path;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// Records benchmarks in a program built like this, now; with `program`, which is this one, also their instructions. A wrong answer has no
/// measurements. `told` hears of each benchmark before it is measured.
///
/// # Errors
/// Those of the benchmarks and of the program under valgrind.
pub fn record(
    benchmarks: &[&Benchmark],
    program: Option<&Path>,
    build: &BuildInfo,
    told: impl Fn(&str),
) -> Result<Vec<Row>> {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let cpu = Provenance::collect(build).cpu;
    let key = format!("{}\n{cpu}\n{}\n{}", build.git_revision, now.as_nanos(), std::process::id());
    let all = Row {
        record: sha256(&key)[..8].to_owned(),
        recorded_at_unix_s: now.as_secs(),
        git_revision: build.git_revision.to_owned(),
        git_dirty: build.git_dirty.to_owned(),
        rustc: build.rustc.to_owned(),
        target: build.target.to_owned(),
        cpu,
        build: build.settings.to_owned(),
        ..Row::default()
    };
    let row = |benchmark: &&Benchmark| {
        told(benchmark.name);
        let (fault, counters) = measure(benchmark)?;
        let counted = program.filter(|_| fault.is_none());
        let instructions = counted.map(|program| instructions(program, benchmark.name)).transpose()?;
        let (benchmark, status) = (benchmark.name.to_owned(), fault.unwrap_or_else(|| "ok".to_owned()));
        Ok(Row { benchmark, status, counters, instructions, ..all.clone() })
    };
    benchmarks.iter().map(row).collect()
}

/// Does one repetition of a benchmark: what is wrong with its answer, if anything, and its counters.
///
/// # Errors
/// Those of preparing or running the benchmark.
pub fn measure(benchmark: &Benchmark) -> Result<(Option<String>, [u64; COUNTERS.len()])> {
    let work = benchmark.prepare()?()?;
    Ok((benchmark.fault(work.answer), work.counters()))
}

/// Tells whether valgrind can be started.
///
/// # Errors
/// Why not, in words: a note, not a failure.
pub fn find_valgrind() -> std::result::Result<(), String> {
    match Command::new("valgrind").arg("--version").output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(_) => Err("valgrind --version fails: no instruction counts".to_owned()),
        Err(error) => Err(format!("valgrind is not there ({error}): no instruction counts")),
    }
}

/// Counts the instructions of one repetition: the process with two repetitions, minus the process with one, so that start, preparation and
/// first touch drop out.
fn instructions(program: &Path, benchmark: &str) -> Result<u64> {
    let wrong = |what: &dyn std::fmt::Display| Error::file("valgrind", format!("callgrind of {benchmark}: {what}"));
    let folder = tempfile::tempdir().map_err(|error| wrong(&error))?;
    let out = folder.path().join("callgrind.out");
    let total = |repetitions: &str| {
        let mut command = Command::new("valgrind");
        command.arg("--tool=callgrind").arg(format!("--callgrind-out-file={}", out.display())).arg(program);
        let sample = command.args(["perf", "sample", benchmark, "--repetitions", repetitions]).output();
        let output = sample.map_err(|error| wrong(&error))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            return Err(wrong(&said.lines().next_back().unwrap_or("failed without a word")));
        }
        let text = std::fs::read_to_string(&out).map_err(|error| wrong(&error))?;
        parse_total(&text).ok_or_else(|| wrong(&"no total in its output"))
    };
    let (one, two) = (total("1")?, total("2")?);
    let count = two.checked_sub(one).filter(|count| *count > 0);
    count.ok_or_else(|| wrong(&format!("{two} instructions with two repetitions, {one} with one")))
}

/// Reads the total from a callgrind output file (`totals:`, in older versions `summary:`).
fn parse_total(text: &str) -> Option<u64> {
    let value = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.trim().parse().ok());
    value("totals:").or_else(|| value("summary:"))
}
