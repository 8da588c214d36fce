//! A folder of numbers keyed by content: what was computed once need not be computed again.

use sha2::{Digest, Sha256};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Marks a file as ours, with the version of its layout.
const MAGIC: &[u8; 8] = b"rimref01";

/// Files named by the hash of their key, with a checksum inside. A cache that cannot be read or written is no error:
/// the numbers are computed again.
#[derive(Debug, Clone)]
pub struct Cache {
    folder: PathBuf,
}

impl Cache {
    /// The cache in `folder`.
    pub fn in_folder(folder: impl AsRef<Path>) -> Self {
        Cache { folder: folder.as_ref().to_owned() }
    }

    /// The user's cache: `$RIMBENCH_CACHE`, else `$XDG_CACHE_HOME/rimbench`, else `~/.cache/rimbench`, else a folder for
    /// temporary files.
    pub fn of_user() -> Self {
        let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let folder = variable("RIMBENCH_CACHE")
            .or_else(|| variable("XDG_CACHE_HOME").map(|base| base.join("rimbench")))
            .or_else(|| variable("HOME").map(|home| home.join(".cache").join("rimbench")))
            .unwrap_or_else(|| std::env::temp_dir().join("rimbench-cache"));
        Cache { folder }
    }

    /// Reads the numbers stored under `key`; nothing if there are none or the file is damaged.
    pub fn read(&self, key: &str) -> Option<Vec<f64>> {
        let bytes = fs::read(self.path(key)).ok()?;
        let rest = bytes.strip_prefix(MAGIC)?;
        let (checksum, payload) = rest.split_at_checked(32)?;
        if Sha256::digest(payload).as_slice() != checksum {
            return None;
        }
        let numbers = payload.chunks_exact(8).map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap_or_default()));
        Some(numbers.collect())
    }

    /// Stores numbers under `key`, whole or not at all.
    pub fn write(&self, key: &str, numbers: &[f64]) {
        let payload: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let store = || -> std::io::Result<()> {
            fs::create_dir_all(&self.folder)?;
            let mut file = tempfile::NamedTempFile::new_in(&self.folder)?;
            file.write_all(MAGIC)?;
            file.write_all(&Sha256::digest(&payload))?;
            file.write_all(&payload)?;
            file.persist(self.path(key)).map(|_| ()).map_err(|error| error.error)
        };
        // Losing the cache costs time, not results.
        let _ = store();
    }

    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{}.bin", hex(&Sha256::digest(key))))
    }
}

/// Lower-case hexadecimal text of a digest.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_to_the_bit_and_damage_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(folder.path().join("not-yet-there"));
        let numbers = [1.0, -0.0, f64::INFINITY, f64::MIN_POSITIVE, 0.1 + 0.2];
        assert_eq!(cache.read("key"), None);
        cache.write("key", &numbers);
        let back = cache.read("key").unwrap();
        assert_eq!(back.map_bits(), numbers.map_bits());
        assert_eq!(cache.read("another key"), None);
        let path = cache.path("key");
        let mut bytes = fs::read(&path).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(&path, bytes).unwrap();
        assert_eq!(cache.read("key"), None);
    }

    trait Bits {
        fn map_bits(&self) -> Vec<u64>;
    }

    impl<T: AsRef<[f64]>> Bits for T {
        fn map_bits(&self) -> Vec<u64> {
            self.as_ref().iter().map(|x| x.to_bits()).collect()
        }
    }
}
