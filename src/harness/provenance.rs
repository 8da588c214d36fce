//! Where a result comes from: source revision, dependencies, compiler, machine.

use super::cache::hex;
use sha2::{Digest, Sha256};
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Where a result comes from. Machine-dependent, therefore kept apart from the results.
#[derive(Debug)]
pub struct Provenance {
    /// Git revision of the source, or `unknown`.
    pub git_revision: String,
    /// Whether the source had changes that are not in that revision.
    pub git_dirty: String,
    /// SHA-256 of the lock file that was built, 16 digits.
    pub lock_hash: String,
    /// Version of this package.
    pub version: &'static str,
    /// Compiler.
    pub rustc: &'static str,
    /// Processor.
    pub cpu: String,
    load: Mutex<Load>,
}

/// Load of the machine over the last minute, as text, and when it was read.
#[derive(Debug)]
struct Load {
    text: String,
    read: Instant,
}

/// Columns of `provenance.csv`.
pub(super) const HEADER: [&str; 8] =
    ["run_id", "git_revision", "git_dirty", "lock_hash", "version", "rustc", "cpu", "load_1_min"];

impl Provenance {
    /// Of this program, here and now.
    pub fn collect() -> Self {
        let dirty = git(&["status", "--porcelain", "--untracked-files=no", "--", ".", ":!results"]);
        Provenance {
            git_revision: git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_else(|| "unknown".to_owned()),
            git_dirty: dirty.map_or("unknown".to_owned(), |changes| (!changes.is_empty()).to_string()),
            lock_hash: hex(&Sha256::digest(include_bytes!("../../Cargo.lock")))[..16].to_owned(),
            version: env!("CARGO_PKG_VERSION"),
            rustc: env!("RIMBENCH_RUSTC"),
            load: Mutex::new(Load { text: load(), read: Instant::now() }),
            cpu: cpu_model().unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
        }
    }

    /// The row of one run.
    pub(super) fn row(&self, run_id: &str) -> [String; 8] {
        [
            run_id.to_owned(),
            self.git_revision.clone(),
            self.git_dirty.clone(),
            self.lock_hash.clone(),
            self.version.to_owned(),
            self.rustc.to_owned(),
            self.cpu.clone(),
            self.load(),
        ]
    }

    /// The machine says anew every few seconds what its load is; asking for each run would cost more than the answer is worth.
    fn load(&self) -> String {
        let mut held = self.load.lock().unwrap_or_else(PoisonError::into_inner);
        if held.read.elapsed() > Duration::from_secs(1) {
            *held = Load { text: load(), read: Instant::now() };
        }
        held.text.clone()
    }
}

/// Load of the machine over the last minute, where it tells.
fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split(' ').next().unwrap_or_default().to_owned()
}

/// Asks git about the folder this package was built from; nothing if it cannot answer.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").arg("-C").arg(env!("CARGO_MANIFEST_DIR")).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn cpu_model() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    line.split_once(':').map(|(_, model)| model.trim().to_owned())
}
