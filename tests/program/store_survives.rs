//! A sweep that is killed, split, damaged or repeated ends with every row present once, equal to an undisturbed sweep.

use crate::program::{
    assert_has, cache, call, executable, files, printed, process, read, rimbench, said, two_sets_with,
};
use proptest::prelude::*;
use rimbench::harness::{Asked, RunRow, Store};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command as Process, Stdio};
use std::time::Duration;

const EXPERIMENT: &str = concat!(
    r#"
question = "Does the store survive?"
macro_steps_s = [2e-3, 5e-3, 1e-2]
phases = 6
duration_s = 0.4
trace_every_s = 5e-3
"#,
    two_sets_with!("rim-nonsmooth"),
    r#"
[[claims]]
id = "diverges"
by = "ours"
text = "Zero-order hold diverges at 5 ms"
set = "all"
scheme = "zero-order-hold"
macro_step_s = 5e-3
metric = "failed"
expect = ">= 1"
finding = "reproduced"
"#
);

/// Runs of the experiment: 2 parameter sets, 2 schemes, 3 macro steps, 6 phases.
const RUNS: usize = 72;

/// A folder with the experiment file.
fn workplace(experiment: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("survival.toml");
    std::fs::write(&file, experiment).unwrap();
    (folder, file)
}

fn run(file: &Path, out: &Path, extra: &[&str]) -> String {
    printed(rimbench().arg("run").arg(file).arg("--out").arg(out).args(extra))
}

/// The same, of which this is said.
fn run_says(file: &Path, out: &Path, extra: &[&str], wanted: &[&str]) {
    assert_has(&run(file, out, extra), wanted);
}

fn results(folder: &Path) -> Vec<(PathBuf, String)> {
    let tables = ["runs.csv", "parameters.csv", "settings.csv", "reference.csv"].map(|name| folder.join(name));
    let all = tables.into_iter().chain(files(&folder.join("traces")));
    all.map(|path| (path.strip_prefix(folder).unwrap().to_owned(), read(&path))).collect()
}

fn assert_same(one: &Path, other: &Path) {
    assert!(results(one) == results(other), "{} is not {}", one.display(), other.display());
}

#[test]
fn two_at_once_killed_again_and_again_finish_as_if_undisturbed() {
    let (folder, file) = workplace(EXPERIMENT);
    let (undisturbed, killed) = (folder.path().join("a/survival"), folder.path().join("b/survival"));
    run_says(&file, &undisturbed, &[], &["72 of 72 runs stored", "72 computed now"]);

    let start = |jobs: &str| {
        let mut command = process();
        command.args(["run", file.to_str().unwrap(), "--jobs", jobs, "--out", killed.to_str().unwrap()]);
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    for attempt in 0..15_u64 {
        let mut at_once = [start("1"), start("1")];
        // Any instant will do: from before the first row to after the last.
        std::thread::sleep(Duration::from_millis(3 + 9 * (attempt % 12)));
        for process in &mut at_once {
            process.kill().and_then(|()| process.wait()).unwrap();
        }
        // As a crash of the machine may leave it.
        let tables = files(&killed.join("records"));
        if let Some(table) = tables.get(attempt as usize % tables.len().max(1)) {
            let bytes = std::fs::read(table).unwrap();
            std::fs::write(table, &bytes[..bytes.len() - bytes.len().min(37 * attempt as usize)]).unwrap();
        }
    }
    for process in &mut [start("1"), start("1")] {
        assert!(process.wait().unwrap().success());
    }
    assert_same(&killed, &undisturbed);
    assert_eq!(read(killed.join("runs.csv")).lines().count(), RUNS + 1);
    // No half-written file is left, neither results nor traces.
    let half = |path: &&PathBuf| path.file_name().unwrap().to_string_lossy().starts_with('.');
    assert_eq!(files(&killed).iter().find(half), None);
}

/// Both compute all runs, each at its own cost, and either may write the files while the other looks at them.
#[test]
fn two_that_finish_the_same_job_at_once_both_succeed_and_leave_files_as_they_were_written() {
    let (folder, file) =
        workplace(&EXPERIMENT.replace("0.4", "0.1").replace("trace_every_s = 5e-3", "trace_every_s = 1e-3"));
    for round in 0..15 {
        let out = folder.path().join(format!("{round}/survival"));
        let mut command = process();
        command.args(["run", file.to_str().unwrap(), "--jobs", "1", "--out", out.to_str().unwrap()]);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        for process in [command.spawn().unwrap(), command.spawn().unwrap()] {
            let output = process.wait_with_output().unwrap();
            assert!(output.status.success(), "round {round}: {}", String::from_utf8_lossy(&output.stderr));
        }
        rimbench::checksums::verify(&out).unwrap();
    }
}

#[test]
fn a_full_disk_is_an_error_that_loses_nothing() {
    let (folder, file) = workplace(EXPERIMENT);
    let out = folder.path().join("survival");
    run(&file, &out, &["--shard", "1/2"]);
    // A limit on the size of files stands in for a full disk: the next log may not grow.
    let [program, experiment, to] = [&executable(), &file, &out].map(|path| path.display().to_string());
    let script = format!("trap '' XFSZ; ulimit -f 2; exec {program} run {experiment} --out {to}");
    let output = Process::new("bash").args(["-c", &script]).env("RIMBENCH_CACHE", cache()).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stderr).contains("cannot be written"));
    run_says(&file, &out, &[], &["72 of 72 runs stored"]);
}

#[test]
fn bad_experiment_files_are_refused_with_the_place() {
    let (phases, trace) = ("phases = 6", "trace_every_s = 5e-3");
    for (piece, by, wanted) in [
        (phases, "phazes = 6", "unknown field `phazes`"),
        ("question =", "question", "line 2"),
        (phases, "phases = 0", "the grid is empty"),
        (phases, "phases = 10000000", "more than the 1000000 that one experiment may have: split it"),
        (phases, "phases = [0.5, 1.5]", "phases = 1.5"),
        ("2e-3, 5e-3", "-2e-3, 5e-3", "macro_steps_s = -0.002"),
        ("[2e-3, 5e-3, 1e-2]", "{ from = 1e-2, to = 2e-3, per_decade = 4 }", "macro_steps_s: to"),
        (trace, "trace_every_s = 0.0", "trace_every_s = 0"),
        (trace, "traces = [\"rim-smoth\"]", "label in traces"),
        (trace, "reference_step_s = -1.0", "reference_step_s = -1"),
        ("wedge-box", "wedge-bocks", "did you mean `wedge-box`"),
        ("box_mass_kg", "box_mas_kg", "did you mean `box_mass_kg`"),
        ("scheme = \"rim-nonsmooth\"", "scheme = \"zero-order-hold\"", "holds one run twice"),
        ("scheme = \"rim-nonsmooth\"", "scheme = \"nepce\"\ndelivery.up = { delay = 9999 }", "macro steps of the run"),
        ("scheme = \"rim-nonsmooth\"", "scheme = \"nepce\"\ndelivery.down = { loss = 1.0 }", "from 0 to below 1"),
        ("scheme = \"rim-nonsmooth\"", "scheme = \"nepce\"\ndelivery.up = { missed = [7, 3] }", "in the order of time"),
        (
            "scheme = \"rim-nonsmooth\"",
            "scheme = \"nepce\"\ndelivery.up = { log = \"x.csv\", deadline_s = 1 }",
            "x.csv",
        ),
        ("scheme = \"rim-nonsmooth\"", "scheme = \"monolithic\"\ndelivery.up = { delay = 1 }", "does not iterate"),
        ("macro_step_s = 5e-3", "macro_step_s = 6e-3", "does not run"),
        ("metric = \"failed\"", "metric = \"faild\"", "did you mean `failed`"),
        (">= 1", "about 1", "is no comparison"),
    ] {
        let (folder, file) = workplace(&EXPERIMENT.replace(piece, by));
        for how in [&["--dry-run"][..], &[]] {
            let message = said(rimbench().current_dir(folder.path()).arg("run").arg(&file).args(how), 2);
            assert_has(&message, &[wanted, "survival.toml"]);
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
    }
    call("run no-such-file.toml").assert().code(2);
    let (_folder, file) = workplace(EXPERIMENT);
    for how in [["--shard", "3/2"], ["--jobs", "0"], ["--collect", "no-such-folder"]] {
        rimbench().arg("run").arg(&file).args(how).assert().code(2);
    }
}

#[test]
fn a_range_of_macro_steps_chosen_traces_and_a_reference_of_its_own_are_honoured() {
    let text = EXPERIMENT
        .replace("[2e-3, 5e-3, 1e-2]", "{ from = 5e-3, to = 5e-2, per_decade = 2 }")
        .replace("phases = 6", "phases = 1\ntraces = [\"rim-nonsmooth\"]");
    let (folder, file) = workplace(&text);
    let out = folder.path().join("survival");
    // 2 parameter sets, 2 schemes, 3 macro steps; traces of one scheme, and of the two references.
    assert!(run(&file, &out, &[]).contains("12 of 12 runs stored"));
    assert_eq!(std::fs::read_dir(out.join("traces")).unwrap().count(), 6 + 2);
    let uncertainty = |folder: &Path| {
        let text = read(folder.join("reference.csv"));
        let line = text.lines().find(|line| line.contains("actuator_length_m")).unwrap();
        line.split(',').nth(3).unwrap().parse::<f64>().unwrap()
    };
    std::fs::write(&file, text.replace("phases = 1", "phases = 1\nreference_step_s = 5e-5")).unwrap();
    let coarser = folder.path().join("coarser/survival");
    run(&file, &coarser, &[]);
    // Second order: twice the step, four times the uncertainty.
    approx::assert_relative_eq!(uncertainty(&coarser) / uncertainty(&out), 4.0, max_relative = 0.1);
    // Rows that were held against another reference are not taken for these.
    rimbench().arg("run").arg(&file).arg("--out").arg(&out).assert().code(2);
}

#[cfg(unix)]
#[test]
fn an_interrupt_stops_cleanly_and_says_how_to_go_on() {
    let (folder, file) = workplace(&EXPERIMENT.replace("phases = 6", "phases = 3000"));
    let out = folder.path().join("survival");
    let process = process()
        .args(["run", file.to_str().unwrap(), "--out", out.to_str().unwrap()])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    // The sweep takes tens of seconds; the first records are there long before.
    let records = out.join("records");
    while !records.is_dir() {
        std::thread::sleep(Duration::from_millis(5));
    }
    Process::new("kill").args(["-INT", &process.id().to_string()]).status().unwrap();
    let output = process.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(printed.contains("Stopped") && printed.contains("the same command goes on"), "{printed}");
}

/// A row of a run: the writer and its place tell it from others of the same run; of a limit it was ended by it.
fn written((run, growth, limit): (u8, bool, Option<u8>), writer: usize, place: usize) -> RunRow {
    let mut row = RunRow {
        wall_limit_s: limit.map(f64::from),
        asked: Asked { growth, ..Asked::default() },
        ..RunRow::blank(&format!("{run:016x}"))
    };
    row.found.reason = format!("{writer},{place}");
    row
}

fn open(folder: &Path) -> Store {
    Store::open(folder, Path::new("e.toml"), "").unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Writers that store at once, each killed after any byte of its log: of every run the best of the whole rows
    /// stands, whatever the order, and what was cut is counted.
    #[test]
    fn whatever_writers_at_once_store_and_kills_cut_off_the_best_whole_row_stands(
        writers in prop::collection::vec(
            (prop::collection::vec((0..5_u8, any::<bool>(), prop::option::of(1..4_u8)), 0..10), prop::option::of(0.0..1.0_f64)),
            1..5,
        ),
    ) {
        let folder = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for (writer, (records, _)) in writers.iter().enumerate() {
                let folder = folder.path();
                scope.spawn(move || {
                    let store = open(folder);
                    for (place, &row) in records.iter().enumerate() {
                        store.append(written(row, writer, place)).unwrap();
                    }
                });
            }
        });
        let logs = files(&folder.path().join("records"));
        let (mut best, mut damaged) = (BTreeMap::<(u8, bool), (f64, RunRow)>::new(), 0);
        for log in &logs {
            let mut text = std::fs::read_to_string(log).unwrap();
            // Whose it is stands in the reason of its first row, the only cell in quotes.
            let reason = text.lines().nth(2).unwrap().split('"').nth(1).unwrap();
            let writer: usize = reason.split(',').next().unwrap().parse().unwrap();
            let (records, kill) = &writers[writer];
            if let Some(share) = kill {
                text.truncate((share * text.len() as f64) as usize);
                std::fs::write(log, &text).unwrap();
            }
            let whole = text.matches('\n').count().saturating_sub(2);
            // A head that was cut leaves nothing, a row that was cut counts.
            damaged += usize::from(text.matches('\n').count() > 1 && !text.ends_with('\n'));
            for (place, &row) in records[..whole].iter().enumerate() {
                let (run, growth, limit) = row;
                let allowed = limit.map_or(f64::INFINITY, f64::from);
                if best.get(&(run, growth)).is_none_or(|(known, _)| allowed >= *known) {
                    best.insert((run, growth), (allowed, written(row, writer, place)));
                }
            }
        }
        let store = open(folder.path());
        let runs: BTreeSet<u8> = best.keys().map(|(run, _)| *run).collect();
        prop_assert_eq!((store.run_ids().len(), store.damaged.len()), (runs.len(), damaged));
        for run in 0..5 {
            let id = format!("{run:016x}");
            let wanted = best.range((run, false)..=(run, true)).map(|(_, (_, row))| row);
            prop_assert_eq!(store.rows_of(&id).collect::<Vec<_>>(), wanted.collect::<Vec<_>>());
        }
    }
}
