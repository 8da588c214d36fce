//! Checksums of a results folder: that its files are those that were written together, all of them, and as they were
//! written.
//!
//! ```text
//! <folder>/SHA256SUMS
//!     <64 hexadecimal digits>  runs.csv
//!     <64 hexadecimal digits>  traces/0123456789abcdef.csv
//!     …
//! ```
//! The format is that of `sha256sum`; `sha256sum --check SHA256SUMS` says the same as [`verify`].

use super::atomic_file::write_atomically;
use rimbench_core::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, HashSet};
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Name of the file.
pub const CHECKSUMS: &str = "SHA256SUMS";

/// Files that are named one by one.
const NAMED: usize = 3;

/// Checksums by file, relative to the folder, with `/` on every machine.
pub type Checksums = BTreeMap<String, String>;

/// SHA-256 of some bytes, in lower-case hexadecimal digits.
pub fn sha256(bytes: impl AsRef<[u8]>) -> String {
    hex(&Sha256::digest(bytes))
}

/// SHA-256 of a regular file; none if there is none, or something else in its place.
pub fn sha256_of_file(path: &Path) -> Option<String> {
    let attempt = || -> std::io::Result<String> {
        // A pipe would never answer.
        if !std::fs::metadata(path)?.is_file() {
            return Err(ErrorKind::InvalidInput.into());
        }
        let (mut file, mut hash, mut block) = (File::open(path)?, Sha256::new(), vec![0; 1 << 16]);
        loop {
            match file.read(&mut block)? {
                0 => return Ok(hex(&hash.finalize())),
                length => hash.update(&block[..length]),
            }
        }
    };
    attempt().ok()
}

/// Lower-case hexadecimal text of a digest.
pub fn hex(bytes: &[u8]) -> String {
    let digit = |half: u8| char::from(b"0123456789abcdef"[usize::from(half)]);
    bytes.iter().flat_map(|byte| [digit(byte >> 4), digit(byte & 15)]).collect()
}

/// Writes the checksums of files below a folder; a file that is not there is an error.
///
/// # Errors
/// [`Error::File`].
pub fn write(folder: &Path, files: impl IntoIterator<Item = String>) -> Result<()> {
    let mut lines = String::new();
    let mut written = HashSet::new();
    for name in files.into_iter().filter(|name| written.insert(name.clone())) {
        let path = folder.join(&name);
        let sum = sha256_of_file(&path).ok_or_else(|| Error::file(&path, "has gone while results were written"))?;
        lines += &format!("{sum}  {name}\n");
    }
    write_atomically(&folder.join(CHECKSUMS), |file| file.write_all(lines.as_bytes()))
}

/// Reads the checksums of a folder; none if there is no such file.
///
/// # Errors
/// [`Error::File`] for a file that cannot be read, or is no list of checksums.
pub fn read(folder: &Path) -> Result<Option<Checksums>> {
    let path = folder.join(CHECKSUMS);
    if path.metadata().is_ok_and(|found| !found.is_file()) {
        return Err(Error::file(path, "is no regular file"));
    }
    let text = match std::fs::read_to_string(&path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        text => text.map_err(|error| Error::file(&path, format!("cannot be read: {error}")))?,
    };
    parse(&text).map(Some).ok_or_else(|| Error::file(path, "is no list of checksums"))
}

/// Reads the text of a list of checksums; none if it is no such list, or if a name leads out of the folder.
pub fn parse(text: &str) -> Option<Checksums> {
    let line = |line: &str| {
        let (sum, name) = line.split_once("  ")?;
        let plain = !name.starts_with('/') && !name.split('/').any(|part| part == "..");
        (sum.len() == 64 && plain).then(|| (name.to_owned(), sum.to_owned()))
    };
    text.lines().map(line).collect()
}

/// Checks that a folder holds results as they were written: no file changed, none gone.
///
/// # Errors
/// [`Error::File`] naming the files that differ, or the missing list of checksums.
pub fn verify(folder: &Path) -> Result<()> {
    verify_with(folder, "runs.csv", "run the experiment again")
}

/// Does the same for a folder of another kind, which has a file `wanted`; `advice` is what to do if it is not as it was
/// written.
///
/// # Errors
/// Those of [`verify`].
pub fn verify_with(folder: &Path, wanted: &str, advice: &str) -> Result<()> {
    let sums = read(folder)?.filter(|sums| sums.contains_key(wanted)).ok_or_else(|| {
        let reason = format!("is missing or empty, so these results cannot be checked for completeness: {advice}");
        Error::file(folder.join(CHECKSUMS), reason)
    })?;
    let differs = |name: &String| match sha256_of_file(&folder.join(name)) {
        None => Some(format!("{name} is missing")),
        Some(found) => (found != sums[name]).then(|| format!("{name} has been changed")),
    };
    let different: Vec<String> = sums.keys().filter_map(differs).collect();
    if different.is_empty() {
        return Ok(());
    }
    let more = different.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(", and {more} more") } else { String::new() };
    let named = different.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    let message = format!("is not as it was written: {named}{more}; {advice}");
    Err(Error::file(folder, message))
}
