//! Where a result comes from: source revision, dependencies, compiler, machine, and whether the machine had other things to do.

use super::build_info::BuildInfo;
use super::load::{Load, Meter};
use rimbench_results::checksums::sha256;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Where a result comes from. Machine-dependent, therefore kept apart from the results.
#[derive(Debug)]
pub struct Provenance {
    /// What the program was built from.
    pub build: BuildInfo,
    /// SHA-256 of the lock file that was built, 16 digits.
    pub lock_hash: String,
    /// Processor.
    pub cpu: String,
    /// How its frequency is governed (`performance`, `powersave`, …); empty where the machine does not tell.
    pub governor: String,
    meter: Mutex<Meter>,
}

/// Columns of `provenance.csv`.
pub(super) const HEADER: [&str; 13] = [
    "run_id",
    "git_revision",
    "git_dirty",
    "lock_hash",
    "version",
    "rustc",
    "cpu",
    "load_1_min",
    "target",
    "target_cpu",
    "governor",
    "other_load",
    "machine_load",
];

impl Provenance {
    /// Collects what is known of a program built like this, here and now.
    pub fn collect(build: &BuildInfo) -> Self {
        Provenance {
            build: *build,
            lock_hash: sha256(build.lock_file)[..16].to_owned(),
            // The machine says anew now and then what its load is; asking for each run would cost more than the answer is worth.
            meter: Mutex::new(Meter::start(Duration::from_secs(1))),
            cpu: cpu_model().unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            governor: governor(),
        }
    }

    /// The row of one run that has just ended.
    pub(super) fn row(&self, run_id: &str) -> [String; 13] {
        let load = self.load();
        [
            run_id.to_owned(),
            self.build.git_revision.to_owned(),
            self.build.git_dirty.to_owned(),
            self.lock_hash.clone(),
            self.build.version.to_owned(),
            self.build.rustc.to_owned(),
            self.cpu.clone(),
            load.one_minute.clone(),
            self.build.target.to_owned(),
            self.build.target_cpu.to_owned(),
            self.governor.clone(),
            load.others.map_or_else(String::new, |others| format!("{others:.2}")),
            load.verdict().to_owned(),
        ]
    }

    /// The load of the machine by now.
    pub fn load(&self) -> Load {
        self.meter.lock().unwrap_or_else(PoisonError::into_inner).read()
    }
}

fn governor() -> String {
    let path = "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor";
    std::fs::read_to_string(path).unwrap_or_default().trim().to_owned()
}

fn cpu_model() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    line.split_once(':').map(|(_, model)| model.trim().to_owned())
}
