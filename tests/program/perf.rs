//! What counts as a regression, on synthetic histories.

use crate::program::root;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rimbench::perf::{Comparison, History, Paired, Row, Verdict, compare_pairs, compare_records};
use rimbench::statistics::TimeSummary;
use std::sync::LazyLock;

/// Rounds of a synthetic measurement, as many as `perf record` makes by default.
const ROUNDS: usize = 12;
/// Spread (standard deviation of the logarithm) of a synthetic time: a shared machine.
const TIME_NOISE: f64 = 0.05;
/// Half width of the scatter of a synthetic instruction count: two records of one revision differ by as little.
const COUNT_NOISE: f64 = 4e-7;

/// Normal noise of unit variance: twelve uniform numbers.
fn noise(rng: &mut Pcg64) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

fn summary(rng: &mut Pcg64, ratio: f64) -> TimeSummary {
    let mut time = || (TIME_NOISE * noise(rng)).exp();
    let pairs: Vec<(f64, f64)> = (0..ROUNDS).map(|_| (ratio * time(), 1.0)).collect();
    TimeSummary::of(&pairs).unwrap()
}

fn row(rng: &mut Pcg64, record: &str, revision: &str, instructions: f64, time: f64) -> Row {
    static COMMITTED: LazyLock<Row> = LazyLock::new(|| {
        let history = History::read(&root().join("results/perf/history.csv")).unwrap();
        history.rows.into_iter().find(|row| row.benchmark == "wedge-box/rim-nonsmooth" && row.status == "ok").unwrap()
    });
    let measured = summary(rng, time);
    let [low, high] = summary(rng, 1.0).interval();
    Row {
        record: record.to_owned(),
        git_revision: revision.to_owned(),
        rustc: "rustc 1.88.0".to_owned(),
        instructions: Some((instructions * (1.0 + COUNT_NOISE * (2.0 * rng.random::<f64>() - 1.0))) as u64),
        time_ratio: Some(measured.ratio),
        time_log_sd: Some(measured.log_sd),
        time_samples: Some(measured.samples),
        placebo_ratio: Some((low * high).sqrt()),
        placebo_low: Some(low),
        placebo_high: Some(high),
        ..COMMITTED.clone()
    }
}

/// Records of one level of instructions and time, each of its own revision.
fn level(rng: &mut Pcg64, records: usize) -> History {
    let rows = (0..records).map(|k| row(rng, &format!("rec{k:05}"), &format!("rev{k:09}"), 1e7, 2.0)).collect();
    History { rows, ..History::default() }
}

fn latest(history: &History) -> Comparison {
    compare_records((history, "previous"), (history, "latest")).unwrap()
}

fn verdict(comparison: &Comparison, quantity: &str) -> Option<Verdict> {
    comparison.findings.iter().find(|finding| finding.quantity == quantity).map(|finding| finding.verdict)
}

#[test]
fn two_per_cent_more_instructions_are_caught_whatever_the_seed() {
    for seed in 0..100 {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut history = level(&mut rng, 1 + seed as usize % 40);
        let planted = row(&mut rng, "planted1", "slower123456", 1.02e7, 2.0);
        history.rows.push(planted);
        let comparison = latest(&history);
        assert_eq!(comparison.regressions(), ["wedge-box/rim-nonsmooth: instructions"], "seed {seed}");
    }
}

#[test]
fn a_regression_after_an_improvement_is_held_against_the_new_level() {
    let mut rng = Pcg64::seed_from_u64(7);
    let mut history = level(&mut rng, 25);
    for k in 0..3 {
        history.rows.push(row(&mut rng, &format!("fast{k:04}"), "faster123456", 0.5e7, 2.0));
    }
    assert_eq!(verdict(&latest(&history), "instructions"), Some(Verdict::Same));
    history.rows.push(row(&mut rng, "planted1", "slower123456", 0.51e7, 2.0));
    assert_eq!(verdict(&latest(&history), "instructions"), Some(Verdict::Regressed));
}

#[test]
fn records_of_one_program_are_quiet_in_a_hundred_of_a_hundred_tries() {
    for seed in 0..100 {
        let mut rng = Pcg64::seed_from_u64(1000 + seed);
        let mut history = level(&mut rng, 30);
        // The same revision twice, so that times have the second measurement they need for an alarm.
        for record in ["again001", "again002"] {
            history.rows.push(row(&mut rng, record, "same12345678", 1e7, 2.0));
        }
        let comparison = compare_records((&history, "rec00029"), (&history, "latest")).unwrap();
        assert_eq!(comparison.regressions(), [""; 0], "seed {seed}");
    }
}

/// In our own history, whose compilers are alike, programs that had changed took 1 to 8 % more instructions, and programs that had not took
/// as many up to a millionth.
#[test]
fn rises_in_our_own_history_are_found_and_repeats_are_none() {
    let history = History::read(&root().join("results/perf/history.csv")).unwrap();
    let rises = |base: &str, new: &str| {
        let comparison = compare_records((&history, base), (&history, new)).unwrap();
        assert!(comparison.findings.iter().any(|finding| finding.quantity == "instructions"));
        comparison.regressions().iter().filter(|name| name.ends_with(": instructions")).count()
    };
    for (base, new, least) in [("f7f376e1", "c596dbd6", 7), ("30fb1619", "b6c575dd", 9), ("c8a047d8", "7e7cb547", 10)] {
        assert!(rises(base, new) >= least, "{base} {new}: {}", rises(base, new));
    }
    assert_eq!([rises("b6c575dd", "c8a047d8"), rises("7e7cb547", "853bd48a")], [0, 0]);
}

/// A side-by-side measurement of one benchmark that takes `ratio` times as long as before.
fn side_by_side(rng: &mut Pcg64, ratio: f64) -> Comparison {
    let rows = [row(rng, "base0001", "base12345678", 1e7, 2.0), row(rng, "new00001", "new123456789", 1e7, 2.0)];
    let mut pair = Paired {
        benchmark: rows[0].benchmark.clone(),
        ratio: summary(rng, ratio),
        placebo: summary(rng, 1.0),
        second: None,
    };
    if pair.decide() == Verdict::Suspected {
        pair.second = Some(summary(rng, ratio));
    }
    compare_pairs(&rows[..1], &rows[1..], &[pair])
}

#[test]
fn one_program_against_itself_side_by_side_is_quiet_in_a_hundred_of_a_hundred_tries() {
    for seed in 0..100 {
        let mut rng = Pcg64::seed_from_u64(2000 + seed);
        for _ in 0..4 {
            assert_eq!(side_by_side(&mut rng, 1.0).regressions(), [""; 0], "seed {seed}");
        }
    }
}

#[test]
fn a_program_slower_by_a_fifth_is_caught_unless_the_placebo_fails() {
    // The interval of twelve ratios is ± 2.2 · 5 % / √12 = ± 3.2 %, that of the placebo likewise: a fifth stands clear.
    let mut caught = 0;
    for seed in 0..100 {
        let mut rng = Pcg64::seed_from_u64(3000 + seed);
        let comparison = side_by_side(&mut rng, 1.2);
        match verdict(&comparison, "time") {
            Some(Verdict::Regressed) => caught += 1,
            other => assert_eq!(other, Some(Verdict::NotCompared), "seed {seed}: {}", comparison.markdown()),
        }
        let regressed = verdict(&comparison, "time") == Some(Verdict::Regressed);
        assert_eq!(comparison.regressions().len(), usize::from(regressed));
    }
    // A 95 % placebo fails 5 times in 100, with a standard deviation of 2.2; four of them leave 86.
    assert!(caught >= 86, "{caught} of 100");
}

#[test]
fn a_slower_record_alarms_only_when_a_second_record_confirms_it() {
    let mut rng = Pcg64::seed_from_u64(4);
    let mut history = level(&mut rng, 3);
    history.rows.push(row(&mut rng, "slow0001", "slower123456", 1e7, 2.4));
    let once = latest(&history);
    assert_eq!(verdict(&once, "time"), Some(Verdict::Suspected));
    assert_eq!(once.regressions(), [""; 0]);
    history.rows.push(row(&mut rng, "slow0002", "slower123456", 1e7, 2.4));
    let twice = compare_records((&history, "rec00002"), (&history, "slower")).unwrap();
    assert_eq!(twice.regressions(), ["wedge-box/rim-nonsmooth: time"]);
}

#[test]
fn one_more_pivot_is_a_regression_and_a_wrong_answer_too() {
    let mut rng = Pcg64::seed_from_u64(5);
    let mut history = level(&mut rng, 2);
    history.rows[1].lcp_pivots += 1;
    assert_eq!(latest(&history).regressions(), ["wedge-box/rim-nonsmooth: lcp_pivots"]);
    history.rows[1].status = "wrong answer 1, expected 2".to_owned();
    let wrong = latest(&history);
    assert_eq!(wrong.regressions(), ["wedge-box/rim-nonsmooth: answer"]);
    assert_eq!(wrong.findings.len(), 1, "what has the wrong answer has no performance");
}

#[test]
fn another_machine_or_compiler_is_compared_only_where_that_means_something() {
    let mut rng = Pcg64::seed_from_u64(6);
    let mut history = level(&mut rng, 2);
    history.rows[1].machine = "bbbbbbbb".to_owned();
    let machine = latest(&history);
    assert_eq!(verdict(&machine, "time"), None);
    assert_eq!(verdict(&machine, "instructions"), Some(Verdict::Same));
    assert!(machine.notes.iter().any(|note| note.contains("two machines")), "{:?}", machine.notes);

    history.rows[1].rustc = "rustc 1.99.0".to_owned();
    let compiler = latest(&history);
    assert_eq!(verdict(&compiler, "instructions"), None);
    assert_eq!(verdict(&compiler, "lcp_pivots"), Some(Verdict::Same));
    assert!(compiler.notes.iter().any(|note| note.contains("compilers rustc 1.88.0 and rustc 1.99.0")));
}

#[test]
fn a_history_comes_back_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("history.csv");
    let mut rng = Pcg64::seed_from_u64(8);
    let mut history = History::read_or_begin(&path).unwrap();
    let mut rows = level(&mut rng, 4).rows;
    rows[0].placebo_ratio = None;
    history.append(&rows[..1]).unwrap();
    history.append(&rows[1..]).unwrap();
    assert_eq!(History::read(&path).unwrap().rows, rows);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
}

#[test]
fn what_another_has_recorded_in_between_is_not_lost() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("history.csv");
    let rows = level(&mut Pcg64::seed_from_u64(10), 2).rows;
    let [mut one, mut other] = [(); 2].map(|()| History::read_or_begin(&path).unwrap());
    one.append(&rows[..1]).unwrap();
    other.append(&rows[1..]).unwrap();
    assert_eq!(History::read(&path).unwrap().rows, rows);
    assert_eq!(other.rows, rows);
}

#[test]
fn records_are_named_by_place_by_name_and_by_revision() {
    let history = level(&mut Pcg64::seed_from_u64(9), 3);
    for (selector, record) in [
        ("latest", "rec00002"),
        ("previous", "rec00001"),
        ("rec00000", "rec00000"),
        ("rev000000001", "rec00001"),
        ("rev0000000010123456789", "rec00001"),
    ] {
        assert_eq!(history.select(selector).unwrap(), record);
    }
    let message = history.select("nonsense").unwrap_err().to_string();
    assert!(message.contains("record = nonsense is not valid") && message.contains("rec00002"), "{message}");
    assert!(history.select("r").is_err(), "one letter names nothing");
}

/// What is measured is what the name says: no scheme gives the answer that is expected of another.
#[test]
fn the_answers_of_the_suite_tell_its_schemes_apart() {
    let runs: Vec<_> =
        rimbench::perf::BENCHMARKS.iter().filter(|benchmark| !benchmark.name.starts_with("kernel/")).collect();
    let answers: Vec<f64> = runs
        .iter()
        .map(|benchmark| (benchmark.prepare)().and_then(|mut repetition| repetition()).unwrap().answer)
        .collect();
    for (benchmark, own) in runs.iter().zip(&answers) {
        assert_eq!(benchmark.fault(*own), None, "{}", benchmark.name);
        for (other, answer) in runs.iter().zip(&answers).filter(|(other, _)| other.name != benchmark.name) {
            assert!(benchmark.fault(*answer).is_some(), "{} passes for {}", other.name, benchmark.name);
        }
    }
}

/// What has been committed has been looked at: the newest record must be none that raises an alarm against the one before.
#[test]
fn the_newest_committed_record_is_no_regression_of_the_one_before() {
    let history = History::read(&root().join("results/perf/history.csv")).unwrap();
    let comparison = latest(&history);
    assert!(comparison.findings.len() > 50, "{} findings: the check compares nothing", comparison.findings.len());
    assert_eq!(comparison.regressions(), [""; 0]);
}

/// The work of the suite must be that of the newest committed record: who changes it records it anew.
#[test]
fn the_counters_of_the_suite_are_those_of_the_newest_committed_record() {
    let path = root().join("results/perf/history.csv");
    let history = History::read(&path).unwrap();
    let newest = history.of_record(history.select("latest").unwrap());
    assert_eq!(newest.len(), rimbench::perf::BENCHMARKS.len(), "record the suite anew: rimbench perf record");
    for benchmark in rimbench::perf::BENCHMARKS {
        let sample = rimbench::perf::measure(benchmark, 1, false, &rimbench::BUILD).unwrap();
        assert_eq!(sample.status, "ok", "{}", benchmark.name);
        let row = newest.iter().find(|row| row.benchmark == benchmark.name).unwrap();
        for (name, counter) in rimbench::perf::COUNTERS {
            let advice = "if that is meant, explain it and run `rimbench perf record`";
            assert_eq!(sample.counter(name), counter(row), "{name} of {}: {advice}", benchmark.name);
        }
    }
}
