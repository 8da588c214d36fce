//! The program under test, with a cache of its own so that tests depend on nothing that was there before.

use assert_cmd::Command;
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
