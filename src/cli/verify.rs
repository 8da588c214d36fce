//! `rimbench verify`: claims against stored results.

use super::{claims_table, print};
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::harness::{Experiment, check_claims};
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
        let mut claims = Vec::new();
        for file in &self.files {
            let experiment = Experiment::read(file)?;
            claims.extend(check_claims(&experiment, catalogue, &experiment.results_folder(&self.results))?);
        }
        print(&claims_table(&claims))?;
        let changed = claims.iter().filter(|claim| claim.differs()).count();
        print(&format!("{} claims, {changed} differ from the recorded finding", claims.len()))?;
        Ok(if changed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}
