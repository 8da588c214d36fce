//! The suite measured in interleaved rounds, as rows of the history.

use super::callgrind;
use super::history::Row;
use super::sample::{Program, Sample};
use rimbench_core::error::Result;
use rimbench_harness::Provenance;
use rimbench_results::checksums::hex;
use rimbench_statistics::{TimeSummary, quantile};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// What to measure, and how often.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Benchmarks, by name.
    pub benchmarks: Vec<String>,
    /// Rounds of the wall times; none are measured below two.
    pub rounds: u32,
    /// Where valgrind is, if it is there.
    pub valgrind: Option<PathBuf>,
}

/// Measured times of one round, the programs one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Round {
    /// The base.
    pub base: Sample,
    /// What it is compared with, between the two of the base.
    pub new: Option<Sample>,
    /// The base again, as if it were another program.
    pub placebo: Sample,
}

/// Measures a benchmark in interleaved rounds `base, new, base`, every other round in reverse order.
///
/// # Errors
/// Those of the programs.
pub fn measure_rounds(base: &Program, new: Option<&Program>, benchmark: &str, rounds: u32) -> Result<Vec<Round>> {
    let one = |round: u32| {
        let first = base.sample(benchmark)?;
        let new = new.map(|program| program.sample(benchmark)).transpose()?;
        let last = base.sample(benchmark)?;
        let (base, placebo) = if round.is_multiple_of(2) { (first, last) } else { (last, first) };
        Ok(Round { base, new, placebo })
    };
    (0..rounds).map(one).collect()
}

/// Ratio of the times of `new` to the base, whose time is the geometric mean of its two: a linear drift drops out.
pub fn paired_ratio(rounds: &[Round]) -> Option<TimeSummary> {
    let pair = |round: &Round| Some((round.new.as_ref()?.wall_s, (round.base.wall_s * round.placebo.wall_s).sqrt()));
    TimeSummary::of(&rounds.iter().filter_map(pair).collect::<Vec<_>>())
}

/// Ratio of the base to itself: the machine's noise.
pub fn placebo_ratio(rounds: &[Round]) -> Option<TimeSummary> {
    TimeSummary::of(&rounds.iter().map(|round| (round.placebo.wall_s, round.base.wall_s)).collect::<Vec<_>>())
}

/// What all rows of a record have in common.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recording {
    record: String,
    recorded_at_unix_s: u64,
    program: Program,
    lock_hash: String,
    machine: String,
    cpu: String,
}

impl Recording {
    /// Begins a record of a program, here and now.
    pub fn begin(program: &Program, provenance: &Provenance) -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let machine = machine(&provenance.cpu);
        let key = format!("{}\n{machine}\n{}\n{}", program.git_revision, now.as_nanos(), std::process::id());
        Recording {
            record: digits(&key),
            recorded_at_unix_s: now.as_secs(),
            program: program.clone(),
            lock_hash: provenance.lock_hash.clone(),
            machine,
            cpu: provenance.cpu.clone(),
        }
    }

    /// Name of the record.
    pub fn name(&self) -> &str {
        &self.record
    }

    /// The row of one benchmark from its samples; a wrong answer has no measurements.
    pub fn row(&self, benchmark: &str, samples: &[&Sample], placebo: Option<TimeSummary>) -> Row {
        let sample = samples.iter().find(|sample| sample.status != "ok").or(samples.first());
        let text = |of: fn(&Sample) -> &str| sample.map_or_else(String::new, |sample| of(sample).to_owned());
        let count = |name: &str| sample.map_or(0, |sample| sample.counter(name));
        let status = text(|sample| &sample.status);
        let timed = status == "ok";
        let times: Vec<(f64, f64)> = samples.iter().map(|sample| (sample.wall_s, sample.fixed_work_s)).collect();
        let time = TimeSummary::of(&times).filter(|_| timed);
        let placebo = placebo.filter(|_| timed);
        let walls: Vec<f64> = times.iter().map(|(wall, _)| *wall).collect();
        Row {
            record: self.record.clone(),
            recorded_at_unix_s: self.recorded_at_unix_s,
            git_revision: self.program.git_revision.clone(),
            git_dirty: self.program.git_dirty.clone(),
            rustc: text(|sample| &sample.rustc),
            target: text(|sample| &sample.target),
            lock_hash: self.lock_hash.clone(),
            machine: self.machine.clone(),
            cpu: self.cpu.clone(),
            benchmark: benchmark.to_owned(),
            status,
            macro_steps: count("macro_steps"),
            mechanics_micro_steps: count("mechanics_micro_steps"),
            actuator_micro_steps: count("actuator_micro_steps"),
            eliminations: count("eliminations"),
            lcp_solves: count("lcp_solves"),
            lcp_pivots: count("lcp_pivots"),
            lcp_factorisations: count("lcp_factorisations"),
            lcp_fallbacks: count("lcp_fallbacks"),
            flops_estimate: count("flops_estimate"),
            instructions: None,
            wall_s: time.map(|_| rounded(quantile(&walls, 0.5))),
            time_ratio: time.map(|time| rounded(time.ratio)),
            time_log_sd: time.map(|time| rounded(time.log_sd)),
            time_samples: time.map(|time| time.samples),
            placebo_ratio: placebo.map(|placebo| rounded(placebo.ratio)),
            placebo_low: placebo.map(|placebo| rounded(placebo.interval()[0])),
            placebo_high: placebo.map(|placebo| rounded(placebo.interval()[1])),
        }
    }

    /// Counts the instructions of a benchmark that gave its answer, if valgrind is there.
    ///
    /// # Errors
    /// Those of the program under valgrind.
    pub fn count_instructions(&self, row: &mut Row, valgrind: Option<&Path>) -> Result<()> {
        if let Some(valgrind) = valgrind.filter(|_| row.is_ok()) {
            row.instructions = Some(callgrind::instructions(valgrind, &self.program, &row.benchmark)?);
        }
        Ok(())
    }
}

/// Measures the suite of one program. `progress` is told each benchmark before it begins.
///
/// # Errors
/// Those of the program; a wrong answer is a row.
pub fn record(
    program: &Program,
    provenance: &Provenance,
    plan: &Plan,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<Row>> {
    let recording = Recording::begin(program, provenance);
    let row = |benchmark: &String| {
        progress(benchmark);
        let rounds = measure_rounds(program, None, benchmark, plan.rounds.max(1))?;
        let samples: Vec<&Sample> = rounds.iter().flat_map(|round| [&round.base, &round.placebo]).collect();
        // One round gives the counters, but no spread.
        let samples = if plan.rounds < 2 { &samples[..1] } else { &samples[..] };
        let mut row = recording.row(benchmark, samples, placebo_ratio(&rounds));
        recording.count_instructions(&mut row, plan.valgrind.as_deref())?;
        Ok(row)
    };
    plan.benchmarks.iter().map(row).collect()
}

/// Five digits: times are not better known.
fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// A hash that tells machines apart and names none: processor, number of cores, host.
fn machine(cpu: &str) -> String {
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let host =
        ["/etc/machine-id", "/proc/sys/kernel/hostname"].map(|path| std::fs::read_to_string(path).unwrap_or_default());
    digits(&format!("{cpu}\n{cores}\n{}", host.concat()))
}

/// First eight digits of a hash.
fn digits(text: &str) -> String {
    hex(&Sha256::digest(text)[..4])
}
