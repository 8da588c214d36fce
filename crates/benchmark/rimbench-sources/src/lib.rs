//! For build scripts: bakes in a hash of the sources that digits depend on; texts that lie among them have no part in it.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};

/// Sets the variable `name` of the crate that is built to a hash of files and folders below its `src`.
pub fn bake(name: &str, rooms: &[&str]) {
    println!("cargo::rerun-if-changed=build.rs");
    let mut files = Vec::new();
    for room in rooms.iter().map(|room| Path::new("src").join(room)) {
        println!("cargo::rerun-if-changed={}", room.display());
        list(&room, &mut files);
    }
    files.sort();
    let mut hasher = DefaultHasher::new();
    for file in files {
        file.to_string_lossy().hash(&mut hasher);
        std::fs::read(&file).unwrap_or_default().hash(&mut hasher);
    }
    println!("cargo::rustc-env={name}={:016x}", hasher.finish());
}

fn list(path: &Path, files: &mut Vec<PathBuf>) {
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().for_each(|entry| list(&entry.path(), files)),
        Err(_) if path.extension().is_some_and(|extension| extension == "md") => {}
        Err(_) => files.push(path.to_owned()),
    }
}
