//! Records of git revisions, each built in a folder of its own.

use super::comparison::{Comparison, REBUILT, compare};
use super::history::{History, Row};
use super::measuring::{changed_functions, profiles};
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums::sha256;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What is built of a commit, and what its program is asked.
#[derive(Debug, Clone, Copy)]
pub struct Build<'a> {
    /// A folder of the package.
    pub folder: &'a Path,
    /// The name of its program.
    pub program: &'a str,
    /// What else its builds depend on, which no commit says: rimbench itself, where it is elsewhere.
    pub depends_on: &'a str,
    /// Options of `perf record`.
    pub options: &'a [String],
    /// Those that say which runs there are to record.
    pub suite: &'a [String],
}

/// Builds two commits of the repository around a folder, one after the other and alike, lets each record its suite, and
/// compares the two. Programs are kept in `target/perf`, by commit, compiler and its settings. Of benchmarks whose
/// instructions changed callgrind names the functions.
///
/// # Errors
/// [`Error::File`] if there is no repository, if a revision does not build, or if it is too old to record;
/// [`Error::InvalidValue`] if there is no such commit.
pub fn compare_revisions(build: Build<'_>, revisions: [&str; 2]) -> Result<Comparison> {
    let ask = |question| git(build.folder, &["rev-parse", question]).map_err(|error| Error::file(build.folder, error));
    let (root, within) = (PathBuf::from(ask("--show-toplevel")?), PathBuf::from(ask("--show-prefix")?));
    let resolve = |revision: &str| {
        let commit = format!("{revision}^{{commit}}");
        let found = git(&root, &["rev-parse", "--verify", "--quiet", "--end-of-options", &commit]);
        let expected = || format!("a commit of {}: a hash, branch or tag", root.display());
        found.map_err(|_| Error::invalid("--rev", revision, expected()))
    };
    let commits = [resolve(revisions[0])?, resolve(revisions[1])?];
    let scratch = tempfile::tempdir().map_err(|error| Error::file("temporary folder", error))?;
    let kept = root.join(&within).join("target/perf");
    let mut programs = Vec::with_capacity(2);
    for commit in &commits {
        let program = kept.join(format!("{}-{}", &commit[..12], key_of(build, commit)));
        if !program.is_file() {
            std::fs::create_dir_all(&kept).map_err(|error| Error::file(&kept, error))?;
            Checkout::of(&root, commit, scratch.path())?.build(build, (&within, scratch.path()), &program)?;
        }
        programs.push(program);
    }
    let recorded = |index: usize| -> Result<Vec<Row>> {
        let history = scratch.path().join(format!("{index}.csv"));
        let mut record = Command::new(&programs[index]);
        record.args(["perf", "record", "--history"]).arg(&history).args(build.options).args(build.suite);
        run_in(build.folder, &mut record)?;
        let mut rows = History::read(&history)?.rows;
        rows.iter_mut().for_each(|row| row.git_revision = commits[index][..12].to_owned());
        Ok(rows)
    };
    let mut comparison = compare(&recorded(0)?, &recorded(1)?, REBUILT)?;
    let changed: Vec<String> = comparison.changed().map(str::to_owned).collect();
    for benchmark in changed {
        let [base, new] = [0, 1].map(|index| profiles((&*programs[index], build.suite), &benchmark));
        let functions = changed_functions([&base?, &new?]).into_iter().map(|function| (benchmark.clone(), function));
        comparison.functions.extend(functions);
    }
    Ok(comparison)
}

/// What tells builds of one commit apart.
fn key_of(build: Build<'_>, commit: &str) -> String {
    let said = Command::new("rustc").arg("-vV").current_dir(build.folder).output().map(|output| output.stdout);
    let mut text = format!("{commit} {} {}\n", build.program, build.depends_on);
    text += &String::from_utf8_lossy(&said.unwrap_or_default());
    let is_setting = |name: &str| name == "RUSTFLAGS" || name.starts_with("CARGO_PROFILE_");
    let mut settings: Vec<_> = std::env::vars().filter(|(name, _)| is_setting(name)).collect();
    settings.sort();
    sha256(text + &format!("{settings:?}"))[..8].to_owned()
}

/// Runs a command in a folder; what it complains of is on the standard error.
fn run_in(folder: &Path, command: &mut Command) -> Result<()> {
    let program = command.get_program().to_string_lossy().into_owned();
    match command.current_dir(folder).stdout(Stdio::null()).status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Error::file(folder, format!("`{program}` fails: {status}"))),
        Err(error) => Err(Error::file(folder, format!("`{program}` cannot be started: {error}"))),
    }
}

/// A revision checked out in a temporary folder; removed when dropped.
struct Checkout {
    repository: PathBuf,
    folder: PathBuf,
}

impl Checkout {
    /// Beside the repository if that can be, so that dependencies by a path that leads out of it are found.
    fn of(repository: &Path, commit: &str, scratch: &Path) -> Result<Checkout> {
        let beside =
            repository.parent().and_then(|parent| tempfile::Builder::new().prefix(".perf-").tempdir_in(parent).ok());
        let folder = match beside {
            Some(folder) => folder.keep(),
            None => tempfile::tempdir_in(scratch).map_err(|error| Error::file(scratch, error))?.keep(),
        };
        let checkout = Checkout { repository: repository.to_owned(), folder };
        git(repository, &["worktree", "add", "--quiet", "--detach", &checkout.folder.to_string_lossy(), commit])
            .map_err(|error| Error::file(&checkout.folder, error))?;
        Ok(checkout)
    }

    /// Builds the package that lies at a path within it, and keeps its program.
    fn build(self, build: Build<'_>, (within, scratch): (&Path, &Path), program: &Path) -> Result<()> {
        let (target, name) = (scratch.join("target"), build.program);
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.args(["build", "--release", "--locked", "--bin", name, "--target-dir"]).arg(&target);
        run_in(&self.folder.join(within), &mut cargo)?;
        let built = target.join("release").join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
        let failed = |error: std::io::Error| Error::file(&built, format!("cannot be kept: {error}"));
        let bytes = std::fs::read(&built).map_err(failed)?;
        let permissions = built.metadata().map_err(failed)?.permissions();
        write_atomically(program, |file| file.write_all(&bytes))?;
        std::fs::set_permissions(program, permissions).map_err(failed)
    }
}

impl Drop for Checkout {
    fn drop(&mut self) {
        // What cannot be removed is pruned by git later.
        let _ = git(&self.repository, &["worktree", "remove", "--force", &self.folder.to_string_lossy()]);
        let _ = std::fs::remove_dir(&self.folder);
    }
}

/// Asks git, and returns what it says, or why it refuses.
fn git(folder: &Path, arguments: &[&str]) -> std::result::Result<String, String> {
    let output = Command::new("git").arg("-C").arg(folder).args(arguments).output();
    let output = output.map_err(|error| format!("git cannot be started: {error}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
}
