//! `rimbench plan`: the runs of an experiment, without running them.

use super::{print, table};
use clap::Args;
use rimbench::harness::Experiment;
use std::path::PathBuf;

/// Arguments of `plan`.
#[derive(Debug, Args)]
pub struct Plan {
    /// Experiment file (see experiments/README.md)
    file: PathBuf,
}

impl Plan {
    pub(super) fn run(self) -> anyhow::Result<()> {
        let experiment = Experiment::read(&self.file)?;
        let planned = experiment.plan(false)?;
        print(&format!("{}\n", experiment.question))?;
        let mut table = table(&["run id", "case", "set", "label", "H (ms)", "phase", "sequence", "force return"]);
        for run in &planned {
            let spec = &run.spec;
            table.add_row([
                spec.id(),
                spec.case.name.to_owned(),
                run.set.clone(),
                run.label.clone(),
                format!("{:.6}", spec.macro_step * 1e3),
                format!("{:.6}", spec.phase),
                spec.sequence.to_string(),
                spec.force_return.to_string(),
            ]);
        }
        print(&table.to_string())?;
        print(&format!("{} runs, {} claims", planned.len(), experiment.claims().len()))
    }
}
