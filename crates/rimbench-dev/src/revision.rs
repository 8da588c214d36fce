//! A git revision, built in a folder of its own.

use super::measuring::Program;
use rimbench_core::error::{Error, Result};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A git repository of this package.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Repository {
    root: PathBuf,
}

/// A revision checked out in a temporary folder; removed when dropped.
#[derive(Debug)]
pub struct Checkout {
    repository: PathBuf,
    folder: PathBuf,
    revision: String,
}

impl Repository {
    /// Finds the repository around a folder.
    ///
    /// # Errors
    /// [`Error::File`] if there is none.
    pub fn around(folder: &Path) -> Result<Self> {
        let root = git(folder, &["rev-parse", "--show-toplevel"]).map_err(|error| Error::file(folder, error))?;
        Ok(Repository { root: PathBuf::from(root) })
    }

    /// The full name of a commit.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] if there is no such commit.
    pub fn resolve(&self, revision: &str) -> Result<String> {
        let commit = format!("{revision}^{{commit}}");
        git(&self.root, &["rev-parse", "--verify", "--quiet", "--end-of-options", &commit]).map_err(|_| {
            Error::invalid("--rev", revision, format!("a commit of {}: a hash, branch or tag", self.root.display()))
        })
    }

    /// Checks a commit out below `parent`, a folder for each of them.
    ///
    /// # Errors
    /// [`Error::File`] if git refuses.
    pub fn check_out(&self, commit: &str, parent: &Path) -> Result<Checkout> {
        // As many digits as data have.
        let revision: String = commit.chars().take(12).collect();
        let folder = tempfile::tempdir_in(parent).map_err(|error| Error::file(parent, error))?.keep();
        git(&self.root, &["worktree", "add", "--quiet", "--detach", &folder.to_string_lossy(), commit])
            .map_err(|error| Error::file(&folder, error))?;
        Ok(Checkout { repository: self.root.clone(), folder, revision })
    }
}

impl Checkout {
    /// Builds the program in release mode into `target`, which may be shared, and copies it beside the sources.
    ///
    /// # Errors
    /// [`Error::File`] if it does not build; the compiler's words are on the standard error.
    pub fn build(&self, target: &Path) -> Result<Program> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let wrong =
            |what: &dyn std::fmt::Display| Error::file(&self.folder, format!("revision {}: {what}", self.revision));
        let mut build = Command::new(cargo);
        build.args(["build", "--release", "--locked", "--bin", "rimbench", "--target-dir"]).arg(target);
        let status = build.current_dir(&self.folder).stdout(Stdio::null()).status();
        if !status.map_err(|error| wrong(&format!("cargo cannot be started: {error}")))?.success() {
            return Err(wrong(&"cargo build --release fails"));
        }
        let name = format!("rimbench{}", std::env::consts::EXE_SUFFIX);
        let path = self.folder.join(format!("built-{name}"));
        std::fs::copy(target.join("release").join(name), &path).map_err(|error| wrong(&error))?;
        Ok(Program { path, git_revision: self.revision.clone(), git_dirty: "false".to_owned() })
    }
}

impl Drop for Checkout {
    fn drop(&mut self) {
        // What cannot be removed is pruned by git later.
        let _ = git(&self.repository, &["worktree", "remove", "--force", &self.folder.to_string_lossy()]);
    }
}

/// Asks git, and returns what it says, or why it refuses.
fn git(folder: &Path, arguments: &[&str]) -> std::result::Result<String, String> {
    let output = Command::new("git").arg("-C").arg(folder).args(arguments).output();
    let output = output.map_err(|error| format!("git cannot be started: {error}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
}
