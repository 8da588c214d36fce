//! The program under test, with a cache of its own so that tests depend on nothing that was there before.

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command as Process;

/// The part of an experiment that says what runs: two sets of the wedge box, a hold, and this scheme beside it.
macro_rules! two_sets_with {
    ($scheme:literal) => {
        concat!(
            r#"
[[cases]]
name = "wedge-box"
set = { box_mass_kg = [200.0, 210.0] }

[[schemes]]
scheme = "zero-order-hold"

[[schemes]]
scheme = ""#,
            $scheme,
            "\"\n"
        )
    };
}
pub(crate) use two_sets_with;

/// Takes a file apart, each line with its end.
pub fn lines(bytes: &[u8]) -> Vec<Vec<u8>> {
    bytes.split_inclusive(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect()
}

/// Returns the cache of references that all tests share.
pub fn cache() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache")
}

/// Prepares a call of the program, to be asserted.
pub fn rimbench() -> Command {
    let mut command = Command::cargo_bin("rimbench").unwrap();
    command.env("RIMBENCH_CACHE", cache());
    command
}

/// Prepares a call by a line of words, in none of which there is a space.
pub fn call(line: &str) -> Command {
    let mut command = rimbench();
    command.args(line.split_whitespace());
    command
}

/// What a command prints that succeeds.
pub fn printed(command: &mut Command) -> String {
    String::from_utf8(command.assert().success().get_output().stdout.clone()).unwrap()
}

/// The same, of one that prints JSON.
pub fn json(command: &mut Command) -> Value {
    serde_json::from_str(&printed(command)).unwrap()
}

/// What a command prints and says that ends with this code.
pub fn said(command: &mut Command, code: i32) -> String {
    let output = command.assert().code(code).get_output().clone();
    String::from_utf8([output.stdout, output.stderr].concat()).unwrap()
}

/// What a command says of bad input: an error with exit code 2, and nothing else.
pub fn refused(command: &mut Command) -> String {
    let output = command.assert().code(2).get_output().clone();
    assert!(output.stdout.is_empty(), "nothing but the error: {}", String::from_utf8_lossy(&output.stdout));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.starts_with("error: "), "{message}");
    message
}

/// Each line of words, behind those that all have, is refused in these words.
pub fn assert_refused(all: &str, table: &[(&str, &str)]) {
    for (line, wanted) in table {
        let message = refused(&mut call(&format!("{all} {line}")));
        assert!(message.contains(wanted), "{line}: {message}");
    }
}

/// All of this stands in a text.
#[track_caller]
pub fn assert_has(text: &str, wanted: &[&str]) {
    for wanted in wanted {
        assert!(text.contains(wanted), "{wanted}: {text}");
    }
}

/// Prepares a call of the program, to be left running.
pub fn process() -> Process {
    let mut process = Process::new(executable());
    process.env("RIMBENCH_CACHE", cache());
    process
}

/// Returns where the program lies.
pub fn executable() -> PathBuf {
    assert_cmd::cargo::cargo_bin("rimbench")
}
