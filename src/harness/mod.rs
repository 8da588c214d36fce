//! From an experiment file to runs to CSV. Files, threads and progress live here only.
//!
//! [`Experiment`] is the file, [`Experiment::plan`] makes it a list of [`RunSpec`]s, [`execute`] runs them in parallel
//! against cached [`Reference`]s, [`write_results`] puts them in a folder, and [`check_claims`] holds what the file
//! claims against what came out.

mod atomic_file;
mod cache;
mod claims;
mod evaluation;
mod execution;
mod experiment;
mod provenance;
mod reference;
mod results;
mod run;
mod spectral;

pub use atomic_file::{check_writable_folder, write_atomically};
pub use cache::Cache;
pub use claims::{CheckedClaim, Claim, Verdict, check_claims, write_claims};
pub use evaluation::{EvaluatedRun, counters, evaluate};
pub use execution::{Executed, ExecutedRun, Progress, execute};
pub use experiment::{Experiment, PlannedRun, phase_ensemble, scheme_options};
pub use provenance::Provenance;
pub use reference::{DIVERGENCE_FACTOR, Reference};
pub use results::write_results;
pub use run::{RunResult, RunSpec, parse_mechanics_steps, simulate};
pub use spectral::spectral_radius;
