//! What counts as a regression, on records that are made up and on those that are kept.

use crate::program::root;
use rimbench::perf::{
    BENCHMARKS, COUNTERS, ChangedFunction, Comparison, History, REBUILT, REPEATED, Row, Verdict, changed_functions,
    compare, fence_of, measure,
};

fn kept() -> History {
    History::read(&root().join("results/perf/history.csv")).unwrap()
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
    History { rows }
}

fn compared(history: &History, base: &str, new: &str) -> Comparison {
    let (base, new) = (history.select(base).unwrap(), history.select(new).unwrap());
    compare(&base, &new, fence_of(&base, &new)).unwrap()
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
        let of = |fence| verdict(&compare(&before, &after, fence).unwrap(), "instructions").unwrap();
        assert_eq!([of(REPEATED), of(REBUILT)], [repeated, rebuilt], "{share}");
    }
}

/// A thousandth is seen between two records of one program; two builds scatter by twice as much, also where both are in
/// the history.
#[test]
fn records_of_two_revisions_are_held_against_the_fence_of_two_builds() {
    let verdicts = |revision: &str, dirty: &str| {
        let base = [row("before00", "rev000000001", 1e7)];
        let changed = |share: f64| {
            let mut new = [Row { git_dirty: dirty.to_owned(), ..row("after000", revision, 1e7 * (1.0 + share)) }];
            new[0].record = "after000".to_owned();
            verdict(&compare(&base, &new, fence_of(&base, &new)).unwrap(), "instructions").unwrap()
        };
        [-3e-4, 1e-3, -3e-3, 3e-3].map(changed)
    };
    let [same, better, worse] = [Verdict::Same, Verdict::Improved, Verdict::Regressed];
    assert_eq!(verdicts("rev000000001", "false"), [better, worse, better, worse]);
    assert_eq!(verdicts("rev000000002", "false"), [same, same, better, worse]);
    // What is not committed is another build, whatever revision it is near.
    assert_eq!(verdicts("rev000000001", "true"), [same, same, better, worse]);
}

/// Of a repetition, so that what happens once drops out; own instructions, so that callers of what changed are not
/// named for it.
#[test]
fn the_functions_that_changed_are_named_largest_first() {
    let profile = |repetitions: u64, solve: u64, copy: u64, once: u64| {
        let (solve, copy) = (repetitions * solve, repetitions * copy);
        format!(
            "events: Ir\nfn=(1) toy::main\n1 {once}\ncfn=(2) toy::solve::h0123456789abcdef\ncalls=1 5\n+3 {solve}\n* 7\n\n\
             fn=(2)\n5 {solve}\ncfi=(4) copy.S\ncfn=(3) copy\ncalls=2 0\n-1 {copy}\n\nfn=(3)\n0 {copy}\ntotals: 1\n"
        )
    };
    let program = |solve, copy, once| [1, 2].map(|repetitions| profile(repetitions, solve, copy, once));
    let changed = |before: [u64; 3], after: [u64; 3]| {
        let [before, after] = [before, after].map(|[solve, copy, once]| program(solve, copy, once));
        changed_functions([&before, &after])
    };
    let named = |name: &str, counts| ChangedFunction { name: name.to_owned(), counts };
    assert_eq!(changed([100, 50, 9], [100, 50, 9000]), []);
    assert_eq!(changed([100, 50, 9], [150, 50, 9]), [named("toy::solve", [100, 150])]);
    assert_eq!(changed([100, 50, 9], [80, 90, 9]), [named("copy", [50, 90]), named("toy::solve", [100, 80])]);
    assert_eq!(changed([100, 50, 9], [101, 90, 9]), [named("copy", [50, 90])]);
}

/// In our own history, whose compilers are alike, programs that had changed took 1 to 8 % more instructions, and
/// programs that had not took as many up to a millionth.
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

#[test]
fn one_more_pivot_is_a_regression_unless_all_work_together_is_less_and_a_wrong_answer_is_one() {
    let mut history = level(2);
    history.rows[1].counters[5] += 1;
    let of = |history: &History| compared(history, "previous", "latest");
    assert_eq!(of(&history).regressions(), ["wedge-box/rim-nonsmooth: lcp_pivots"]);
    history.rows[1].instructions = Some(9_900_000);
    assert_eq!(verdict(&of(&history), "lcp_pivots"), Some(Verdict::Traded));
    history.rows[1].counters[7] += 1;
    assert_eq!(of(&history).regressions(), ["wedge-box/rim-nonsmooth: lcp_fallbacks"], "a failure is no price");
    history.rows[1].status = "wrong answer 1, expected 2".to_owned();
    assert_eq!(of(&history).regressions(), ["wedge-box/rim-nonsmooth: wrong answer 1, expected 2"]);
    assert_eq!(of(&history).findings.len(), 1, "what has the wrong answer has no performance");
}

#[test]
fn another_compiler_and_another_build_have_other_instructions() {
    let mut history = level(2);
    history.rows.iter_mut().for_each(|row| row.build = "release".to_owned());
    let told = |history: &History| {
        let comparison = compared(history, "previous", "latest");
        assert_eq!(verdict(&comparison, "eliminations"), Some(Verdict::Same));
        (verdict(&comparison, "instructions"), comparison.notes.join(" "))
    };
    assert_eq!(told(&history), (Some(Verdict::Same), String::new()));
    // A record without settings is one of the usual ones, or it is refused.
    history.rows[0].build.clear();
    let (instructions, notes) = told(&history);
    assert!(instructions.is_some() && notes.contains("settings of a build are not known"), "{notes}");
    let refused = |[base, new]: [&str; 2]| {
        let mut rows = level(2).rows;
        (rows[0].build, rows[1].build) = (base.to_owned(), new.to_owned());
        compare(&rows[..1], &rows[1..], REBUILT).err().map(|error| error.to_string())
    };
    let changed = "release CARGO_PROFILE_RELEASE_OPT_LEVEL=0";
    for builds in [["release", changed], [changed, "release"], ["", changed], [changed, ""], ["release", "debug"]] {
        let message = refused(builds).unwrap();
        assert!(
            ["rec00000 has ", "rec00001 has ", "--rev BASE --rev NEW"].iter().all(|said| message.contains(said)),
            "{message}"
        );
    }
    for builds in [["release", "release"], [changed, changed], ["", "release"], ["", ""]] {
        assert_eq!(refused(builds), None, "{builds:?}");
    }
    history.rows[1].rustc = "rustc 1.99.0".to_owned();
    let (instructions, notes) = told(&history);
    assert!(instructions.is_none() && notes.contains("compilers rustc 1.88.0 and rustc 1.99.0"), "{notes}");
}

#[test]
fn a_history_comes_back_as_it_was_written_behind_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("history.csv");
    let mut rows = level(2).rows;
    rows[0].instructions = None;
    rows[1].build = "release".to_owned();
    History::append(&path, &rows[..1]).unwrap();
    History::append(&path, &rows[1..]).unwrap();
    assert_eq!(History::read(&path).unwrap().rows, rows);
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

/// What has been committed has been looked at: the newest record must be none that raises an alarm against the one
/// before.
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
    for benchmark in BENCHMARKS {
        let (fault, counters) = measure(benchmark).unwrap();
        assert_eq!(fault, None, "{}", benchmark.name);
        let row = newest.iter().find(|row| row.benchmark == benchmark.name).expect("`rimbench perf record`");
        let advice = "if that is meant, explain it and run `rimbench perf record`";
        let named = |counts: [u64; 8]| COUNTERS.into_iter().zip(counts).collect::<Vec<_>>();
        assert_eq!(named(counters), named(row.counters), "{}: {advice}", benchmark.name);
    }
}
