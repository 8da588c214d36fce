//! Files that a user names to be read: regular ones only, since a pipe or a device would never end, and of a size that
//! makes sense.

use rimbench_core::error::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Most that a file of text may hold, bytes.
const MOST_TEXT: u64 = 1 << 26;

/// Checks that what stands under a name, if anything does, is a regular file: a pipe would wait for a writer as soon as
/// it is opened.
///
/// # Errors
/// [`Error::File`] if not.
pub fn check_regular(path: &Path) -> Result<()> {
    match path.metadata() {
        Ok(found) if !found.is_file() => Err(Error::file(path, "is no regular file")),
        _ => Ok(()),
    }
}

/// Says where a file is that another one names: in the folder of that one. Of one that is a link it is the folder of
/// what the link names, and if the file is not there, that of the link.
pub fn beside(file: &Path, name: &Path) -> PathBuf {
    let in_folder_of = |file: &Path| file.parent().unwrap_or(Path::new("")).join(name);
    let here = in_folder_of(file);
    let real = if file.is_symlink() { file.canonicalize().ok() } else { None };
    real.map(|real| in_folder_of(&real)).filter(|there| there.exists() || !here.exists()).unwrap_or(here)
}

/// Says what is odd about a path of which nothing is there: in double quotes of TOML a backslash begins an escape, and
/// in a path it separates folders on Windows alone; empty where nothing is.
pub fn path_hint(path: &Path) -> &'static str {
    let text = path.to_string_lossy();
    if text.contains(char::is_control) {
        "; it has a control character, as a backslash in double quotes makes one: write a path with `/`, or in single quotes"
    } else if !cfg!(windows) && text.contains('\\') {
        "; a backslash separates no folders here: write a path with `/`"
    } else {
        ""
    }
}

/// Reads a regular file of at most `most` bytes.
///
/// # Errors
/// [`Error::File`] if it cannot be read, is no regular file, or is larger.
pub fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>> {
    let wrong = |error: std::io::Error| Error::file(path, format!("cannot be read: {error}{}", path_hint(path)));
    check_regular(path)?;
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(most + 1).read_to_end(&mut bytes)).map_err(wrong)?;
    if bytes.len() as u64 > most {
        return Err(Error::file(path, format!("is larger than {most} bytes")));
    }
    Ok(bytes)
}

/// Reads a regular file of text.
///
/// # Errors
/// [`Error::File`] if it cannot be read, is no regular file, is larger than 64 MiB, or is no text.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read_bytes(path, MOST_TEXT)?).map_err(|error| {
        let (good, bytes) = (error.utf8_error().valid_up_to(), error.as_bytes());
        let line = 1 + bytes[..good].iter().filter(|byte| **byte == b'\n').count();
        let wrong = bytes.get(good).copied().unwrap_or_default();
        Error::file(path, format!("is no text in UTF-8: line {line} has the byte {wrong:#04x}"))
    })
}
