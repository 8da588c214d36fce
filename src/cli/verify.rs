//! `rimbench verify`: claims against stored results.

use super::project::Project;
use super::{claims_table, print};
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::checksums::CHECKSUMS;
use rimbench::harness::{check_claims, check_kept_claims};
use rimbench::kept::DIGEST;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `verify`.
#[derive(Debug, Args)]
pub struct Verify {
    /// Experiment files
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Where results are: <DIR>/<group>/<name>
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
}

impl Verify {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        let (mut claims, mut faults) = (Vec::new(), Vec::new());
        // Without rows what is kept of them can be held against itself.
        let (mut kept, mut by_summary) = (0, 0);
        for file in &self.files {
            let checked = Project::experiment(file).and_then(|experiment| {
                let folder = experiment.results_folder(&self.results);
                let sealed = [CHECKSUMS, "runs.csv"].map(|name| folder.join(name).exists());
                if sealed == [false; 2] && !folder.join(DIGEST).exists() || sealed[0] {
                    return check_claims(&experiment, catalogue, &folder);
                }
                let found = check_kept_claims(&experiment, &folder)?;
                kept += found.claims.len();
                by_summary += found.said_by_summary;
                Ok(found.claims)
            });
            // What is wrong with one file leaves the claims of the others.
            match checked {
                Ok(own) => claims.extend(own),
                Err(error) => faults.push(error),
            }
        }
        if let ([_], []) = (&self.files[..], &claims[..])
            && let Some(error) = faults.pop()
        {
            return Err(error.into());
        }
        if !claims.is_empty() {
            print(&claims_table(&claims))?;
        }
        let changed = claims.iter().filter(|claim| claim.differs()).count();
        let not = match faults.len() {
            0 => String::new(),
            count => format!("; those of {count} of {} files could not be checked", self.files.len()),
        };
        print(&format!("{} claims, {changed} differ from the recorded finding{not}", claims.len()))?;
        if kept > 0 {
            print(&format!(
                "{kept} of them are as they were last measured, {by_summary} of these as the summaries say: the rows are not here; \
                 `rimbench reproduce --everything` makes them"
            ))?;
        }
        for error in &faults {
            eprintln!("error: {error}");
        }
        Ok(match (faults.is_empty(), changed) {
            (false, _) => ExitCode::from(2),
            (true, 0) => ExitCode::SUCCESS,
            (true, _) => ExitCode::FAILURE,
        })
    }
}
