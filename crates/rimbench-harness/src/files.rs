//! Reading files and making folders, with errors that name them.

use rimbench_core::error::{Error, Result};
use std::path::Path;

/// Reads a file of text.
///
/// # Errors
/// [`Error::File`] if there is none, or it is no text.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).map_err(|error| Error::file(path, format!("cannot be read: {error}")))
}

/// Makes a folder and those that it lies in, as far as they are not there.
///
/// # Errors
/// [`Error::File`].
pub(crate) fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|error| Error::file(folder, format!("cannot be made: {error}")))
}
