//! `rimbench run --dry-run`: the runs of an experiment, without running them.

use super::json::Object;
use super::number::counted;
use super::screen::{Table, paragraph};
use super::{Format, print, print_json};
use rimbench::catalogue::Catalogue;
use rimbench::harness::{Experiment, MOST_RUNS, PlannedRun};
use rimbench::runs::Fact;
use serde_json::Value;
use std::collections::BTreeMap;

/// Runs that are shown unless all are asked for.
const SHOWN: usize = 40;

/// Prints the plan: as a table of some runs or of all, or as JSON, which has all.
pub(super) fn show(experiment: &Experiment, catalogue: &Catalogue, all: bool, format: Format) -> anyhow::Result<()> {
    let size = experiment.size(false)?;
    if size > MOST_RUNS && !all && format == Format::Table {
        return show_parts(experiment, catalogue, size);
    }
    let planned = experiment.plan(catalogue, false)?;
    if format == Format::Json {
        return print_json(&json(experiment, &planned));
    }
    print(&format!("{}\n", paragraph(&experiment.question, 0)))?;
    print(&[counted(planned.len(), "run"), counted(experiment.claims().len(), "claim")].join(", "))?;
    let facts: Vec<Vec<Fact>> = planned.iter().map(|run| run.spec.facts()).collect();
    // What is the same in all runs is said once.
    let varies = |column: &usize| facts.iter().any(|of_run| of_run[*column] != facts[0][*column]);
    let (varying, common): (Vec<usize>, Vec<usize>) = (0..facts[0].len()).partition(varies);
    let said = |column: &usize| Some(&facts[0][*column]).filter(|fact| !fact.cell().is_empty());
    // What the label of a scheme row says is not said again.
    let by_label = |column: &usize| {
        let mut known: BTreeMap<&str, String> = BTreeMap::new();
        planned.iter().zip(&facts).all(|(run, facts)| {
            let cell = facts[*column].cell();
            *known.entry(&run.label).or_insert_with(|| cell.clone()) == cell
        })
    };
    let varying: Vec<usize> = varying.into_iter().filter(|column| !by_label(column)).collect();
    let common = common.iter().filter_map(said).map(|fact| format!("{} = {}", fact.name, fact.cell()));
    print(&format!("{}\n", paragraph(&format!("In all runs: {}", common.collect::<Vec<_>>().join(", ")), 0)))?;
    let mut header = vec!["run id", "label"];
    header.extend(varying.iter().map(|&column| facts[0][column].name));
    let mut table = Table::new(&header);
    let shown = if all || planned.len() <= SHOWN + 1 { planned.len() } else { SHOWN };
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

/// Lays out all parts of a plan that is too large to be shown at once, and prints how many runs it has.
fn show_parts(experiment: &Experiment, catalogue: &Catalogue, size: usize) -> anyhow::Result<()> {
    for part in experiment.parts(catalogue, false, 0..size) {
        part?;
    }
    print(&format!("{}\n", paragraph(&experiment.question, 0)))?;
    print(&format!(
        "{}, {}: more than are shown or written to tables at once, each checked. Run parts: --places FIRST-LAST, --shard I/N or --slurm",
        counted(size, "run"),
        counted(experiment.claims().len(), "claim")
    ))
}

/// The plan for programs: each run with its id, its place (shards take every n-th from a place on), and what determines
/// it.
fn json(experiment: &Experiment, planned: &[PlannedRun]) -> Value {
    let run = |(place, run): (usize, &PlannedRun)| {
        let mut object = Object::default();
        object.put("place", place);
        object.put("run_id", run.id.as_str());
        object.put("label", run.label.as_str());
        run.spec.facts().iter().for_each(|fact| object.fact(fact));
        Value::from(object)
    };
    let mut object = Object::default();
    object.put("experiment", experiment.name());
    object.put("question", experiment.question.as_str());
    object.put("claims", experiment.claims().len());
    object.put("runs", planned.iter().enumerate().map(run).collect::<Vec<_>>());
    object.into()
}
