//! Benchmark of non-iterative co-simulation of mechanical systems with contact.
//!
//! A *co-simulation* splits a system into subsystems, each with its own solver. They exchange coupling variables at
//! communication points `t_k`, a macro step `H` apart, and never go back. Between communication points each side must
//! guess what the other is doing; where contacts open and close meanwhile, the guess can be badly wrong. This library
//! runs any coupling scheme over any case through one macro loop, and measures stability, energy drift, accuracy and
//! cost against fine-step references.
//!
//! # Rooms
//! This package is the program, with what it carries ([`shipped`]); its rooms live in packages of their own, shown here
//! together. Each uses only those below it, and the compiler sees to that.
//!
//! | package | rooms | what they hold |
//! |---|---|---|
//! | `rimbench-dev` | [`perf`] | performance tracker |
//! | `rimbench-fmi` | [`fmi`] | sides of cases as FMUs for others, FMUs of others as sides of cases |
//! | `rimbench-figures` | [`figures`] | figures and the report, from result files; never simulates |
//! | `rimbench-harness` | [`harness`] | experiment file → plan → runs → result files |
//! | `rimbench-results` | [`atomic_file`], [`results_table`], [`budget`], [`checksums`], [`claims`], [`kept`], [`trace`] | files written whole or not at all, read back by column name, checked |
//! | `rimbench-runs` | [`runs`], [`catalogue`], [`metrics`] | one run, and what is measured of it |
//! | `rimbench-cases` | [`cases`], [`models`], [`parameter`] | what is simulated |
//! | `rimbench-statistics` | [`statistics`] | the table of runs: selection, pools, medians, intervals, orders |
//! | `rimbench-core` | [`schemes`], [`iterative`], [`mechanics`], [`cosim`], [`interface_model`], [`name`], [`error`] | the simulation itself |
//! | `rimbench-contact` | [`affine_step`], [`contact_law`], [`friction`], [`complementarity`], [`linear_algebra`] | contact problems and their solvers |
//!
//! # Symbols
//! | symbol | unit | meaning |
//! |---|---|---|
//! | `H`, `φ`, `δ`, `h` | s, –, s, s | macro step, communication phase, micro step, step of the mechanics |
//! | `u`, `y` | | inputs and outputs of a subsystem, the coupling variables |
//! | `q`, `v` | m, m/s (rad, rad/s) | positions and velocities of a mechanical system |
//! | `λ_i`, `w_i`, `s` | N, m/s, m | interface force, velocity, coordinate |
//! | `g`, `w_u`, `P_u` | m, m/s, N·s | gaps, contact velocities, contact impulses |
//! | `M`, `A_x`, `H_xy` | kg, –, 1/kg | mass matrix, Jacobians, the interface model; see [`interface_model`] |
//!
//! Raoofian, Kövecses, Teichmann, "Non-smooth Reduced Interface Models for Co-simulation of Mechanical Systems", is
//! "the paper" throughout; what is marked *ours* is this project's own choice.

// The commands name this crate as any other does.
extern crate self as rimbench;

/// What the standard macro of this name does, but a reader that closed the pipe is no panic.
macro_rules! eprintln {
    ($($arguments:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($arguments)*);
    }};
}

mod cli;
pub mod shipped;

pub use cli::parts_of_error;

pub use rimbench_cases::{cases, models, parameter};
pub use rimbench_core::{
    affine_step, complementarity, contact_law, cosim, error, friction, interface_model, iterative, known_problems,
    linear_algebra, mechanics, name, numerics_version, schemes, solver_entry,
};
pub use rimbench_dev as perf;
pub use rimbench_figures as figures;
pub use rimbench_fmi as fmi;
pub use rimbench_harness as harness;
pub use rimbench_results::{
    atomic_file, budget, checksums, claims, input, kept, results_table, run_table, selection, trace,
};
pub use rimbench_runs as runs;
pub use rimbench_runs::{catalogue, metrics};
pub use rimbench_statistics as statistics;

/// What this program was built from.
pub const BUILD: harness::BuildInfo = harness::BuildInfo {
    git_revision: env!("RIMBENCH_GIT_REVISION"),
    git_dirty: env!("RIMBENCH_GIT_DIRTY"),
    lock_file: include_str!("../Cargo.lock"),
    version: env!("CARGO_PKG_VERSION"),
    rustc: env!("RIMBENCH_RUSTC"),
    target: env!("RIMBENCH_TARGET"),
    target_cpu: env!("RIMBENCH_TARGET_CPU"),
    settings: env!("RIMBENCH_BUILD_SETTINGS"),
};

/// Everything that this program can run by name.
///
/// # Errors
/// None; what is built in has different names.
pub fn everything() -> error::Result<catalogue::Catalogue> {
    Ok(catalogue::Catalogue::standard())
}

/// Is the command line over a catalogue: that of [`everything`], or one with cases, schemes and solvers added to it.
/// Returns the exit code, 2 for bad input, said in one clear error, and 1 for a check that did not hold, or a run that
/// gave no answer.
///
/// What was added and has no digest of its own has that of the file of this program, so that runs of other code have
/// other ids.
///
/// ```no_run
/// # use rimbench::schemes::SchemeEntry;
/// # fn entry() -> SchemeEntry { unimplemented!() }
/// fn main() -> std::process::ExitCode {
///     rimbench::main(rimbench::everything().and_then(|mut catalogue| {
///         catalogue.add_scheme(entry())?;
///         Ok(catalogue)
///     }))
/// }
/// ```
pub fn main(catalogue: error::Result<catalogue::Catalogue>) -> std::process::ExitCode {
    let cli = cli::Cli::read();
    match catalogue.map_err(Into::into).and_then(|catalogue| cli.run(catalogue)) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("{}", cli::error_text(&format!("{error:#}")));
            cli::exit_code(&error)
        }
    }
}

/// Compiles and runs the programs that the documents show.
#[cfg(doctest)]
mod documents {
    #[doc = include_str!("../docs/guide/library.md")]
    struct Library;
    #[doc = include_str!("../docs/guide/own-case.md")]
    struct OwnCase;
}
