//! A folder of numbers keyed by content: what was computed once need not be computed again.

use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums::sha256;
use sha2::{Digest, Sha256};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Marks a file as ours, with the version of its layout.
const MAGIC: &[u8; 8] = b"rimref02";

/// Files named by the hash of their key, with a checksum of key and content inside. A cache that cannot be read or written is no
/// error: the numbers are computed again, and [`fault`](Self::fault) says why.
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

    /// Makes the user's cache: `$RIMBENCH_CACHE`, else `$XDG_CACHE_HOME/rimbench`, else `~/.cache/rimbench`, else a
    /// folder for temporary files.
    pub fn of_user() -> Self {
        let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let folder = variable("RIMBENCH_CACHE")
            .or_else(|| variable("XDG_CACHE_HOME").map(|base| base.join("rimbench")))
            .or_else(|| variable("HOME").map(|home| home.join(".cache").join("rimbench")))
            .unwrap_or_else(|| std::env::temp_dir().join("rimbench-cache"));
        Cache::in_folder(folder)
    }

    /// What went wrong first, if anything did: without a cache references are computed again by every command.
    pub fn fault(&self) -> Option<&Error> {
        self.fault.get()
    }

    /// Reads the numbers stored under `key`; nothing if there are none or the file is damaged, or belongs to another key.
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
        let payload = bytes.strip_prefix(MAGIC).and_then(|rest| {
            let (checksum, payload) = rest.split_at_checked(32)?;
            (checksum_of(key, payload) == checksum).then_some(payload)
        });
        let Some(payload) = payload else {
            self.warn(&path, "is damaged, or of another reference".to_owned());
            return None;
        };
        let numbers = payload.chunks_exact(8).map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap_or_default()));
        Some(numbers.collect())
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

/// Holds a file to its key as well as to its content: a file that was given another's name is not believed.
fn checksum_of(key: &str, payload: &[u8]) -> [u8; 32] {
    let mut hash = Sha256::new();
    hash.update(Sha256::digest(key));
    hash.update(payload);
    hash.finalize().into()
}
