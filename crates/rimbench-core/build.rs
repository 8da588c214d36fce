//! Bakes in a hash of the sources that the digits of a simulation without a scheme depend on.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};

/// Rooms of this crate that a reference is computed with.
const ROOMS: [&str; 3] = ["interface_model", "cosim", "mechanics"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let mut files = Vec::new();
    for room in ROOMS.map(|room| Path::new("src").join(room)) {
        println!("cargo::rerun-if-changed={}", room.display());
        list(&room, &mut files);
    }
    files.sort();
    let mut hasher = DefaultHasher::new();
    for file in files {
        file.to_string_lossy().hash(&mut hasher);
        std::fs::read(&file).unwrap_or_default().hash(&mut hasher);
    }
    println!("cargo::rustc-env=RIMBENCH_CORE_SOURCES={:016x}", hasher.finish());
}

fn list(path: &Path, files: &mut Vec<PathBuf>) {
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().for_each(|entry| list(&entry.path(), files)),
        Err(_) => files.push(path.to_owned()),
    }
}
