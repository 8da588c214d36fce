//! Bakes in what the program is built from (source revision, compiler, target and its processor) and the list of the
//! experiments that it carries.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What the program is made of; whether anything else differs from the revision does not matter.
const SOURCES: [&str; 7] = ["Cargo.toml", "Cargo.lock", "build.rs", "src", "crates", "experiments", "paper"];

fn main() {
    let (revision, dirty) = packaged().or_else(checked_out).unwrap_or_else(|| ("unknown".into(), "unknown".into()));
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let facts = [
        ("RIMBENCH_GIT_REVISION", revision),
        ("RIMBENCH_GIT_DIRTY", dirty),
        ("RIMBENCH_RUSTC", said_by(Command::new(rustc).arg("--version")).unwrap_or_else(|| "unknown".into())),
        ("RIMBENCH_TARGET", std::env::var("TARGET").unwrap_or_else(|_| "unknown".into())),
        ("RIMBENCH_TARGET_CPU", target_cpu()),
        ("RIMBENCH_BUILD_SETTINGS", settings()),
    ];
    for (name, value) in facts {
        println!("cargo::rustc-env={name}={value}");
    }
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
    }
    list_experiments();
}

/// Writes the experiments as a list of path and text, `experiments.rs` in the folder for generated sources.
fn list_experiments() {
    let (Some(root), Some(out)) = (std::env::var_os("CARGO_MANIFEST_DIR"), std::env::var_os("OUT_DIR")) else { return };
    let mut files = Vec::new();
    list(Path::new("experiments"), &mut files);
    // experiments/<group>/<name>.toml; a file beside the groups is no experiment.
    files.retain(|file| file.iter().count() == 3 && file.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    let entry = |file: &PathBuf| {
        // Forward slashes everywhere, as in the names of results.
        let name = file.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/");
        format!("    ({name:?}, include_str!({:?})),\n", Path::new(&root).join(file))
    };
    let text = format!("&[\n{}]\n", files.iter().map(entry).collect::<String>());
    if let Err(error) = std::fs::write(Path::new(&out).join("experiments.rs"), text) {
        println!("cargo::error=the list of experiments cannot be written: {error}");
    }
}

fn list(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() { list(&path, files) } else { files.push(path) }
    }
}

/// The processor that the compiler was told to build for (`-C target-cpu`), else `generic`.
fn target_cpu() -> String {
    println!("cargo::rerun-if-env-changed=CARGO_ENCODED_RUSTFLAGS");
    let flags = std::env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    // The flags stand one by one, the value with its option or after it; the last one holds.
    let mut cpus =
        flags.split('\u{1f}').filter_map(|flag| flag.strip_prefix("-C").unwrap_or(flag).strip_prefix("target-cpu="));
    cpus.next_back().unwrap_or("generic").to_owned()
}

/// Profile, and what environment and flags change of it: instructions compare only between builds that are alike.
/// Settings of the profile in `Cargo.toml` belong to the revision.
fn settings() -> String {
    const CHANGES: [&str; 7] = [
        "CARGO_INCREMENTAL",
        "CARGO_PROFILE_RELEASE_CODEGEN_UNITS",
        "CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS",
        "CARGO_PROFILE_RELEASE_INCREMENTAL",
        "CARGO_PROFILE_RELEASE_LTO",
        "CARGO_PROFILE_RELEASE_OPT_LEVEL",
        "CARGO_PROFILE_RELEASE_PANIC",
    ];
    let changed = CHANGES.iter().filter_map(|name| {
        println!("cargo::rerun-if-env-changed={name}");
        std::env::var(name).ok().map(|value| format!(" {name}={value}"))
    });
    let flags = std::env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default().replace('\u{1f}', " ");
    let profile = std::env::var("PROFILE").unwrap_or_default();
    format!("{profile}{} {flags}", changed.collect::<String>()).trim_end().to_owned()
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
