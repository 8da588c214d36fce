//! From records to result files: what of a plan is stored, by whichever process, and the tables where that is all of it.
//!
//! The plan is gone through twice, a few thousand runs at a time, and never held: once for what is missing, once for the rows. What
//! grows with it is the index of the store (40 bytes per run), the ids that tell runs that are there twice (8 bytes), the places of
//! what is missing, and the names of traces.

use super::execution::{Job, Summary};
use super::experiment::PlannedRun;
use super::foreign::refuse_foreign;
use super::references::obtain_reference;
use super::results;
use super::stock::Stock;
use rimbench_cases::runs::{Reference, RunSpec};
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result};
use std::path::Path;
use std::time::Duration;

/// Missing runs that are told one by one.
const TOLD: usize = 20;

/// What of a plan is stored.
#[derive(Debug, Default)]
pub(super) struct Inventory {
    /// Runs of the plan.
    pub(super) planned: usize,
    /// Places of those that are still to be computed.
    pub(super) missing: Vec<usize>,
    /// The first of these.
    told: Vec<PlannedRun>,
    /// Of each reference the run that may take longest: the reference may take as long.
    of_references: Vec<RunSpec>,
    /// Files of the traces that are asked for.
    traces: Vec<String>,
    /// Stored runs that are not of the plan.
    unplanned: usize,
}

impl Inventory {
    /// Goes through the plan of a job.
    fn take(job: &Job<'_>, stock: &Stock<'_>) -> Result<Self> {
        let mut found = Inventory::default();
        let mut ids: Vec<u64> = Vec::new();
        let mut stored = 0;
        job.experiment.plan_in_blocks(job.catalogue, job.quick, &mut |first, runs| {
            found.planned += runs.len();
            for (place, run) in (first..).zip(runs) {
                ids.push(u64::from_str_radix(&run.id, 16).unwrap_or_default());
                found.note_reference(&run.spec);
                stored += usize::from(stock.store.allowed_s(&run.id).is_some());
                if job.experiment.trace_of(&run.label).is_some() {
                    found.traces.push(results::trace_name(&run.id));
                }
                if stock.has(run)? {
                    continue;
                }
                found.missing.push(place);
                if found.told.len() < TOLD {
                    found.told.push(run.clone());
                }
            }
            Ok(())
        })?;
        ids.sort_unstable();
        if ids.windows(2).any(|pair| pair[0] == pair[1]) {
            // It says which runs are the same, and where they stand.
            job.experiment.plan(job.catalogue, job.quick)?;
        }
        found.unplanned = stock.store.len().saturating_sub(stored);
        Ok(found)
    }

    /// Cases and parameters are the outer loops of a plan: runs of one reference are mostly neighbours, unless a case is named again
    /// behind others.
    fn note_reference(&mut self, spec: &RunSpec) {
        let patience = |spec: &RunSpec| spec.wall_limit.unwrap_or(Duration::MAX);
        match self.of_references.iter_mut().rev().find(|known| known.shares_reference_with(spec)) {
            Some(known) if patience(spec) > patience(known) => *known = spec.clone(),
            Some(_) => {}
            None => self.of_references.push(spec.clone()),
        }
    }
}

/// Copies the records of other folders into that of a job, writes the result files if all runs are there, and returns what was done
/// with the first of the runs that are missing, twenty at most.
///
/// # Errors
/// Folders that belong to something else; a disk that is full.
pub fn collect_shards(job: Job<'_>, folders: &[&Path]) -> Result<(Summary, Vec<PlannedRun>)> {
    let kinds = job.experiment.kinds(job.catalogue, job.quick)?;
    refuse_foreign(&job)?;
    job.experiment.copy_to(job.folder)?;
    let own = Stock::open(job.folder, job.experiment, &kinds)?;
    let mut summary = Summary { damaged: own.store.damaged, ..Summary::default() };
    if !folders.is_empty() {
        summary.computed = take_over(&job, &own, &kinds, folders, &mut summary.damaged)?;
    }
    drop(own);
    let found = export_if_complete(&job, None, StopFlag::never())?;
    summary.planned = found.planned;
    summary.missing = found.missing.len();
    summary.unplanned = found.unplanned;
    summary.reused = found.planned - found.missing.len() - summary.computed;
    Ok((summary, found.told))
}

/// Copies what a job's folder lacks from others, and says how many records that were.
fn take_over(
    job: &Job<'_>,
    own: &Stock<'_>,
    kinds: &[PlannedRun],
    folders: &[&Path],
    damaged: &mut usize,
) -> Result<usize> {
    let mut wanted = Inventory::take(job, own)?.missing;
    let mut count = 0;
    for folder in folders {
        let other = Stock::open(folder, job.experiment, kinds)?;
        *damaged += other.store.damaged;
        let mut still_wanted = Vec::new();
        let mut places = std::mem::take(&mut wanted).into_iter().peekable();
        job.experiment.plan_in_blocks(job.catalogue, job.quick, &mut |first, runs| {
            while let Some(place) = places.next_if(|place| *place < first + runs.len()) {
                let run = &runs[place - first];
                let record = if other.has(run)? { other.store.read(&run.id)? } else { None };
                let Some(record) = record else {
                    still_wanted.push(place);
                    continue;
                };
                results::copy_trace(folder, job.folder, &run.id)?;
                own.store.append(&record)?;
                count += 1;
            }
            Ok(())
        })?;
        wanted = still_wanted;
    }
    own.store.sync()?;
    Ok(count)
}

/// Writes the result files of an experiment if all its runs are stored; says what is.
///
/// `held` is a reference that is at hand, with a run that it belongs to.
pub(super) fn export_if_complete(
    job: &Job<'_>,
    mut held: Option<(RunSpec, Reference)>,
    stop: StopFlag<'_>,
) -> Result<Inventory> {
    let kinds = job.experiment.kinds(job.catalogue, job.quick)?;
    let stock = Stock::open(job.folder, job.experiment, &kinds)?;
    let mut found = Inventory::take(job, &stock)?;
    if !found.missing.is_empty() {
        return Ok(found);
    }
    results::write_tables(job.folder, job.experiment, &kinds, &stock.store, |take| {
        job.experiment.plan_in_blocks(job.catalogue, job.quick, &mut |_, runs| take(runs))
    })?;
    let references = found.of_references.iter().map(|spec| {
        if let Some((_, reference)) = held.take_if(|held| held.0.shares_reference_with(spec)) {
            return Ok((spec, Some(reference)));
        }
        match obtain_reference(spec, job.cache, stop) {
            Err(Error::Overdue { .. }) => Ok((spec, None)),
            found => Ok((spec, Some(found?))),
        }
    });
    let of_references = results::write_references(job.folder, references, job.experiment.trace_every_s)?;
    results::write_checksums(job.folder, std::mem::take(&mut found.traces).into_iter().chain(of_references))?;
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Experiment;
    use rimbench_cases::catalogue::Catalogue;

    #[test]
    fn a_case_that_is_named_again_behind_another_has_one_reference() {
        let text = "question = \"?\"\nmacro_steps_s = [1e-3]\n[[cases]]\nname = \"linear-oscillator\"\n[[cases]]\n\
                    name = \"bouncing-ball\"\n[[schemes]]\nscheme = \"zero-order-hold\"\n";
        let experiment = Experiment::parse("a.toml".as_ref(), text.to_owned()).unwrap();
        let plan = experiment.plan(&Catalogue::standard(), false).unwrap();
        let mut found = Inventory::default();
        let limited = RunSpec { wall_limit: Some(Duration::from_secs(1)), ..plan[0].spec.clone() };
        for spec in [&limited, &plan[1].spec, &plan[0].spec, &plan[1].spec, &limited] {
            found.note_reference(spec);
        }
        let names: Vec<_> = found.of_references.iter().map(|spec| &*spec.case.name).collect();
        assert_eq!(names, ["linear-oscillator", "bouncing-ball"]);
        // The one that may take longest stands for them.
        assert_eq!(found.of_references[0].wall_limit, None);
    }
}
