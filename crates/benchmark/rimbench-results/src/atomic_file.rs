//! Output files: every file that a user can name is written here, and nowhere else.
//!
//! What stands under a name decides how it is written:
//!
//! | under the name | what happens |
//! |---|---|
//! | nothing, or a regular file | a temporary file in the same folder is filled and renamed: whole or not at all |
//! | a link | the same with what the link leads to; the link stays |
//! | a pipe or a device | it is opened and written to; it stays what it is |
//! | the standard output or error (`/dev/stdout`, say) | it goes there, in turn with what is printed |
//! | a folder | an error |

use rimbench_core::error::{Error, Result};
use std::collections::HashSet;
use std::fs::OpenOptions;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

const TEMPORARY: &str = ".rimbench-";

/// What this process holds open, by number; shells name pipes so.
const OPEN_FILES: &str = "/dev/fd";

/// Links that are followed before they count as a circle, as the kernel does.
const MOST_LINKS: usize = 40;

/// Where the bytes of an output go.
#[derive(Debug, PartialEq, Eq)]
enum Target {
    /// A regular file, there or not, links resolved.
    File(PathBuf),
    /// A pipe, a device or the like.
    Stream,
    /// The standard output of this process.
    StandardOutput,
    /// The standard error of this process.
    StandardError,
}

/// Writes an output: a regular file through a temporary one in the same folder, which is renamed when it is complete;
/// anything else in place. A reader that closes a pipe early is no error.
///
/// # Errors
/// [`Error::File`] naming the path; nothing is left behind then, and what stood there before still does.
pub fn write_atomically(path: &Path, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<()> {
    let written = match target(path)? {
        Target::File(file) => replace(&file, fill),
        // Neither created nor truncated: whatever is there stays what it is.
        Target::Stream => OpenOptions::new().write(true).open(path).and_then(|out| write_through(out, fill)),
        Target::StandardOutput => write_through(std::io::stdout().lock(), fill),
        Target::StandardError => write_through(std::io::stderr().lock(), fill),
    };
    let written = match written {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written,
    };
    written.map_err(|error| cannot_be_written(path, &error))
}

/// An error of writing a file; the name of the temporary one is of no use.
fn cannot_be_written(path: &Path, error: &std::io::Error) -> Error {
    let error = error.to_string();
    let error = error.split(" at path \"").next().unwrap_or_default();
    Error::file(path, format!("cannot be written: {error}"))
}

/// Checks, before anything is computed, that [`write_atomically`] will be able to write here. Makes no folder and opens
/// no pipe.
///
/// # Errors
/// [`Error::File`] if it is a folder, or lies in none that can be written to.
pub fn check_writable_file(path: &Path) -> Result<()> {
    let Target::File(file) = target(path)? else { return Ok(()) };
    let folder = folder_of(&file);
    if !folder.is_dir() {
        return Err(Error::file(path, format!("cannot be written: there is no folder {}", folder.display())));
    }
    temporary_in(folder).map(drop).map_err(|error| cannot_be_written(path, &error))
}

/// Makes a folder if need be and checks that a file can be put into it.
///
/// # Errors
/// [`Error::File`] if not.
pub fn check_writable_folder(folder: &Path) -> Result<()> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    std::fs::create_dir_all(folder)
        .and_then(|()| temporary_in(folder).map(drop))
        .map_err(|error| Error::file(folder, format!("no file can be written here: {error}")))
}

/// Finds out what stands under a name.
fn target(path: &Path) -> Result<Target> {
    let wrong = |message: &str| Err(Error::file(path, message));
    let mut file = path.to_owned();
    for _ in 0..MOST_LINKS {
        match std::fs::symlink_metadata(&file) {
            Ok(found) if found.is_symlink() && (file.starts_with("/proc") || file.starts_with(OPEN_FILES)) => {
                return Ok(of_process(&file));
            }
            Ok(found) if found.is_symlink() => match std::fs::read_link(&file) {
                // Relative to the folder of the link; an absolute one replaces the whole.
                Ok(next) => file = folder_of(&file).join(next),
                Err(error) => return wrong(&format!("cannot be written: its link cannot be read: {error}")),
            },
            Ok(found) if found.is_dir() => return wrong("is a folder; the name of a file is needed"),
            Ok(found) if found.is_file() => return Ok(Target::File(file)),
            Ok(_) => return Ok(Target::Stream),
            // What cannot even be looked at is said when it is written.
            Err(_) if file.file_name().is_some() => return Ok(Target::File(file)),
            Err(_) => return wrong("is no name of a file"),
        }
    }
    wrong("cannot be written: its links lead in a circle")
}

/// What an entry of a process stands for: such links lead to what the process holds open, not to a name.
fn of_process(link: &Path) -> Target {
    let own = link.starts_with("/proc/self") || link.starts_with(OPEN_FILES);
    match link.file_name().and_then(|name| name.to_str()) {
        Some("1") if own => Target::StandardOutput,
        Some("2") if own => Target::StandardError,
        _ => Target::Stream,
    }
}

/// The folder that a file lies in.
fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn replace(file: &Path, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> std::io::Result<()> {
    let mut writer = BufWriter::new(temporary_in(folder_of(file))?);
    fill(&mut writer)?;
    let temporary = writer.into_inner().map_err(std::io::IntoInnerError::into_error)?;
    give_permissions(temporary.as_file(), file)?;
    temporary.persist(file).map(|_| ()).map_err(|error| error.error)
}

fn write_through(out: impl Write, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> std::io::Result<()> {
    let mut writer = BufWriter::new(out);
    fill(&mut writer)?;
    writer.flush()
}

/// A temporary file of this process. What killed processes have left in the folder goes when it is first written to.
fn temporary_in(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    static SWEPT: Mutex<Option<HashSet<PathBuf>>> = Mutex::new(None);
    let first = || {
        let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
        swept.get_or_insert_default().insert(folder.to_owned())
    };
    if first() {
        sweep_temporary_files(folder);
    }
    tempfile::Builder::new().prefix(&prefix()).tempfile_in(folder)
}

/// First part of the name of this process's temporary files.
fn prefix() -> String {
    format!("{TEMPORARY}{}-", std::process::id())
}

/// Removes temporary files that a killed process has left in a folder; those of living processes stay.
fn sweep_temporary_files(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let process =
            name.to_str().and_then(|name| name.strip_prefix(TEMPORARY)).and_then(|rest| rest.split('-').next());
        let number = process.filter(|process| process.parse::<u32>().is_ok());
        if number.is_some_and(|process| !is_alive(process)) {
            // What cannot be removed does no harm.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Whether a process is running, as far as one can know: where there is no `/proc`, it may be.
fn is_alive(process: &str) -> bool {
    let processes = Path::new("/proc");
    !processes.join("self").exists() || processes.join(process).exists()
}

/// A file that is replaced keeps its permissions; a new one can be read by all, as results should be (temporary ones
/// are private).
#[cfg(unix)]
fn give_permissions(temporary: &std::fs::File, file: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    let own = std::fs::metadata(file).map(|found| found.permissions());
    temporary.set_permissions(own.unwrap_or_else(|_| std::fs::Permissions::from_mode(0o644)))
}

#[cfg(not(unix))]
fn give_permissions(_temporary: &std::fs::File, _file: &Path) -> std::io::Result<()> {
    Ok(())
}
