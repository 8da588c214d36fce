//! Where a result comes from: source revision, dependencies, compiler, machine, and whether the machine had other things to do.

use super::build_info::BuildInfo;
use super::load::{Load, Meter};
use rimbench_cases::runs::Columns;
use rimbench_results::checksums::sha256;
use std::sync::{Arc, Mutex, PoisonError};
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

/// Columns of `provenance.csv` behind the run id.
const COLUMNS: [&str; 12] = [
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

    /// Where a run was made that has just ended.
    pub(super) fn of_run(&self) -> RunOrigin {
        let load = self.load();
        let BuildInfo { git_revision, git_dirty, version, rustc, target, target_cpu, .. } = self.build;
        let others = load.others.map_or_else(String::new, |others| format!("{others:.2}"));
        let (lock_hash, cpu, governor, verdict) = (&*self.lock_hash, &*self.cpu, &*self.governor, load.verdict());
        RunOrigin(
            [
                git_revision,
                git_dirty,
                lock_hash,
                version,
                rustc,
                cpu,
                &load.one_minute,
                target,
                target_cpu,
                governor,
                &others,
                verdict,
            ]
            .map(Arc::from)
            .into(),
        )
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
