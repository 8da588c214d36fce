//! What is started: the words of a command, the folder in which it runs, and a hash of what its digits depend on.

use rimbench_core::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Shortest time that a process is given for an answer, s.
const SHORTEST_ANSWER: f64 = 1e-3;

/// A command as a file gives it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CommandLine {
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
        Ok(CommandLine { folder, words: words.to_vec(), answer_within, digest })
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

fn hash_file(hash: &mut Sha256, file: &Path) -> Result<()> {
    let bytes = std::fs::read(file).map_err(|error| Error::file(file, format!("cannot be read: {error}")))?;
    hash.update(format!("{} bytes\n", bytes.len()));
    hash.update(bytes);
    Ok(())
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
