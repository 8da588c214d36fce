//! `rimbench report --pdf`: the technical report as a PDF, its numbers read from stored results.

use super::print;
use rimbench::atomic_file::{check_writable_file, write_atomically};
use rimbench::error::{Error, Result};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::process::Command;

/// The source, from the project's folder.
const SOURCE: &str = "paper/paper.typ";
/// What sets it by the Python package of Typst.
const BUILD: &str = "paper/build.py";
/// Where the typeface of the figures is.
const TYPEFACE: &str = "crates/presentation/rimbench-figures/src/font";

/// Sets the report as a PDF in the file `out`.
pub(super) fn set_pdf(out: &Path) -> anyhow::Result<()> {
    if !Path::new(SOURCE).is_file() {
        let message = "not here: call `rimbench report --pdf` from the folder of the project";
        return Err(Error::file(SOURCE, message).into());
    }
    check_writable_file(out)?;
    let folder = tempfile::tempdir()?;
    let made = folder.path().join("paper.pdf");
    set(&made)?;
    let pdf = fs::read(&made).map_err(|error| Error::file(SOURCE, format!("was not set: {error}")))?;
    write_atomically(out, |file| file.write_all(&pdf))?;
    print(&format!("{} ({:.2} MB)", out.display(), pdf.len() as f64 / 1e6))
}

/// Sets the source with what is installed: `typst`, or the Python package of that name.
///
/// # Errors
/// [`Error::File`] with what the compiler says of the source, [`Error::Incompatible`] if neither is there.
fn set(out: &Path) -> Result<()> {
    let mut typst = Command::new("typst");
    typst.args([
        "compile",
        "--root",
        ".",
        "--ignore-system-fonts",
        "--font-path",
        TYPEFACE,
        "--pdf-standard",
        "ua-1",
        SOURCE,
    ]);
    if called(typst.arg(out))? {
        return Ok(());
    }
    let has_package =
        Command::new("python3").args(["-c", "import typst"]).output().is_ok_and(|said| said.status.success());
    if has_package && called(Command::new("python3").arg(BUILD).arg(out))? {
        return Ok(());
    }
    Err(Error::Incompatible(format!(
        "{SOURCE} is set by Typst 0.15 or later, which is not installed: `pip install typst`, or the program `typst` \
         (https://typst.app); then call this again, or `python3 {BUILD} FILE.pdf`"
    )))
}

/// Calls a program; returns false if there is none of that name.
fn called(command: &mut Command) -> Result<bool> {
    match command.output() {
        Ok(said) if said.status.success() => Ok(true),
        Ok(said) => {
            Err(Error::file(SOURCE, format!("cannot be set: {}", String::from_utf8_lossy(&said.stderr).trim())))
        }
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(Error::file(SOURCE, format!("cannot be set: {error}"))),
    }
}
