//! From an experiment file to runs to CSV. Files, threads and progress live here only.
//!
//! [`Experiment`] is the file, [`Experiment::plan`] makes it a list of [`RunSpec`]s, [`run_job`] runs what is missing in
//! parallel, against cached [`Reference`]s and into a [`Store`] that survives being killed, and exports the result files;
//! [`check_claims`] holds what the file claims against what came out.

mod build_info;
mod cache;
mod choices;
mod claims;
mod comparison;
mod evaluation;
mod execution;
mod experiment;
mod grid;
mod provenance;
mod reference;
mod results;
mod run;
mod spectral;
mod stability;
mod store;

pub use build_info::BuildInfo;
pub use cache::Cache;
pub use choices::{Choices, scheme_options};
pub use claims::{CheckedClaim, Claim, Verdict, check_claims, write_claims};
pub use comparison::{Comparison, ComparisonRow, compare};
pub use evaluation::{COUNTERS, EvaluatedRun, evaluate};
pub use execution::{Job, Progress, Summary, collect_shards, run_job};
pub use experiment::{Experiment, PlannedRun};
pub use grid::phase_ensemble;
pub use provenance::Provenance;
pub use reference::{DIVERGENCE_FACTOR, Reference};
pub use run::{RunResult, RunSpec, parse_mechanics_steps, simulate};
pub use spectral::spectral_radius;
pub use stability::{StabilityLimit, StabilityPoint, logarithmic_grid, spectral_stability_limit, stability_limit};
pub use store::{Record, Store};
