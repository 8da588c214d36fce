//! `rimbench paper`: the technical report as a PDF, its numbers read from stored results.

use super::print;
use clap::Args;
use rimbench::atomic_file::{check_writable_file, write_atomically};
use rimbench::error::{Error, Result};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The source, from the project's folder.
const SOURCE: &str = "paper/paper.typ";
/// What sets it by the Python package of Typst.
const BUILD: &str = "paper/build.py";
/// Where the typeface of the figures is.
const TYPEFACE: &str = "crates/rimbench-figures/src/font";

/// Arguments of `paper`.
#[derive(Debug, Args)]
pub struct Paper {
    /// The file to write
    #[arg(long, value_name = "FILE.pdf", default_value = "results/paper/paper.pdf")]
    out: PathBuf,
}

impl Paper {
    pub(super) fn run(self) -> anyhow::Result<()> {
        if !Path::new(SOURCE).is_file() {
            return Err(Error::file(SOURCE, "not here: call `rimbench paper` from the folder of the project").into());
        }
        check_writable_file(&self.out)?;
        let folder = tempfile::tempdir()?;
        let made = folder.path().join("paper.pdf");
        set(&made)?;
        let pdf = fs::read(&made).map_err(|error| Error::file(SOURCE, format!("was not set: {error}")))?;
        write_atomically(&self.out, |file| file.write_all(&pdf))?;
        print(&format!("{} ({:.2} MB)", self.out.display(), pdf.len() as f64 / 1e6))
    }
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
