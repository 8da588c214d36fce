//! FMUs that the program writes of both sides of a case, and the case file that makes a case of them again.

use crate::program::{copy, rimbench};
use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Read, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use tempfile::TempDir;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// The columns of a carriage's motion and of the force on it.
pub const CARRIAGE: [&str; 3] = ["interface_position_m", "interface_velocity_m_s", "actuator_force_n"];

/// A folder with both sides of a case as FMUs, `mechanics.fmu` and `actuator.fmu`, which are written once for all
/// tests.
pub fn exported(case: &str, more: &[&str]) -> TempDir {
    static WRITTEN: Mutex<BTreeMap<Vec<String>, TempDir>> = Mutex::new(BTreeMap::new());
    let folder = tempfile::tempdir().unwrap();
    let mut written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
    let key = [case].iter().chain(more).map(|word| (*word).to_owned()).collect();
    let once = written.entry(key).or_insert_with(|| {
        let once = tempfile::tempdir().unwrap();
        for side in ["mechanics", "actuator"] {
            let out = once.path().join(format!("{side}.fmu"));
            rimbench().args(["fmu", "--case", case, "--side", side, "--out"]).arg(out).args(more).assert().success();
        }
        once
    });
    copy(once.path(), folder.path());
    folder
}

/// What a case file says of two FMUs that have their coupling variables by the names of columns.
pub fn case_file(columns: [&str; 3], head: &str) -> String {
    let [position, velocity, force] = columns;
    let ends = format!("position = \"{position}\"\nvelocity = \"{velocity}\"\nforce = \"{force}\"\n");
    format!(
        "name = \"of-fmus\"\n{head}\n[mechanics]\nfmu = \"mechanics.fmu\"\n[actuator]\nfmu = \"actuator.fmu\"\n[[interface]]\n\
         columns = {columns:?}\n[interface.mechanics]\n{ends}[interface.actuator]\n{ends}"
    )
}

/// The files of an archive, changed and packed again.
pub fn repacked(from: &Path, to: &Path, change: impl Fn(&str, Vec<u8>) -> Option<(String, Vec<u8>)>) {
    let mut archive = ZipArchive::new(Cursor::new(fs::read(from).unwrap())).unwrap();
    let mut out = ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..archive.len() {
        let mut file = archive.by_index(index).unwrap();
        let (name, mut bytes) = (file.name().unwrap().into_owned(), Vec::new());
        file.read_to_end(&mut bytes).unwrap();
        if let Some((name, bytes)) = change(&name, bytes) {
            let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
            out.start_file(name, options.unix_permissions(0o755)).unwrap();
            out.write_all(&bytes).unwrap();
        }
    }
    fs::write(to, out.finish().unwrap().into_inner()).unwrap();
}

/// A file of an FMU, its library replaced by something that is none.
pub fn without_library(name: &str, bytes: Vec<u8>) -> Option<(String, Vec<u8>)> {
    let bytes = if name.starts_with("binaries") { b"no library".to_vec() } else { bytes };
    Some((name.to_owned(), bytes))
}
