//! `rimbench perf` as a user meets it.

use crate::program::{assert_has, printed, read, refused, rimbench, root, said};
use assert_cmd::Command;
use rimbench::perf::{History, Row, find_valgrind};
use std::fs;
use std::path::Path;

fn perf(arguments: &[&str]) -> Command {
    let mut command = rimbench();
    command.arg("perf").args(arguments);
    command
}

fn record(history: &Path) -> String {
    // Without a path there is no valgrind.
    said(perf(&["record", "--benchmark", "kernel/friction-warm", "--history"]).arg(history).env("PATH", ""), 0)
}

#[test]
fn a_missing_valgrind_is_a_note_and_a_regression_has_exit_code_one_and_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let history = folder.path().join("history.csv");
    assert_has(&record(&history), &["note: valgrind is not there"]);
    record(&history);
    let compare = |base: &str, new: &str, code| said(perf(&["compare", base, new, "--history"]).arg(&history), code);
    assert_has(&compare("previous", "latest", 0), &["8 quantities compared", "recorded without valgrind"]);

    let row = History::read(&history).unwrap().rows.remove(1);
    History::append(&history, &[Row { record: "slower01".to_owned(), counters: [999_999; 8], ..row }]).unwrap();
    assert_has(&compare("previous", "slower01", 1), &["Regressed: ", "kernel/friction-warm: lcp_pivots"]);
    assert_has(&compare("slower01", "previous", 0), &["improved", "No regression."]);
}

#[test]
fn a_comparison_in_json_has_every_quantity_and_the_exit_code_of_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let history = folder.path().join("history.csv");
    record(&history);
    let row = History::read(&history).unwrap().rows.remove(0);
    let pivots = row.counters[5];
    let mut slower = Row { record: "slower01".to_owned(), ..row };
    slower.counters[5] += 1;
    History::append(&history, &[slower]).unwrap();
    let output =
        perf(&["compare", "previous", "latest", "--format", "json", "--history"]).arg(&history).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let compared: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(compared["regressions"], serde_json::json!(["kernel/friction-warm: lcp_pivots"]));
    let findings = compared["findings"].as_array().unwrap();
    assert_eq!(findings.len(), 8);
    let finding = findings.iter().find(|finding| finding["quantity"] == "lcp_pivots").unwrap();
    assert_eq!(finding["verdict"], "regressed");
    assert_eq!((&finding["base"], &finding["new"]), (&pivots.into(), &(pivots + 1).into()));
}

/// What stands in a file for another program is not run here: at least it must call what is there.
#[test]
fn the_action_calls_a_command_that_exists() {
    let action = read(root().join(".github/actions/perf-compare/action.yml")).replace("\\\n", " ");
    let call = action.lines().find_map(|line| line.split_once(" -- perf compare ")).unwrap().1;
    let options: Vec<&str> = call.split_whitespace().filter(|word| word.starts_with("--")).collect();
    assert!(options.len() >= 2, "{options:?}");
    let help = printed(&mut perf(&["compare", "--help"]));
    for option in options {
        assert!(help.contains(option), "{option} is no option of perf compare");
    }
}

#[test]
fn bad_input_is_one_clear_error_with_exit_code_two() {
    let folder = tempfile::tempdir().unwrap();
    let damaged = folder.path().join("damaged.csv");
    fs::write(&damaged, "record,benchmark\n1,2\n").unwrap();
    let damaged = damaged.to_str().unwrap();
    for (arguments, says) in [
        (vec!["compare", "latest", "latest", "--history", damaged], "damaged.csv"),
        (vec!["record", "--history", damaged], "recorded_at_unix_s"),
        (vec!["compare", "latest", "previous", "--history", "/no/such/history.csv"], "/no/such/history.csv"),
        (vec!["compare", "nonsense", "latest"], "record = nonsense is not valid\nhelp: use latest, previous"),
        (vec!["compare", "--rev", "HEAD"], "two revisions"),
        (vec!["compare", "--rev", "no-such-revision", "--rev", "HEAD"], "--rev = no-such-revision is not valid"),
        (vec!["record", "--benchmark", "kernel/friction-warmth"], "did you mean `kernel/friction-warm`?"),
        (vec!["sample", "nothing"], "unknown benchmark `nothing`"),
        (vec!["record", "--suite", "experiments/paper/fig2.toml"], "names no run to record"),
    ] {
        assert_has(&refused(&mut perf(&arguments)), &[says]);
    }
    assert_eq!(fs::read_to_string(damaged).unwrap(), "record,benchmark\n1,2\n", "a damaged history is left alone");
    perf(&["compare"]).assert().code(2);
    perf(&["compare", "latest"]).assert().code(2);
}

/// Runs of one's own: those that an experiment file chooses.
#[test]
fn a_suite_of_ones_own_is_recorded_and_compared_and_says_what_is_wrong_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let history = folder.path().join("history.csv");
    let file = folder.path().join("mine.toml");
    let write = |perf: &str| {
        let text = "question = \"?\"\nmacro_steps_s = [1e-3, 2e-3]\nduration_s = 0.1\ncases = [{ name = \"bouncing-ball\" }]\n\
                    schemes = [{ scheme = \"nepce\" }, { scheme = \"zero-order-hold\", label = \"hold\" }]\n";
        fs::write(&file, format!("{text}{perf}")).unwrap();
    };
    let record = |code| {
        let mut command = perf(&["record", "--without-instructions", "--suite"]);
        said(command.arg(&file).arg("--history").arg(&history).current_dir(folder.path()), code)
    };
    write("[perf]\nschemes = [\"hold\"]\nmacro_steps_s = [1e-3]\n");
    assert_has(&record(0), &["bouncing-ball/hold/0.001", "1 row appended"]);
    let rows = History::read(&history).unwrap().rows;
    assert!(rows.len() == 1 && rows[0].is_ok() && rows[0].counters[0] == 100, "{rows:?}");
    let previous = perf(&["compare", "previous", "latest", "--history"]).arg(&history).output().unwrap();
    assert_has(&String::from_utf8_lossy(&previous.stderr), &["the history has one record"]);
    for (perf, wanted) in [
        ("", "names no run to record"),
        ("[perf]\nschemes = [\"nepc\"]\n", "did you mean `nepce`?"),
        ("[perf]\nschemes = [\"hold\"]\nmacro_steps_s = [3e-3]\n", "chooses no run of the plan"),
        ("[perf]\nschemes = [\"hold\"]\nsteps = 3\n", "unknown field `steps`"),
    ] {
        write(perf);
        assert_has(&record(2), &["mine.toml", wanted]);
    }
}

/// A package without dependencies that records as the suite does, with a number of pivots.
fn commit_toy(repository: &Path, pivots: u64, instructions: Option<u64>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let history = folder.path().join("history.csv");
    let (record, benchmark, status) = ("12345678".to_owned(), "toy".to_owned(), "ok".to_owned());
    let counters = [1, 1, 1, 1, 1, pivots, 1, 1];
    History::append(&history, &[Row { record, benchmark, status, counters, instructions, ..Row::default() }]).unwrap();
    // Under callgrind it spins as often as it counts.
    let main = format!(
        "#[inline(never)] pub fn spin(times: u64) {{ (0..times).for_each(|k| {{ std::hint::black_box(k); }}); }}\n\
         fn main() {{ let words: Vec<String> = std::env::args().skip(1).collect(); \
         if words[1] == \"sample\" {{ \
             assert_eq!([&*words[2], &*words[3]], [\"toy\", \"--repetitions\"]); \
             let times = words[4].parse::<u64>().unwrap() * {}; return spin(std::hint::black_box(times)); }} \
         assert_eq!([&*words[0], &*words[1], &*words[2]], [\"perf\", \"record\", \"--history\"]); \
         std::fs::write(&words[3], {:?}).unwrap(); }}",
        instructions.unwrap_or(0) / 10,
        read(&history)
    );
    fs::create_dir_all(repository.join("src")).unwrap();
    fs::write(repository.join("src/main.rs"), main).unwrap();
    let package = "name = \"rimbench\"\nversion = \"0.0.0\"\n";
    fs::write(repository.join("Cargo.toml"), format!("[package]\n{package}edition = \"2024\"\n")).unwrap();
    fs::write(repository.join("Cargo.lock"), format!("version = 4\n\n[[package]]\n{package}")).unwrap();
    let git = |arguments: &[&str]| {
        let who = ["-c", "user.name=toy", "-c", "user.email=toy@example.org", "-c", "init.defaultBranch=main"];
        let mut git = std::process::Command::new("git");
        let output = git.current_dir(repository).args(who).args(arguments).output().unwrap();
        assert!(output.status.success(), "git {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    };
    git(&["init", "--quiet"]);
    git(&["add", "."]);
    git(&["commit", "--quiet", "--message", "Toy"]);
    git(&["rev-parse", "HEAD"])
}

#[test]
fn two_revisions_are_built_recorded_compared_and_cleaned_up() {
    let folder = tempfile::tempdir().unwrap();
    let (before, after) = (commit_toy(folder.path(), 7, None), commit_toy(folder.path(), 8, None));
    let compare = |base: &str, new: &str, code: i32| {
        let mut command = perf(&["compare", "--rev", base, "--rev", new, "--without-instructions"]);
        said(command.current_dir(folder.path()), code)
    };
    assert_has(&compare(&before, &after, 1), &["Regressed: toy: lcp_pivots."]);
    assert_has(&compare(&before, &before, 0), &["No regression."]);
    let mut git = std::process::Command::new("git");
    let left = git.current_dir(folder.path()).args(["worktree", "list"]).output().unwrap().stdout;
    assert_eq!(String::from_utf8(left).unwrap().lines().count(), 1);
    assert!(!folder.path().join("results").exists(), "a comparison of revisions writes no history");
    // Built once: a second comparison needs no compiler.
    let mut again = perf(&["compare", "--rev", &before, "--rev", &after, "--without-instructions"]);
    assert_has(&said(again.current_dir(folder.path()).env("CARGO", "no-such-cargo"), 1), &["Regressed: toy"]);
}

/// Which function it is says callgrind, which the comparison asks itself: a base may be older than the question.
#[test]
fn the_function_that_changed_between_two_revisions_is_named() {
    if let Err(why) = find_valgrind() {
        println!("skipped: {why}");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let commits = [100_000, 120_000, 120_100].map(|count| commit_toy(folder.path(), 7, Some(count)));
    let compare = |base: &str, new: &str, code: i32| {
        said(perf(&["compare", "--rev", base, "--rev", new]).current_dir(folder.path()), code)
    };
    let slower = compare(&commits[0], &commits[1], 1);
    assert_has(&slower, &["Regressed: toy: instructions.", "function that changed most"]);
    let named = slower.lines().find(|line| line.contains("spin")).unwrap_or_else(|| panic!("{slower}"));
    assert!(named.starts_with("| toy | `rimbench::spin"), "{named}");
    // Within the fence of builds nothing has changed.
    assert!(!compare(&commits[1], &commits[2], 0).contains("function that changed"));
}
