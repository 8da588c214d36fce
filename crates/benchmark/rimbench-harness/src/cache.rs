//! A folder of numbers keyed by content: what was computed once need not be computed again.

use etcetera::base_strategy::{BaseStrategy, choose_native_strategy};
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums::sha256;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Marks a file as ours, with the version of its layout: before 3 the checksum was a SHA-256.
const MAGIC: &[u8; 8] = b"rimref03";

/// What the layouts of all versions begin with.
const OURS: &[u8; 6] = b"rimref";

/// Files named by the hash of their key, with a checksum of key and content inside. A cache that cannot be read or
/// written is no error: the numbers are computed again, and [`fault`](Self::fault) says why.
#[derive(Debug)]
pub struct Cache {
    folder: PathBuf,
    fault: OnceLock<Error>,
}

impl Cache {
    /// Makes the cache in `folder`.
    pub fn in_folder(folder: impl AsRef<Path>) -> Self {
        Cache { folder: folder.as_ref().to_owned(), fault: OnceLock::new() }
    }

    /// Makes the user's cache: `$RIMBENCH_CACHE`, else `rimbench` in the system's folder for caches, else a folder for
    /// temporary files. The system's is `$XDG_CACHE_HOME` or `~/.cache` on Linux, `~/Library/Caches` on macOS and the
    /// local data of applications on Windows.
    pub fn of_user() -> Self {
        let own = std::env::var_os("RIMBENCH_CACHE").filter(|value| !value.is_empty()).map(PathBuf::from);
        let of_system = || choose_native_strategy().ok().map(|system| system.cache_dir().join("rimbench"));
        let temporary = || std::env::temp_dir().join("rimbench-cache");
        Cache::in_folder(own.or_else(of_system).unwrap_or_else(temporary))
    }

    /// What went wrong first, if anything did: without a cache references are computed again by every command.
    pub fn fault(&self) -> Option<&Error> {
        self.fault.get()
    }

    /// Reads the numbers stored under `key`; nothing if there are none, if they are of another layout, or if the file
    /// is damaged or belongs to another key.
    pub fn read(&self, key: &str) -> Option<Vec<f64>> {
        let path = self.path(key);
        let read = regular(&path).and_then(|there| if there { fs::read(&path).map(Some) } else { Ok(None) });
        let bytes = match read {
            Ok(bytes) => bytes?,
            Err(error) => {
                self.warn(&path, format!("cannot be read: {error}"));
                return None;
            }
        };
        let rest = match bytes.strip_prefix(MAGIC) {
            // Of another version: replaced as soon as the numbers are there.
            None if is_of_another_layout(&bytes) => return None,
            rest => rest,
        };
        let payload = rest.and_then(|rest| {
            let (checksum, payload) = rest.split_at_checked(HEAD - MAGIC.len())?;
            (checksum_of(key, payload) == checksum).then_some(payload)
        });
        let Some(payload) = payload else {
            self.warn(&path, "is damaged, or of another reference".to_owned());
            return None;
        };
        let (numbers, _) = payload.as_chunks();
        Some(numbers.iter().map(|number| f64::from_le_bytes(*number)).collect())
    }

    /// Stores numbers under `key`, whole or not at all.
    pub fn write(&self, key: &str, numbers: &[f64]) {
        let payload: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let path = self.path(key);
        let store = || -> Result<()> {
            let wrong = |error: std::io::Error| Error::file(&path, format!("cannot be written: {error}"));
            fs::create_dir_all(&self.folder).map_err(wrong)?;
            regular(&path).map_err(wrong)?;
            write_atomically(&path, |file| {
                file.write_all(MAGIC)?;
                file.write_all(&checksum_of(key, &payload))?;
                file.write_all(&payload)
            })
        };
        // Losing the cache costs time, not results.
        if let Err(error) = store() {
            let _ = self.fault.set(error);
        }
    }

    fn warn(&self, path: &Path, message: String) {
        let _ = self.fault.set(Error::file(path, message));
    }

    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{}.bin", sha256(key)))
    }
}

/// Whether a regular file is there; a pipe, which would never answer, or a folder is an error.
fn regular(path: &Path) -> std::io::Result<bool> {
    match fs::metadata(path) {
        Ok(found) if found.is_file() => Ok(true),
        Ok(_) => Err(std::io::Error::new(ErrorKind::InvalidInput, "it is no regular file")),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Whether a file of ours has the mark of another version.
fn is_of_another_layout(bytes: &[u8]) -> bool {
    let version = bytes.strip_prefix(OURS).and_then(|rest| rest.get(..MAGIC.len() - OURS.len()));
    version.is_some_and(|version| version < &MAGIC[OURS.len()..] && version.iter().all(u8::is_ascii_digit))
}

/// Bytes before the numbers: mark and checksum.
const HEAD: usize = 40;

/// Holds a file to its key as well as to its content: a file that was given another's name is not believed.
///
/// Against accidents, not against forgers, for less than reading the file costs: four sums, each of every fourth word
/// of 8 bytes, behind the key and both lengths. `x ↦ rot((x ⊕ word) · odd)` is one to one in either of its arguments,
/// so that one damaged word always shows.
fn checksum_of(key: &str, payload: &[u8]) -> [u8; 32] {
    const ODD: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut sums = [1, 2, 3, 4].map(|lane: u64| lane.wrapping_mul(ODD));
    let mut add = |bytes: &[u8]| {
        let (blocks, rest) = bytes.as_chunks::<32>();
        let mut last = [0; 32];
        last[..rest.len()].copy_from_slice(rest);
        for block in blocks.iter().chain([&last]) {
            for (sum, word) in sums.iter_mut().zip(block.as_chunks::<8>().0) {
                *sum = (*sum ^ u64::from_le_bytes(*word)).wrapping_mul(ODD).rotate_left(29);
            }
        }
    };
    let lengths = [key.len(), payload.len()].map(|length| (length as u64).to_le_bytes());
    add(lengths.as_flattened());
    add(key.as_bytes());
    add(payload);
    let mut checksum = [0; 32];
    for (bytes, sum) in checksum.as_chunks_mut().0.iter_mut().zip(sums) {
        *bytes = sum.to_le_bytes();
    }
    checksum
}
