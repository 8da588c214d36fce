//! Where a result comes from: source revision, dependencies, compiler, machine.

use super::build_info::BuildInfo;
use super::cache::hex;
use sha2::{Digest, Sha256};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Where a result comes from. Machine-dependent, therefore kept apart from the results.
#[derive(Debug)]
pub struct Provenance {
    /// What the program was built from.
    pub build: BuildInfo,
    /// SHA-256 of the lock file that was built, 16 digits.
    pub lock_hash: String,
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
    /// Of a program built like this, here and now.
    pub fn collect(build: &BuildInfo) -> Self {
        Provenance {
            build: *build,
            lock_hash: hex(&Sha256::digest(build.lock_file))[..16].to_owned(),
            load: Mutex::new(Load { text: load(), read: Instant::now() }),
            cpu: cpu_model().unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
        }
    }

    /// The row of one run.
    pub(super) fn row(&self, run_id: &str) -> [String; 8] {
        [
            run_id.to_owned(),
            self.build.git_revision.to_owned(),
            self.build.git_dirty.to_owned(),
            self.lock_hash.clone(),
            self.build.version.to_owned(),
            self.build.rustc.to_owned(),
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

fn cpu_model() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    line.split_once(':').map(|(_, model)| model.trim().to_owned())
}
