//! What is started: the words of a command, the folder in which it runs, and a hash of what its digits depend on.

use rimbench_core::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::fs::{File, metadata};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Shortest time that a process is given for an answer, s.
const SHORTEST_ANSWER: f64 = 1e-3;

/// A command as a file gives it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CommandLine {
    /// The file that names it.
    pub(super) file: PathBuf,
    /// In which it runs: that of the file that names it.
    pub(super) folder: PathBuf,
    pub(super) words: Vec<String>,
    pub(super) answer_within: Duration,
    /// Hash of its words, of those that are files in the folder, and of the other files that are named.
    pub(crate) digest: String,
}

impl CommandLine {
    /// Checks a command that stands in the file `path`, with further `files` that its digits depend on.
    ///
    /// # Errors
    /// No words; files that cannot be read.
    pub(crate) fn new(path: &Path, words: &[String], files: &[PathBuf], answer_within: Duration) -> Result<Self> {
        let wrong = |message: String| Error::file(path, message);
        if words.first().is_none_or(|word| word.trim().is_empty()) {
            return Err(wrong(
                "command has no words; valid: a list of a program and its arguments, [\"python3\", \"x.py\"]".into(),
            ));
        }
        if let Some(word) = words.iter().find(|word| word.contains('\0')) {
            return Err(wrong(format!("command has {word:?}; valid: words without a zero in them")));
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = folder.canonicalize().map_err(|error| wrong(format!("its folder cannot be found: {error}")))?;
        let mut hash = Sha256::new();
        for word in words {
            hash.update(format!("word {}\n{word}\n", word.len()));
            let file = folder.join(word);
            if file.is_file() {
                hash_file(&mut hash, &file)?;
            }
        }
        for file in files {
            hash.update(format!("file {}\n", file.display()));
            hash_file(&mut hash, &folder.join(file))?;
        }
        let digest = hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
        Ok(CommandLine { file: path.to_owned(), folder, words: words.to_vec(), answer_within, digest })
    }

    /// Where the program is: a word with a slash in it is a file of the folder, any other is looked for on the path.
    pub(super) fn program(&self) -> PathBuf {
        let word = &self.words[0];
        if word.contains(['/', '\\']) { self.folder.join(word) } else { word.into() }
    }
}

impl std::fmt::Display for CommandLine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.words.join(" "))
    }
}

/// Hashes a file, of whatever length, in blocks.
fn hash_file(hash: &mut Sha256, file: &Path) -> Result<()> {
    let wrong = |error: std::io::Error| Error::file(file, format!("cannot be read: {error}"));
    let found = metadata(file).map_err(wrong)?;
    // A pipe would never answer, and a device never end.
    if !found.is_file() {
        let what = if found.is_dir() { "is a folder" } else { "is no regular file" };
        return Err(Error::file(file, format!("{what}; valid: files that can be read again")));
    }
    hash.update(format!("{} bytes\n", found.len()));
    // What grows while it is read is read as far as was said.
    let mut file_read = File::open(file).map_err(wrong)?.take(found.len());
    let mut block = vec![0; 1 << 16];
    loop {
        match file_read.read(&mut block).map_err(wrong)? {
            0 => return Ok(()),
            length => hash.update(&block[..length]),
        }
    }
}

/// Reads how long a process may take for an answer.
///
/// # Errors
/// In words, what is no such time.
pub(crate) fn answer_within(seconds: f64) -> Result<Duration> {
    if seconds.is_finite() && seconds >= SHORTEST_ANSWER {
        return Ok(Duration::from_secs_f64(seconds.min(1e9)));
    }
    Err(Error::invalid("answer_within_s", seconds, format!("a finite time of at least {SHORTEST_ANSWER} s")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digest_is_of_files_and_nothing_else_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scheme.toml");
        let data = folder.path().join("data");
        let digest = |files: &[&str]| {
            let files: Vec<PathBuf> = files.iter().map(PathBuf::from).collect();
            CommandLine::new(&file, &["cat".to_owned()], &files, Duration::ZERO).map(|command| command.digest)
        };
        // More than one block.
        let mut bytes = vec![7; 200_000];
        std::fs::write(&data, &bytes).unwrap();
        let before = digest(&["data"]).unwrap();
        assert_eq!(digest(&["data"]).unwrap(), before);
        bytes[150_000] = 8;
        std::fs::write(&data, &bytes).unwrap();
        assert_ne!(digest(&["data"]).unwrap(), before);
        for (name, words) in [("none", "cannot be read"), (".", "is a folder"), ("/dev/zero", "is no regular file")] {
            let message = digest(&[name]).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
    }
}
