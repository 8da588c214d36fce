//! Bakes in what the program is built from: source revision, compiler, target.

use std::path::Path;
use std::process::Command;

/// What the program is made of; whether anything else differs from the revision does not matter.
const SOURCES: [&str; 5] = ["Cargo.toml", "Cargo.lock", "build.rs", "src", "crates"];

fn main() {
    let (revision, dirty) = packaged().or_else(checked_out).unwrap_or_else(|| ("unknown".into(), "unknown".into()));
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let facts = [
        ("RIMBENCH_GIT_REVISION", revision),
        ("RIMBENCH_GIT_DIRTY", dirty),
        ("RIMBENCH_RUSTC", said_by(Command::new(rustc).arg("--version")).unwrap_or_else(|| "unknown".into())),
        ("RIMBENCH_TARGET", std::env::var("TARGET").unwrap_or_else(|_| "unknown".into())),
    ];
    for (name, value) in facts {
        println!("cargo::rustc-env={name}={value}");
    }
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
    }
}

/// Revision and state of a package from a registry, which says so in a file.
fn packaged() -> Option<(String, String)> {
    let text = std::fs::read_to_string(".cargo_vcs_info.json").ok()?;
    let revision = text.split_once("\"sha1\"")?.1.split('"').nth(1)?;
    Some((revision.chars().take(12).collect(), text.contains("\"dirty\": true").to_string()))
}

/// Revision and state of the repository around this folder.
fn checked_out() -> Option<(String, String)> {
    // Written to at every commit, checkout and reset.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    if Path::new(&log).exists() {
        println!("cargo::rerun-if-changed={log}");
    }
    let revision = git(&["rev-parse", "--short=12", "HEAD"])?;
    let changes = git(&[&["status", "--porcelain", "--untracked-files=no", "--"][..], &SOURCES].concat())?;
    Some((revision, (!changes.is_empty()).to_string()))
}

fn git(arguments: &[&str]) -> Option<String> {
    said_by(Command::new("git").args(arguments))
}

/// What a program says, if it can be asked and has no complaint.
fn said_by(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
