//! Files appear whole or not at all.

use rimbench_core::error::{Error, Result};
use std::io::{BufWriter, Write};
use std::path::Path;

const TEMPORARY: &str = ".rimbench-";

/// Writes a file through a temporary one in the same folder, which is renamed when it is complete.
///
/// # Errors
/// [`Error::File`] naming the path; nothing is left behind then.
pub fn write_atomically(path: &Path, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<()> {
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let attempt = || -> std::io::Result<()> {
        let file = tempfile::Builder::new().prefix(&prefix()).tempfile_in(folder)?;
        let mut writer = BufWriter::new(file);
        fill(&mut writer)?;
        let file = writer.into_inner().map_err(std::io::IntoInnerError::into_error)?;
        readable_by_all(file.as_file())?;
        file.persist(path).map(|_| ()).map_err(|error| error.error)
    };
    attempt().map_err(|error| Error::file(path, format!("cannot be written: {error}")))
}

/// Makes a folder if need be and checks that a file can be put into it.
///
/// # Errors
/// [`Error::File`] if not.
pub fn check_writable_folder(folder: &Path) -> Result<()> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    std::fs::create_dir_all(folder)
        .and_then(|()| tempfile::Builder::new().prefix(&prefix()).tempfile_in(folder).map(drop))
        .map_err(|error| Error::file(folder, format!("no file can be written here: {error}")))
}

/// First part of the name of this process's temporary files.
fn prefix() -> String {
    format!("{TEMPORARY}{}-", std::process::id())
}

/// Removes temporary files that a killed process has left in a folder; those of living processes stay.
pub fn sweep_temporary_files(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let process =
            name.to_str().and_then(|name| name.strip_prefix(TEMPORARY)).and_then(|rest| rest.split('-').next());
        if process.is_some_and(|process| !is_alive(process)) {
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

/// Temporary files are private by default; results are not.
#[cfg(unix)]
fn readable_by_all(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable_by_all(_file: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}
