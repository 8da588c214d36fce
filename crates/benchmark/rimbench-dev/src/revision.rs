//! Records of git revisions, each built in a folder of its own.

use super::comparison::{Comparison, REBUILT, compare};
use super::history::{History, Row};
use super::measuring::{changed_functions, profiles};
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Builds two commits of the repository around a folder, one after the other and alike, lets each record its suite, and
/// compares the two; `options` go to its `perf record`. Of benchmarks whose instructions changed callgrind names the
/// functions.
///
/// # Errors
/// [`Error::File`] if there is no repository, if a revision does not build, or if it is too old to record;
/// [`Error::InvalidValue`] if there is no such commit.
pub fn compare_revisions(folder: &Path, revisions: [&str; 2], options: &[String]) -> Result<Comparison> {
    let root = git(folder, &["rev-parse", "--show-toplevel"]).map_err(|error| Error::file(folder, error))?;
    let resolve = |revision: &str| {
        let commit = format!("{revision}^{{commit}}");
        let found = git(root.as_ref(), &["rev-parse", "--verify", "--quiet", "--end-of-options", &commit]);
        found.map_err(|_| Error::invalid("--rev", revision, format!("a commit of {root}: a hash, branch or tag")))
    };
    let commits = [resolve(revisions[0])?, resolve(revisions[1])?];
    let scratch = tempfile::tempdir().map_err(|error| Error::file("temporary folder", error))?;
    let programs = ["base", "new"].map(|name| scratch.path().join(name));
    let recorded = |index: usize| {
        Checkout::of(root.as_ref(), &commits[index], scratch.path())?.record(scratch.path(), &programs[index], options)
    };
    let mut comparison = compare(&recorded(0)?, &recorded(1)?, REBUILT)?;
    let changed: Vec<String> = comparison.changed().map(str::to_owned).collect();
    for benchmark in changed {
        let (base, new) = (profiles(&programs[0], &benchmark)?, profiles(&programs[1], &benchmark)?);
        let functions = changed_functions([&base, &new]).into_iter().map(|function| (benchmark.clone(), function));
        comparison.functions.extend(functions);
    }
    Ok(comparison)
}

/// A revision checked out in a temporary folder; removed when dropped.
struct Checkout {
    repository: PathBuf,
    folder: PathBuf,
}

impl Checkout {
    fn of(repository: &Path, commit: &str, scratch: &Path) -> Result<Checkout> {
        let folder = tempfile::tempdir_in(scratch).map_err(|error| Error::file(scratch, error))?.keep();
        git(repository, &["worktree", "add", "--quiet", "--detach", &folder.to_string_lossy(), commit])
            .map_err(|error| Error::file(&folder, error))?;
        Ok(Checkout { repository: repository.to_owned(), folder })
    }

    /// Builds it, keeps its program, and lets that record.
    fn record(self, scratch: &Path, program: &Path, options: &[String]) -> Result<Vec<Row>> {
        let (target, history) = (scratch.join("target"), self.folder.join("history.csv"));
        let mut build = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        build.args(["build", "--release", "--locked", "--bin", "rimbench", "--target-dir"]).arg(&target);
        self.run(&mut build)?;
        let built = target.join("release").join(format!("rimbench{}", std::env::consts::EXE_SUFFIX));
        let failed = |error: std::io::Error| Error::file(&built, format!("cannot be kept: {error}"));
        let bytes = std::fs::read(&built).map_err(failed)?;
        write_atomically(program, |file| file.write_all(&bytes))?;
        let permissions = built.metadata().map_err(failed)?.permissions();
        std::fs::set_permissions(program, permissions).map_err(failed)?;
        let mut record = Command::new(program);
        self.run(record.args(["perf", "record", "--history"]).arg(&history).args(options))?;
        Ok(History::read(&history)?.rows)
    }

    /// Runs a command in the folder; what it complains of is on the standard error.
    fn run(&self, command: &mut Command) -> Result<()> {
        let program = command.get_program().to_string_lossy().into_owned();
        match command.current_dir(&self.folder).stdout(Stdio::null()).status() {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(Error::file(&self.folder, format!("`{program}` fails: {status}"))),
            Err(error) => Err(Error::file(&self.folder, format!("`{program}` cannot be started: {error}"))),
        }
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
