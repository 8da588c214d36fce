//! A record of this program: counters by running the suite here, instructions by running it under callgrind.

use super::benchmark::Benchmark;
use super::history::{COUNTERS, Row};
use rimbench_core::error::{Error, Result};
use rimbench_harness::{BuildInfo, Provenance};
use rimbench_results::checksums::sha256;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// Records benchmarks in a program built like this, now; with `program`, which is this one, and the options by which it
/// knows them, also their instructions. A wrong answer has no measurements. `told` hears of each benchmark before it is
/// measured.
///
/// # Errors
/// Those of the benchmarks and of the program under valgrind.
pub fn record(
    benchmarks: &[&Benchmark],
    program: Option<(&Path, &[String])>,
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
        told(&benchmark.name);
        let (fault, counters) = measure(benchmark)?;
        let counted = program.filter(|_| fault.is_none());
        let instructions = counted.map(|program| instructions(program, &benchmark.name)).transpose()?;
        let (benchmark, status) = (benchmark.name.to_string(), fault.unwrap_or_else(|| "ok".to_owned()));
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

/// Counts the instructions of one repetition: the process with two repetitions, minus the process with one, so that
/// start, preparation and first touch drop out.
fn instructions(program: (&Path, &[String]), benchmark: &str) -> Result<u64> {
    let [one, two] = profiles(program, benchmark)?.map(|profile| parse_total(&profile));
    let wrong = |what: &str| Error::file("valgrind", format!("callgrind of {benchmark}: {what}"));
    let (one, two) = one.zip(two).ok_or_else(|| wrong("no total in its output"))?;
    let count = two.checked_sub(one).filter(|count| *count > 0);
    count.ok_or_else(|| wrong(&format!("{two} instructions with two repetitions, {one} with one")))
}

/// What callgrind says of one repetition of a benchmark in a program, and of two.
///
/// # Errors
/// [`Error::File`] naming valgrind, for a program that fails under it.
pub(super) fn profiles((program, options): (&Path, &[String]), benchmark: &str) -> Result<[String; 2]> {
    let wrong = |what: &dyn std::fmt::Display| Error::file("valgrind", format!("callgrind of {benchmark}: {what}"));
    let folder = tempfile::tempdir().map_err(|error| wrong(&error))?;
    let out = folder.path().join("callgrind.out");
    let profile = |repetitions: &str| {
        let mut command = Command::new("valgrind");
        command.arg("--tool=callgrind").arg(format!("--callgrind-out-file={}", out.display())).arg(program);
        let sample = command.args(["perf", "sample", benchmark, "--repetitions", repetitions]).args(options).output();
        let output = sample.map_err(|error| wrong(&error))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            return Err(wrong(&said.lines().next_back().unwrap_or("failed without a word")));
        }
        let text = std::fs::read(&out).map_err(|error| wrong(&error))?;
        Ok(String::from_utf8_lossy(&text).into_owned())
    };
    Ok([profile("1")?, profile("2")?])
}

/// Reads the total from a callgrind output file (`totals:`, in older versions `summary:`).
fn parse_total(text: &str) -> Option<u64> {
    let value = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.trim().parse().ok());
    value("totals:").or_else(|| value("summary:"))
}

/// The instructions of a function itself in one repetition, before and after.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChangedFunction {
    /// Its path.
    pub name: String,
    /// Before and after.
    pub counts: [u64; 2],
}

/// Finds the functions, three at most, whose own instructions in a repetition changed most between two programs, by
/// their callgrind output files with one repetition and with two; those that changed by less than a tenth of the first
/// of them are left out.
pub fn changed_functions([before, after]: [&[String; 2]; 2]) -> Vec<ChangedFunction> {
    let (before, after) = (of_repetition(before), of_repetition(after));
    let names: BTreeSet<&String> = before.keys().chain(after.keys()).collect();
    let count = |of: &BTreeMap<String, u64>, name| of.get(name).copied().unwrap_or(0);
    let changed = |function: &ChangedFunction| function.counts[0].abs_diff(function.counts[1]);
    let mut functions: Vec<ChangedFunction> = names
        .into_iter()
        .map(|name| ChangedFunction { name: name.clone(), counts: [count(&before, name), count(&after, name)] })
        .filter(|function| changed(function) > 0)
        .collect();
    functions.sort_by_key(|function| Reverse(changed(function)));
    let least = functions.first().map_or(0, changed) / 10;
    functions.retain(|function| changed(function) >= least);
    functions.truncate(3);
    functions
}

/// Own instructions of each function in one repetition.
fn of_repetition([one, two]: &[String; 2]) -> BTreeMap<String, u64> {
    let (one, mut two) = (own_instructions(one), own_instructions(two));
    two.iter_mut().for_each(|(name, count)| *count = count.saturating_sub(one.get(name).copied().unwrap_or(0)));
    two
}

/// Reads the instructions of each function itself from a callgrind output file: lines below its `fn=` but those behind
/// `calls=`, which are those of the function that is called. Names stand once, `(number) name`.
fn own_instructions(text: &str) -> BTreeMap<String, u64> {
    let mut names: HashMap<&str, &str> = HashMap::new();
    let mut counts: BTreeMap<String, u64> = BTreeMap::new();
    let (mut function, mut of_callee) = ("", false);
    for line in text.lines() {
        let named = line.strip_prefix("fn=").map(|name| (name, true));
        if let Some((name, is_own)) = named.or_else(|| line.strip_prefix("cfn=").map(|name| (name, false))) {
            let (number, name) = name.split_once(' ').unwrap_or((name, ""));
            let known = names.entry(number).or_insert(name);
            if is_own {
                function = known;
            }
        } else if line.starts_with("calls=") {
            of_callee = true;
        } else if line.starts_with(|c: char| c.is_ascii_digit() || "+-*".contains(c)) {
            let count = line.split(' ').nth(1).and_then(|count| count.parse::<u64>().ok());
            if let Some(count) = count.filter(|_| !std::mem::take(&mut of_callee)) {
                // Two versions of a function differ in a hash behind their name.
                let name =
                    function.rsplit_once("::h").filter(|(_, hash)| hash.len() == 16).map_or(function, |(name, _)| name);
                *counts.entry(name.to_owned()).or_default() += count;
            }
        }
    }
    counts
}
