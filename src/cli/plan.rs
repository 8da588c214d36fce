//! `rimbench plan`: the runs of an experiment, without running them.

use super::{print, table};
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::harness::Experiment;
use rimbench::runs::Fact;
use std::path::PathBuf;

/// Arguments of `plan`.
#[derive(Debug, Args)]
pub struct Plan {
    /// Experiment file (see experiments/README.md)
    file: PathBuf,
    /// Show all runs, however many
    #[arg(long)]
    all: bool,
}

/// Runs that are shown unless all are asked for.
const SHOWN: usize = 40;

impl Plan {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let experiment = Experiment::read(&self.file)?;
        let planned = experiment.plan(catalogue, false)?;
        print(&format!("{}\n", experiment.question))?;
        print(&format!("{} runs, {} claims", planned.len(), experiment.claims().len()))?;
        let facts: Vec<Vec<Fact>> = planned.iter().map(|run| run.spec.facts()).collect();
        // What is the same in all runs is said once.
        let varies = |column: &usize| facts.iter().any(|of_run| of_run[*column] != facts[0][*column]);
        let (varying, common): (Vec<usize>, Vec<usize>) = (0..facts[0].len()).partition(varies);
        let said = |column: &usize| Some(&facts[0][*column]).filter(|fact| !fact.cell().is_empty());
        let common = common.iter().filter_map(said).map(|fact| format!("{} = {}", fact.name, fact.cell()));
        print(&format!("In all runs: {}\n", common.collect::<Vec<_>>().join(", ")))?;
        let mut header = vec!["run id", "label"];
        header.extend(varying.iter().map(|&column| facts[0][column].name));
        let mut table = table(&header);
        let shown = if self.all || planned.len() <= SHOWN + 1 { planned.len() } else { SHOWN };
        for (run, facts) in planned.iter().zip(&facts).take(shown) {
            let mut row = vec![run.id.clone(), run.label.clone()];
            row.extend(varying.iter().map(|&column| facts[column].cell()));
            table.add_row(row);
        }
        print(&table.to_string())?;
        if shown < planned.len() {
            print(&format!("… and {} more: --all shows them", planned.len() - shown))?;
        }
        Ok(())
    }
}
