//! What the program was built from. Only the program itself knows, so it hands it in.

use rimbench_results::checksums::sha256;

/// What the program was built from, baked in when it was built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BuildInfo {
    /// Git revision of the source, 12 digits, or `unknown`.
    pub git_revision: &'static str,
    /// Whether the source had changes that are not in that revision: `true`, `false` or `unknown`.
    pub git_dirty: &'static str,
    /// Text of the lock file.
    pub lock_file: &'static str,
    /// Version of the program.
    pub version: &'static str,
    /// Compiler.
    pub rustc: &'static str,
    /// Target triple.
    pub target: &'static str,
    /// Processor that the compiler was told to build for, or `generic`.
    pub target_cpu: &'static str,
    /// Profile, and what environment and flags of the compiler change of it.
    pub settings: &'static str,
}

impl BuildInfo {
    /// Tells one program from another by all that digits depend on: the sources, what they use, and what compiled them.
    pub(crate) fn program(&self) -> String {
        let [core, contact] = rimbench_core::SOURCES;
        let sources = [core, contact, rimbench_cases::SOURCES, rimbench_runs::SOURCES].join(" ");
        let BuildInfo { lock_file, version, rustc, target, target_cpu, settings, .. } = self;
        let all = [&*sources, lock_file, version, rustc, target, target_cpu, settings];
        sha256(all.join("\n"))
    }
}
