//! Where a result comes from: source revision, dependencies, compiler, machine.

use super::build_info::BuildInfo;
use rimbench_results::checksums::sha256;
use rimbench_runs::Columns;
use std::sync::Arc;

/// Where a result comes from. Machine-dependent, therefore kept apart from the results.
#[derive(Debug)]
pub struct Provenance {
    /// What the program was built from.
    pub build: BuildInfo,
    /// SHA-256 of the lock file that was built, 16 digits.
    pub lock_hash: String,
    /// Processor.
    pub cpu: String,
}

/// Columns of `provenance.csv` behind the run id.
const COLUMNS: [&str; 8] =
    ["git_revision", "git_dirty", "lock_hash", "version", "rustc", "cpu", "target", "target_cpu"];

/// Where one run was made, column by column; what rows have in common is held once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RunOrigin(Arc<[Arc<str>; COLUMNS.len()]>);

impl RunOrigin {
    /// Goes through its columns.
    pub(super) fn columns(&mut self, each: Columns<'_>) {
        let mut texts = (*self.0).clone();
        COLUMNS.into_iter().zip(&mut texts).for_each(|(name, text)| each(name, text));
        if texts != *self.0 {
            self.0 = texts.into();
        }
    }
}

impl RunOrigin {
    /// Whether it is a build of this source.
    pub(super) fn is_of(&self, build: &BuildInfo) -> bool {
        [&*self.0[0], &*self.0[1]] == [build.git_revision, build.git_dirty]
    }
}

impl Provenance {
    /// Collects what is known of a program built like this, here.
    pub fn collect(build: &BuildInfo) -> Self {
        Provenance {
            build: *build,
            lock_hash: sha256(build.lock_file)[..16].to_owned(),
            cpu: cpu_model().unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
        }
    }

    /// What stands in the row of each run that is made here.
    pub(super) fn origin(&self) -> RunOrigin {
        let BuildInfo { git_revision, git_dirty, version, rustc, target, target_cpu, .. } = self.build;
        let texts = [git_revision, git_dirty, &self.lock_hash, version, rustc, &self.cpu, target, target_cpu];
        RunOrigin(texts.map(Arc::from).into())
    }
}

fn cpu_model() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    line.split_once(':').map(|(_, model)| model.trim().to_owned())
}
