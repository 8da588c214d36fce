//! The program under test, with a cache of its own so that tests depend on nothing that was there before.

use assert_cmd::Command;
use proptest::prelude::ProptestConfig;
use serde_json::Value;
use std::collections::BTreeMap;
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

/// The project's folder.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The text of a file.
pub fn read(path: impl AsRef<Path>) -> String {
    let path = path.as_ref();
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All files below a folder, sorted; none where there is none.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(files(&path)) } else { found.push(path) }
    }
    found.sort();
    found
}

/// The path of a file below a folder.
pub fn below(folder: &Path, path: &Path) -> String {
    path.strip_prefix(folder).unwrap().to_string_lossy().replace('\\', "/")
}

/// Copies what lies in a folder.
pub fn copy(from: &Path, to: &Path) {
    for path in files(from) {
        let target = to.join(below(from, &path));
        std::fs::create_dir_all(target.parent().unwrap()).unwrap();
        std::fs::copy(path, target).unwrap();
    }
}

/// The rows of a table, each by the names of its columns.
pub fn rows_of(path: impl AsRef<Path>) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

/// Writes a program of one shell script.
#[cfg(unix)]
pub fn stand_in(path: &Path, script: &str) {
    use std::os::unix::fs::PermissionsExt;
    std::fs::write(path, format!("#!/bin/sh\n{script}\n")).unwrap();
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
}

/// How often a property is tried that takes long: more often where `PROPTEST_CASES` is set, as in `.ci/all`.
pub fn often(usual: u32, at_length: u32) -> ProptestConfig {
    let cases = if std::env::var_os("PROPTEST_CASES").is_some() { at_length } else { usual };
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
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
