//! Exact instruction counts by valgrind's callgrind.

use super::sample::Program;
use rimbench_core::error::{Error, Result};
use std::path::Path;
use std::process::Command;

/// Tells whether valgrind can be started.
///
/// # Errors
/// Why not, in words: a note, not a failure.
pub fn find(valgrind: &Path) -> std::result::Result<(), String> {
    match Command::new(valgrind).arg("--version").output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(_) => Err(format!("{} --version fails: no instruction counts", valgrind.display())),
        Err(error) => Err(format!("{} is not there ({error}): no instruction counts", valgrind.display())),
    }
}

/// Counts the instructions of one repetition: the process with two repetitions, minus the process with one, so that start,
/// preparation and first touch drop out.
///
/// # Errors
/// [`Error::File`] if the program fails under valgrind.
pub fn instructions(valgrind: &Path, program: &Program, benchmark: &str) -> Result<u64> {
    let [one, two] = [1, 2].map(|repetitions| total(valgrind, &program.path, benchmark, repetitions));
    let (one, two) = (one?, two?);
    two.checked_sub(one).filter(|count| *count > 0).ok_or_else(|| {
        Error::file(valgrind, format!("{benchmark}: {two} instructions with two repetitions, {one} with one"))
    })
}

fn total(valgrind: &Path, program: &Path, benchmark: &str, repetitions: u32) -> Result<u64> {
    let wrong = |what: &dyn std::fmt::Display| Error::file(valgrind, format!("callgrind of {benchmark}: {what}"));
    let folder = tempfile::tempdir().map_err(|error| wrong(&error))?;
    let out = folder.path().join("callgrind.out");
    let output = Command::new(valgrind)
        .arg("--tool=callgrind")
        .arg(format!("--callgrind-out-file={}", out.display()))
        .arg(program)
        .args(["perf", "sample", benchmark, "--untimed", "--repetitions", &repetitions.to_string()])
        .output()
        .map_err(|error| wrong(&error))?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr);
        return Err(wrong(&message.lines().last().unwrap_or("failed without a word")));
    }
    let text = std::fs::read_to_string(&out).map_err(|error| wrong(&error))?;
    parse_total(&text).ok_or_else(|| wrong(&"no total in its output"))
}

/// Reads the total from a callgrind output file (`totals:`, in older versions `summary:`).
pub fn parse_total(text: &str) -> Option<u64> {
    let value = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.trim().parse().ok());
    value("totals:").or_else(|| value("summary:"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_is_read_from_either_line() {
        assert_eq!(parse_total("events: Ir\nsummary: 7\nfn=x\n\ntotals: 1234\n"), Some(1234));
        assert_eq!(parse_total("events: Ir\nsummary: 7\n"), Some(7));
        assert_eq!(parse_total("events: Ir\n"), None);
    }

    #[test]
    fn a_missing_valgrind_is_a_note() {
        let note = find(Path::new("/no/such/valgrind")).unwrap_err();
        assert!(note.contains("no instruction counts"), "{note}");
    }
}
