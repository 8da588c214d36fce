//! What other programs read: plans and records as JSON.

use crate::program::rimbench;
use serde_json::{Value, json};

pub fn said(arguments: &[&str]) -> String {
    crate::program::printed(rimbench().args(arguments))
}

fn said_json(arguments: &[&str]) -> Value {
    crate::program::json(rimbench().args(arguments))
}

/// Commands that the program offers, as its help lists them.
pub fn commands() -> Vec<String> {
    let help = said(&["--help"]);
    let lines = help
        .lines()
        .take_while(|line| !line.starts_with("Options:"))
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    lines.filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
}

const PLAIN: &str = r#"
question = "?"
macro_steps_s = [1e-3]
[[cases]]
name = "wedge-box"
set = { box_mass_kg = [150.0, 200.0] }
[[schemes]]
scheme = "rim-nonsmooth"
mechanics_steps = "all"
contact_detection = "margin:1e-3"
"#;

#[test]
fn a_plan_as_json_has_every_run_with_its_id_and_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("one.toml");
    std::fs::write(&path, PLAIN).unwrap();
    let plan = said_json(&["run", path.to_str().unwrap(), "--dry-run", "--format", "json"]);
    let runs = plan["runs"].as_array().unwrap();
    assert_eq!((runs.len(), plan["experiment"].as_str()), (2, Some("one")));
    for (place, run) in runs.iter().enumerate() {
        assert_eq!(run["place"], place);
        assert_eq!((run["run_id"].as_str().unwrap().len(), &run["scheme"]), (16, &json!("rim-nonsmooth")));
    }
    assert_ne!(runs[0]["run_id"], runs[1]["run_id"]);
}

#[test]
fn each_shell_has_completions_of_every_command_and_flag() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let text = said(&["completions", shell]);
        for word in commands().iter().map(String::as_str).chain(["contact-detection", "figure-keys"]) {
            assert!(text.contains(word), "{shell}: {word}");
        }
    }
}

/// A part of the gate that runs out of time is red in the end, and the parts after it are run.
#[cfg(unix)]
#[test]
fn a_part_of_the_gate_that_takes_too_long_is_no_skip() {
    let gate = crate::program::read(crate::program::root().join(".ci/run"));
    let part = |from: &str, to: &str| gate[gate.find(from).unwrap()..].split_inclusive(to).next().unwrap().to_owned();
    let (optional, end) = (part("late=\"\"\n", "\n}\n"), &gate[gate.find("if [ -n \"$late\"").unwrap()..]);
    for (seconds, code) in [("0.1", 1), ("9", 0)] {
        let script = format!(
            "set -euo pipefail\ntimes=''\n{optional}optional {seconds} slow sleep 1\noptional 9 next echo on\n{end}"
        );
        let output = std::process::Command::new("bash").args(["-c", &script]).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{output:?}");
        assert!(String::from_utf8_lossy(&output.stdout).contains("on\n"), "{output:?}");
    }
}
