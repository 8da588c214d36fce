//! The examples run as a user would run them, on a shipped experiment, into an empty folder.

use crate::program::{printed, root};
use assert_cmd::Command;
use std::path::{Path, PathBuf};

/// An example as `cargo test` builds it: `target/<profile>/examples`, two floors above this test's own program. A run
/// of this test alone does not build examples; then they are built now.
fn example(name: &str) -> PathBuf {
    let own = std::env::current_exe().unwrap();
    let profile = own.parent().and_then(Path::parent).unwrap();
    let program = profile.join("examples").join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    if !program.is_file() {
        let mut build = Command::new(env!("CARGO"));
        build.current_dir(env!("CARGO_MANIFEST_DIR")).args(["build", "--quiet", "--offline", "--example", name]);
        if profile.ends_with("release") {
            build.arg("--release");
        }
        build.assert().success();
    }
    program
}

fn run(name: &str, experiment: &Path) -> String {
    let results = tempfile::tempdir().unwrap();
    let [group, file] = [experiment.parent().unwrap(), experiment].map(|path| path.file_stem().unwrap());
    let mut command = Command::new(example(name));
    let printed = printed(command.current_dir(root()).arg(results.path()).arg(experiment));
    assert!(results.path().join(group).join(file).join("runs.csv").is_file());
    printed
}

/// Completed and planned runs of each line of a case and a scheme: one for each macro step.
fn lines_of(table: &str, case: &str, scheme: &str) -> Vec<(usize, usize)> {
    let words = |line: &'_ str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let own = table
        .lines()
        .map(words)
        .filter(|line| line.len() > 3 && line[0] == case && line[1] == scheme && line[3].contains('/'));
    let counts = own.map(|line| {
        let (completed, runs) = line[3].split_once('/').unwrap();
        (completed.parse().unwrap(), runs.parse().unwrap())
    });
    counts.collect()
}

#[test]
fn a_scheme_of_ones_own_stands_beside_the_built_in_ones() {
    let table = run("custom_scheme", Path::new("experiments/paper/fig2.toml"));
    // It is no better than the hold it is made from, and its failures are shown.
    assert_eq!(lines_of(&table, "wedge-box", "zero-order-hold"), [(0, 1)]);
    assert_eq!(lines_of(&table, "wedge-box", "smoothed-hold"), [(0, 1)]);
    assert_eq!(lines_of(&table, "wedge-box", "rim-nonsmooth-gap"), [(1, 1)]);
}

#[test]
fn a_case_of_ones_own_is_run_by_every_scheme_of_an_experiment() {
    // The first tenths of ten seconds are enough.
    let folder = tempfile::tempdir().unwrap();
    let shipped = root().join("experiments/published/oscillator.toml");
    let short = folder.path().join("oscillator.toml");
    std::fs::write(&short, format!("duration_s = 0.3\n{}", std::fs::read_to_string(shipped).unwrap())).unwrap();
    let table = run("custom_case", &short);
    let own = lines_of(&table, "light-on-heavy", "zero-order-hold");
    assert!(own.iter().any(|(done, _)| *done > 0), "{table}");
    // The cases of the experiment stand beside it, each of the six sets of parameters in lines of its own.
    assert_eq!(lines_of(&table, "linear-oscillator", "zero-order-hold").len(), 6 * own.len(), "{table}");
}

#[test]
fn a_solver_from_outside_solves_the_problems_with_known_answers() {
    let said = printed(&mut Command::new(example("custom_solver")));
    assert!(said.lines().any(|line| line.starts_with("Murty, 2 × 2: ")), "{said}");
    assert!(said.lines().last().unwrap().starts_with("42 problems"), "{said}");
}

#[test]
fn a_copied_example_is_found_by_its_name() {
    let copy = root().join("examples/my_copied_scheme.rs");
    std::fs::copy(root().join("examples/custom_scheme.rs"), &copy).unwrap();
    let metadata = std::process::Command::new(env!("CARGO"))
        .current_dir(root())
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .output();
    std::fs::remove_file(copy).unwrap();
    let said = String::from_utf8(metadata.unwrap().stdout).unwrap();
    assert!(said.contains("\"my_copied_scheme\""), "a file beside the examples is one of them");
}
