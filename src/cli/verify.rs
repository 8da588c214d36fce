//! `rimbench verify`: claims against stored results.

use super::number::counted;
use super::project::Project;
use super::screen::{Mood, verdict};
use super::{Format, claims_list, print, print_json};
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::harness::{CheckedClaim, Verdict, verify_results};
use rimbench::kept::DIGEST;
use std::collections::HashSet;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `verify`.
#[derive(Debug, Args)]
pub struct Verify {
    /// Experiment files
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Every claim, not only those that differ
    #[arg(long)]
    all: bool,
    /// Where results are: <DIR>/<group>/<name>, or the folder that `run --out` wrote
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// How to print; for programs all claims
    #[arg(long, value_enum, default_value_t = Format::Table, conflicts_with = "all")]
    format: Format,
}

impl Verify {
    pub(super) fn run(mut self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        // A file that is given twice has its claims once.
        let mut seen = HashSet::new();
        self.files.retain(|file| seen.insert(file.clone()));
        let (mut claims, mut faults) = (Vec::new(), Vec::new());
        // Without rows, claims are checked against the summary that is kept.
        let mut kept = 0;
        for file in &self.files {
            let checked = Project::experiment(file).and_then(|experiment| {
                let usual = experiment.results_folder(&self.results);
                // What `run --out` wrote is not in folders by group and name.
                let is_own =
                    !usual.exists() && ["runs.csv", DIGEST].iter().any(|name| self.results.join(name).exists());
                let found = verify_results(&experiment, catalogue, if is_own { &self.results } else { &usual })?;
                kept += if found.from_rows { 0 } else { found.claims.len() };
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
        let shown: Vec<CheckedClaim> = claims.iter().filter(|claim| self.all || claim.differs()).cloned().collect();
        let changed = claims.iter().filter(|claim| claim.differs()).count();
        let is_new = |claim: &&CheckedClaim| claim.finding == Verdict::NotMeasured && claim.verdict != claim.finding;
        let new = claims.iter().filter(is_new).count();
        let mut said = match changed {
            0 if new > 0 => format!("{}: of {new} no verdict is recorded", counted(claims.len(), "claim")),
            0 => format!("{}: every verdict is the recorded one", counted(claims.len(), "claim")),
            changed => format!("{}: {} from the recorded verdict", counted(claims.len(), "claim"), differing(changed)),
        };
        if kept > 0 {
            said += &format!(" ({kept} from summaries)");
        }
        if !faults.is_empty() {
            said += &format!("; {} of {} could not be checked", faults.len(), counted(self.files.len(), "file"));
        }
        let is_read = self.format == Format::Table;
        if !is_read {
            print_json(&serde_json::to_value(&claims)?)?;
        } else if !shown.is_empty() {
            print(&claims_list(&shown))?;
        }
        let mood = if changed > 0 {
            Mood::Bad
        } else if faults.is_empty() && new == 0 {
            Mood::Good
        } else {
            Mood::Open
        };
        if is_read {
            print(&verdict(&said, mood))?;
        }
        for error in &faults {
            eprintln!("{}", super::screen::error(&error.to_string(), &[], &[]));
        }
        Ok(match (faults.is_empty(), changed) {
            (false, _) => ExitCode::from(2),
            (true, 0) => ExitCode::SUCCESS,
            (true, _) => ExitCode::FAILURE,
        })
    }
}

fn differing(count: usize) -> String {
    if count == 1 { "1 differs".to_owned() } else { format!("{count} differ") }
}
