//! Tells the program which compiler built it, for which target, and from which sources of the numerical rooms.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Rooms that the digits of a reference depend on.
const NUMERICAL_ROOMS: [&str; 7] =
    ["complementarity", "interface_model", "cosim", "mechanics", "models", "cases", "harness/reference.rs"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=src");
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = Command::new(rustc).arg("--version").output().ok();
    let version = version.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    println!("cargo::rustc-env=RIMBENCH_RUSTC={}", version.unwrap_or_else(|| "unknown".to_owned()));
    println!("cargo::rustc-env=RIMBENCH_TARGET={}", std::env::var("TARGET").unwrap_or_else(|_| "unknown".to_owned()));
    println!("cargo::rustc-env=RIMBENCH_NUMERICAL_SOURCES={:016x}", hash_of_sources());
}

/// Hash of the numerical sources: a cached reference is never older than the code that it came from.
fn hash_of_sources() -> u64 {
    let mut files = Vec::new();
    for room in NUMERICAL_ROOMS {
        list(&Path::new("src").join(room), &mut files);
    }
    files.sort();
    let mut hasher = DefaultHasher::new();
    for file in files {
        file.to_string_lossy().hash(&mut hasher);
        std::fs::read(&file).unwrap_or_default().hash(&mut hasher);
    }
    hasher.finish()
}

fn list(path: &Path, files: &mut Vec<PathBuf>) {
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().for_each(|entry| list(&entry.path(), files)),
        Err(_) => files.push(path.to_owned()),
    }
}
