//! From an experiment file to runs to result files, claims, limits and advice. Threads and clock live here only.
//!
//! [`Experiment`] is the file, [`Experiment::plan`] makes it a list of [`RunSpec`](rimbench_runs::RunSpec)s,
//! [`run_job`] runs what is missing in parallel, against cached references and into a [`Store`] that survives being
//! killed, and exports the result files; [`check_claims`] holds what the file claims against what came out.

mod advice;
mod build_info;
mod cache;
mod checked_results;
mod claims;
mod clock;
mod deadline_log;
mod execution;
mod experiment;
mod folder;
mod grid;
mod job;
mod open;
mod provenance;
mod ranking;
mod references;
mod results;
mod run_row;
mod slurm;
mod spectral;
mod stability;
mod store;

pub use advice::{
    Advice, Choice, Information, METRIC, Question, USUAL_PRICES, advise, as_a_master, budget_of, prices_of,
    share_of_peak, steps_to_try,
};
pub use build_info::BuildInfo;
pub use cache::Cache;
pub use claims::{
    CheckedClaim, KeptClaims, VerifiedClaims, check_claims, check_fresh_claims, check_kept_claims, claims_score,
    verify_results, write_claims,
};
pub use clock::{monotonic_clock, processor_clock};
pub use deadline_log::DeadlineLog;
pub use execution::{prepare_folder, run_job, run_job_until};
pub use experiment::{Claim, Claimant, Experiment, PlannedRun, Verdict, named_python};
pub use folder::collect_shards;
pub use grid::{MOST_PLANNED, MOST_RUNS, logarithmic_grid, phase_ensemble};
pub use job::{Job, Progress, Shard, Step, StopFlags, Summary};
pub use open::{
    Division, ENTRY, Entry, Evidence, Judged, Packs, Problem, ProblemRow, SCORES, judge, meaning, pack_files,
};
pub use provenance::{Provenance, RunOrigin};
pub use ranking::{PROBLEMS, RULES, Ranked, Ranking};
pub use references::obtain_reference;
pub use run_row::{Asked, RunRow, TraceMark};
pub use slurm::{Chunk, ChunkLimits, Chunking, SBATCH, SlurmArray, Submission, in_shell, missing_chunks, next_place};
pub use spectral::spectral_radius;
pub use stability::{
    Instability, LimitSearch, Scan, StabilityLimit, StabilityPoint, StepVerdict, longest_macro_step,
    predicted_stability_limit, shortest_macro_step, spectral_stability_limit, stability_limit,
};
pub use store::{Damaged, Store};
