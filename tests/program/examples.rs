//! The examples run as a user would run them, in an empty folder.

use crate::program::{assert_has, cache, printed, refused, rimbench, root};
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

/// A call of an example in a folder, with the cache of the tests.
fn call(name: &str, folder: &Path, line: &str) -> Command {
    let mut command = Command::new(example(name));
    command.current_dir(folder).env("RIMBENCH_CACHE", cache()).args(line.split(' '));
    command
}

#[test]
fn a_scheme_of_ones_own_is_a_full_citizen_of_the_whole_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("hold.toml");
    std::fs::copy(root().join("examples/template/experiments/hold.toml"), &file).unwrap();
    let mine = |line: &str| printed(&mut call("template", folder.path(), line));
    assert_has(&mine("list schemes"), &["smoothed-hold"]);
    let simulated = mine("simulate --case wedge-box --scheme smoothed-hold --macro-step 5ms --duration 0.1");
    assert_has(&simulated, &["wedge-box · smoothed-hold · H = 5 ms"]);
    let limit = "limit --case linear-oscillator --scheme smoothed-hold --from 1ms --to 100ms --per-decade 3";
    assert_has(&mine(limit), &["smoothed-hold"]);
    let advice = "advise --case bouncing-ball --scheme smoothed-hold --error 50% --phases 1 --from 1ms --to 2ms";
    assert_has(&mine(advice), &["smoothed-hold", "template simulate --case bouncing-ball"]);
    assert_has(&mine("run hold.toml --out mine"), &["9 of 9 runs stored", "template report mine"]);
    assert_has(&mine("verify hold.toml --results mine"), &["1 claim: every verdict is the recorded one"]);
    mine("report mine");
    let page = std::fs::read_to_string(folder.path().join("mine/report.html")).unwrap();
    assert!(page.contains("smoothed-hold"));
    // Its code is a part of what its runs are, and of no others.
    let plan: serde_json::Value = serde_json::from_str(&mine("run hold.toml --dry-run --format json")).unwrap();
    for run in plan["runs"].as_array().unwrap() {
        assert_eq!(run["scheme_digest"].is_string(), run["scheme"] == "smoothed-hold", "{run}");
    }
    let refused = refused(rimbench().current_dir(folder.path()).args(["verify", "hold.toml", "--results", "mine"]));
    assert_has(&refused, &["unknown scheme `smoothed-hold`"]);
}

#[test]
fn a_case_of_ones_own_is_one_of_the_whole_command_line_and_goes_into_no_fmu() {
    let folder = tempfile::tempdir().unwrap();
    let mine = |line: &str| call("custom_case", folder.path(), line);
    let simulate = "simulate --case light-on-heavy --scheme nepce --duration 0.3 --format json";
    let said: serde_json::Value = serde_json::from_str(&printed(&mut mine(simulate))).unwrap();
    assert_eq!(said["outcome"], "completed");
    let digest = said["case_digest"].as_str().unwrap();
    assert!(digest.len() == 16 && said.get("scheme_digest").is_none_or(serde_json::Value::is_null), "{said}");
    let refused = refused(&mut mine("fmu --case light-on-heavy --side mechanics --out a.fmu"));
    assert_has(&refused, &["its sides come from outside"]);
}

#[test]
fn a_solver_from_outside_solves_the_problems_with_known_answers() {
    let said = printed(&mut Command::new(example("custom_solver")));
    assert!(said.lines().any(|line| line.starts_with("Murty, 2 × 2: ")), "{said}");
    assert!(said.lines().last().unwrap().starts_with("42 problems"), "{said}");
}

#[test]
fn the_profiles_of_the_crate_outside_are_those_of_the_program() {
    let profiles = |path: &str| {
        let manifest = std::fs::read_to_string(root().join(path)).unwrap();
        manifest.parse::<toml::Table>().unwrap()["profile"]["release"].clone()
    };
    assert_eq!(profiles("examples/template/Cargo.toml"), profiles("Cargo.toml"));
}

#[test]
fn a_copied_example_is_found_by_its_name() {
    let copy = root().join("examples/my_copied_case.rs");
    std::fs::copy(root().join("examples/custom_case.rs"), &copy).unwrap();
    let metadata = std::process::Command::new(env!("CARGO"))
        .current_dir(root())
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .output();
    std::fs::remove_file(copy).unwrap();
    let said = String::from_utf8(metadata.unwrap().stdout).unwrap();
    assert!(said.contains("\"my_copied_case\""), "a file beside the examples is one of them");
}
