//! What counts as a regression, on records that are made up and on those that are kept.

use crate::program::root;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rimbench::perf::{BENCHMARKS, COUNTERS, Comparison, Fence, History, Paired, Row, Verdict, compare, measure};
use rimbench::statistics::TimeSummary;

/// Rounds of a measurement, as many as `perf compare` makes by default.
const ROUNDS: usize = 12;
/// Spread (standard deviation of the logarithm) of a time: a shared machine.
const TIME_NOISE: f64 = 0.05;

fn kept() -> History {
    History::read(&root().join("results/perf/history.csv")).unwrap()
}

fn summary(rng: &mut Pcg64, ratio: f64) -> TimeSummary {
    // Normal noise: twelve uniform numbers.
    let mut time = || (TIME_NOISE * ((0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0)).exp();
    let pairs: Vec<(f64, f64)> = (0..ROUNDS).map(|_| (ratio * time(), 1.0)).collect();
    TimeSummary::of(&pairs).unwrap()
}

/// One benchmark of a record, with so many instructions.
fn row(record: &str, revision: &str, instructions: f64) -> Row {
    let (record, git_revision, rustc) = (record.to_owned(), revision.to_owned(), "rustc 1.88.0".to_owned());
    let instructions = Some(instructions as u64);
    let kept = kept().rows.into_iter().find(|row| row.benchmark == "wedge-box/rim-nonsmooth").unwrap();
    Row { record, git_revision, rustc, instructions, ..kept }
}

/// Records of one level of instructions, each of its own revision.
fn level(records: usize) -> History {
    let rows = (0..records).map(|k| row(&format!("rec{k:05}"), &format!("rev{k:09}"), 1e7)).collect();
    History { rows, ..History::default() }
}

fn compared(history: &History, base: &str, new: &str) -> Comparison {
    compare(&history.select(base).unwrap(), &history.select(new).unwrap(), Fence::Repeated, &[])
}

fn verdict(comparison: &Comparison, quantity: &str) -> Option<Verdict> {
    comparison.findings.iter().find(|finding| finding.quantity == quantity).map(|finding| finding.verdict)
}

#[test]
fn instructions_are_held_against_the_fence_of_a_repetition_or_of_another_build() {
    let before = [row("before", "before123456", 1e7)];
    for (share, repeated, rebuilt) in [
        (0.0, Verdict::Same, Verdict::Same),
        (5e-7, Verdict::Same, Verdict::Same),
        (2e-6, Verdict::Regressed, Verdict::Same),
        (1e-3, Verdict::Regressed, Verdict::Same),
        (0.02, Verdict::Regressed, Verdict::Regressed),
        (-0.02, Verdict::Improved, Verdict::Improved),
    ] {
        let after = [row("after", "after1234567", 1e7 * (1.0 + share))];
        let of = |fence| verdict(&compare(&before, &after, fence, &[]), "instructions").unwrap();
        assert_eq!([of(Fence::Repeated), of(Fence::Rebuilt)], [repeated, rebuilt], "{share}");
    }
}

/// In our own history, whose compilers are alike, programs that had changed took 1 to 8 % more instructions, and programs that had not
/// took as many up to a millionth.
#[test]
fn rises_in_our_own_history_are_found_and_repeats_are_none() {
    let history = kept();
    let rises = |base: &str, new: &str| {
        let comparison = compared(&history, base, new);
        assert!(verdict(&comparison, "instructions").is_some());
        comparison.regressions().iter().filter(|name| name.ends_with(": instructions")).count()
    };
    for (base, new, least) in [("f7f376e1", "c596dbd6", 7), ("30fb1619", "b6c575dd", 9), ("c8a047d8", "7e7cb547", 10)] {
        assert!(rises(base, new) >= least, "{base} {new}: {}", rises(base, new));
    }
    assert_eq!([rises("b6c575dd", "c8a047d8"), rises("7e7cb547", "853bd48a")], [0, 0]);
}

/// A side-by-side measurement of one benchmark that takes `ratio` times as long as before.
fn side_by_side(rng: &mut Pcg64, ratio: f64) -> Comparison {
    let rows = [row("base0001", "base12345678", 1e7), row("new00001", "new123456789", 1e7)];
    let benchmark = rows[0].benchmark.clone();
    let mut pair = Paired { benchmark, ratio: summary(rng, ratio), placebo: summary(rng, 1.0), second: None };
    if pair.decide() == Verdict::Suspected {
        pair.second = Some(summary(rng, ratio));
    }
    compare(&rows[..1], &rows[1..], Fence::Rebuilt, &[pair])
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
        let comparison = side_by_side(&mut Pcg64::seed_from_u64(3000 + seed), 1.2);
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
fn one_more_pivot_is_a_regression_and_a_wrong_answer_too_and_another_compiler_has_other_instructions() {
    let mut history = level(2);
    history.rows[1].counters[5] += 1;
    assert_eq!(compared(&history, "previous", "latest").regressions(), ["wedge-box/rim-nonsmooth: lcp_pivots"]);
    history.rows[1].rustc = "rustc 1.99.0".to_owned();
    let compiler = compared(&history, "previous", "latest");
    assert_eq!([verdict(&compiler, "instructions"), verdict(&compiler, "eliminations")], [None, Some(Verdict::Same)]);
    assert!(compiler.notes.iter().any(|note| note.contains("compilers rustc 1.88.0 and rustc 1.99.0")));
    history.rows[1].status = "wrong answer 1, expected 2".to_owned();
    let wrong = compared(&history, "previous", "latest");
    assert_eq!(wrong.regressions(), ["wedge-box/rim-nonsmooth: answer"]);
    assert_eq!(wrong.findings.len(), 1, "what has the wrong answer has no performance");
}

#[test]
fn a_history_comes_back_as_it_was_written_with_what_another_has_recorded_in_between() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("history.csv");
    let mut rows = level(2).rows;
    rows[0].instructions = None;
    let [mut one, mut other] = [(); 2].map(|()| History::read_or_begin(&path).unwrap());
    one.append(&rows[..1]).unwrap();
    other.append(&rows[1..]).unwrap();
    assert_eq!(History::read(&path).unwrap().rows, rows);
    assert_eq!(other.rows, rows);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
}

#[test]
fn records_are_named_by_place_by_name_and_by_revision() {
    let history = level(3);
    for (selector, record) in [
        ("latest", "rec00002"),
        ("previous", "rec00001"),
        ("rec00000", "rec00000"),
        ("rev000000001", "rec00001"),
        ("rev0000000010123456789", "rec00001"),
    ] {
        assert_eq!(history.select(selector).unwrap()[0].record, record);
    }
    let message = history.select("nonsense").unwrap_err().to_string();
    assert!(message.contains("record = nonsense is not valid") && message.contains("rec00002"), "{message}");
    assert!(history.select("r").is_err(), "one letter names nothing");
}

/// What is measured is what the name says: no scheme gives the answer that is expected of another.
#[test]
fn the_answers_of_the_suite_tell_its_schemes_apart() {
    let runs: Vec<_> = BENCHMARKS.iter().filter(|benchmark| !benchmark.name.starts_with("kernel/")).collect();
    let answers: Vec<f64> = runs.iter().map(|run| run.prepare().unwrap()().unwrap().answer).collect();
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
    let comparison = compared(&kept(), "previous", "latest");
    assert!(comparison.findings.len() > 50, "{} findings: the check compares nothing", comparison.findings.len());
    assert_eq!(comparison.regressions(), [""; 0]);
}

/// The work of the suite must be that of the newest committed record: who changes it records it anew.
#[test]
fn the_counters_of_the_suite_are_those_of_the_newest_committed_record() {
    let newest = kept().select("latest").unwrap();
    assert_eq!(newest.len(), BENCHMARKS.len(), "record the suite anew: rimbench perf record");
    for benchmark in BENCHMARKS {
        let sample = measure(benchmark, 1, &rimbench::BUILD).unwrap();
        assert_eq!(sample.status, "ok", "{}", benchmark.name);
        let row = newest.iter().find(|row| row.benchmark == benchmark.name).unwrap();
        let advice = "if that is meant, explain it and run `rimbench perf record`";
        let kept: Vec<_> = COUNTERS.map(str::to_owned).into_iter().zip(row.counters).collect();
        assert_eq!(sample.counters, kept, "{}: {advice}", benchmark.name);
    }
}
