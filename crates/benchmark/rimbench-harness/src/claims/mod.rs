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
pub use rimbench_results::claims::{CheckedClaim, claims_score, write_claims};

use super::checked_results::{Trust, checked_runs};
use super::experiment::Experiment;
use rimbench_core::error::Result;
use rimbench_results::checksums::CHECKSUMS;
use rimbench_results::kept::DIGEST;
use rimbench_results::run_table::RunTable;
use rimbench_runs::catalogue::Catalogue;
use std::path::Path;

/// Checks all claims of an experiment against the results in its folder, which must hold the runs of its plan, or of
/// its quick plan; claims about macro steps that are not in that one come back as not measured.
///
/// # Errors
/// [`Error::File`](rimbench_core::error::Error::File) for results that are not there, not whole, or not as they were
/// written.
pub fn check_claims(experiment: &Experiment, catalogue: &Catalogue, folder: &Path) -> Result<Vec<CheckedClaim>> {
    measured_in(experiment, &checked_runs(experiment, catalogue, folder, Trust::Sealed)?)
}

/// Does the same for a job that this process has just finished, while others may be finishing it.
///
/// # Errors
/// [`Error::File`](rimbench_core::error::Error::File) for results that have gone, or are not whole.
pub fn check_fresh_claims(experiment: &Experiment, catalogue: &Catalogue, folder: &Path) -> Result<Vec<CheckedClaim>> {
    measured_in(experiment, &checked_runs(experiment, catalogue, folder, Trust::Fresh)?)
}

/// Checks the claims of an experiment and everything in its folder that something else there determines: files against
/// checksums and digest, `runs.csv` against the plan and the stored rows, the summary and the written claims against
/// `runs.csv`. Where there are no rows, what is kept of them is held against itself.
///
/// # Errors
/// [`Error::File`](rimbench_core::error::Error::File) naming the file that is missing, or says something else than what
/// it is made from.
pub fn verify_results(experiment: &Experiment, catalogue: &Catalogue, folder: &Path) -> Result<VerifiedClaims> {
    if !folder.join("runs.csv").exists() && !folder.join(CHECKSUMS).exists() && folder.join(DIGEST).exists() {
        let kept = check_kept_claims(experiment, catalogue, folder)?;
        return Ok(VerifiedClaims { claims: kept.claims, from_rows: false });
    }
    let claims = measured_in(experiment, &checked_runs(experiment, catalogue, folder, Trust::Nothing)?)?;
    kept::check_written(experiment, folder, &claims)?;
    Ok(VerifiedClaims { claims, from_rows: true })
}

/// Claims with where their numbers come from.
#[derive(Debug)]
pub struct VerifiedClaims {
    /// The claims, in the order of the experiment.
    pub claims: Vec<CheckedClaim>,
    /// Whether they were measured now, and not only read.
    pub from_rows: bool,
}

fn measured_in(experiment: &Experiment, runs: &RunTable) -> Result<Vec<CheckedClaim>> {
    let draw_of = |problem: [&str; 2]| experiment.draw_of(problem);
    experiment.claims().iter().map(|claim| measured::check(claim, &experiment.name(), runs, &draw_of)).collect()
}
