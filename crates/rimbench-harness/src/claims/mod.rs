//! Claims: what an experiment file says should come out, held against what did.
//!
//! ```text
//! a claim of an experiment → what each run says of it (witnesses) → what was measured (measured) → claims.csv
//!                          → held against the summary (kept)
//! ```

mod kept;
mod measured;
mod witnesses;

pub use kept::{KeptClaims, check_kept_claims};
pub use rimbench_results::claims::{CheckedClaim, write_claims};

use super::checked_results::checked_runs;
use super::experiment::Experiment;
use rimbench_cases::catalogue::Catalogue;
use rimbench_core::error::Result;
use rimbench_statistics::ResultsTable;
use std::path::Path;

/// Checks all claims of an experiment against the results in its folder, which must hold the runs of its plan, or of its quick
/// plan; claims about macro steps that are not in that one come back as not measured.
///
/// # Errors
/// [`Error::File`](rimbench_core::error::Error::File) for results that are not there, not whole, or not as they were written.
pub fn check_claims(experiment: &Experiment, catalogue: &Catalogue, folder: &Path) -> Result<Vec<CheckedClaim>> {
    measured_in(experiment, &checked_runs(experiment, catalogue, folder, false)?)
}

/// Does the same for a job that this process has just finished, while others may be finishing it.
///
/// # Errors
/// [`Error::File`](rimbench_core::error::Error::File) for results that have gone, or are not whole.
pub fn check_fresh_claims(experiment: &Experiment, catalogue: &Catalogue, folder: &Path) -> Result<Vec<CheckedClaim>> {
    measured_in(experiment, &checked_runs(experiment, catalogue, folder, true)?)
}

fn measured_in(experiment: &Experiment, runs: &ResultsTable) -> Result<Vec<CheckedClaim>> {
    experiment.claims().iter().map(|claim| measured::check(claim, &experiment.name(), runs)).collect()
}
