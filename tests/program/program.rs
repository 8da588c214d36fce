//! The program under test, with a cache of its own so that tests depend on nothing that was there before.

use assert_cmd::Command;
use std::path::{Path, PathBuf};
use std::process::Command as Process;

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
