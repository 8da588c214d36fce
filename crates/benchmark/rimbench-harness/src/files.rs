//! Making folders, with errors that name them.

use rimbench_core::error::{Error, Result};
use std::path::Path;

/// Makes a folder and those that it lies in, as far as they are not there.
///
/// # Errors
/// [`Error::File`].
pub(crate) fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|error| Error::file(folder, format!("cannot be made: {error}")))
}
